"""Error of the range estimates, from one decision drawn of each encounter."""

from functools import partial
from math import sqrt

import numpy as np

from rss_gym.eval.intervals import Interval, mean_t, quantile_order_statistics
from rss_gym.eval.metrics.metric import Flights, Metric


def range_error(flights: Flights, q: float) -> Interval:
    """Quantile of |estimated - true range|, in m; 80 % is the paper's figure (delta = 4 m, Fig. 5).

    From the flights of `none`, one decision an encounter: errors within a flight are correlated, these are
    independent. Order statistics.
    """
    error_m = np.abs(flights.none["sample_range_m"] - flights.none["sample_separation_m"])
    return quantile_order_statistics(error_m, q, lowest=0.0)


def range_rmse(flights: Flights) -> Interval:
    """Root mean square of the same errors, in m; Student's t on the squares."""
    square = mean_t((flights.none["sample_range_m"] - flights.none["sample_separation_m"]) ** 2)
    value, low, high = (None if x is None else sqrt(max(0.0, x)) for x in square[:3])
    return Interval(value, low, high, square.n)


RANGE_ERROR_P50_M = Metric("range error of a decision, median", "m", partial(range_error, q=0.5), sensor=True)
RANGE_ERROR_P80_M = Metric("range error of a decision, 80 % quantile", "m", partial(range_error, q=0.8), sensor=True)
RANGE_RMSE_M = Metric("range error of a decision, root mean square", "m", range_rmse, sensor=True)
