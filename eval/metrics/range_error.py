"""Error of the range estimates, from one decision drawn of each encounter."""

from functools import partial
from math import sqrt

import numpy as np

from rss_gym.eval.intervals import Interval, mean_t, quantile_order_statistics
from rss_gym.eval.metrics.metric import Flights, Metric


def errors_m(flights: Flights) -> np.ndarray:
    """Estimated minus true range in the flights of `none`, one decision an encounter, where that was reached."""
    none = flights.none[flights.none["sample_range_m"] > 0.0]
    return np.asarray(none["sample_range_m"] - none["sample_separation_m"])


def range_error(flights: Flights, q: float) -> Interval:
    """Quantile of |estimated - true range|, in m; 80 % is the paper's figure (delta = 4 m, Fig. 5).

    From the flights of `none`, one decision an encounter: errors within a flight are correlated, these are
    independent. Order statistics.
    """
    return quantile_order_statistics(np.abs(errors_m(flights)), q, lowest=0.0)


def range_rmse(flights: Flights) -> Interval:
    """Root mean square of the same errors, in m; Student's t on the squares."""
    square = mean_t(errors_m(flights) ** 2)
    value, low, high = (None if x is None else sqrt(max(0.0, x)) for x in square[:3])
    return Interval(value, low, high, square.n)


RANGE_ERROR_P50_M = Metric("range error of a decision, median", "m", partial(range_error, q=0.5), sensor=True)
RANGE_ERROR_P80_M = Metric("range error of a decision, 80 % quantile", "m", partial(range_error, q=0.8), sensor=True)
RANGE_RMSE_M = Metric("range error of a decision, root mean square", "m", range_rmse, sensor=True)
