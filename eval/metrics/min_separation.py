"""Quantiles of the least separation."""

from functools import partial

from rss_gym.eval.intervals import Interval, quantile_order_statistics
from rss_gym.eval.metrics.metric import Flights, Metric


def min_separation(flights: Flights, q: float) -> Interval:
    """Quantile over encounters of the least true separation, in m. Order statistics; 0 where none bounds it below."""
    return quantile_order_statistics(flights.table["min_separation_m"], q, lowest=0.0)


MIN_SEPARATION_P0_1_M = Metric("least separation, 0.1 % quantile", "m", partial(min_separation, q=0.001))
MIN_SEPARATION_P1_M = Metric("least separation, 1 % quantile", "m", partial(min_separation, q=0.01))
MIN_SEPARATION_P5_M = Metric("least separation, 5 % quantile", "m", partial(min_separation, q=0.05))
MIN_SEPARATION_P50_M = Metric("least separation, median", "m", partial(min_separation, q=0.5))
