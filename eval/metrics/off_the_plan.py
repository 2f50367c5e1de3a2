"""The two parts of the deviation on a road: off the planned lane, and off the planned speed."""

from functools import partial

from rss_gym.eval.intervals import Interval, mean_t
from rss_gym.eval.metrics.metric import Flights, Metric


def mean(flights: Flights, column: str) -> Interval:
    """Mean over drives of the mean over the decisions driven. Student's t."""
    return mean_t(flights.table[column])


LANE_DEVIATION_M = Metric(
    "distance from the centre of the planned lane, mean over the decisions driven",
    "m",
    partial(mean, column="lane_deviation_m"),
    domains=("road",),
)
SPEED_DEVIATION_MPS = Metric(
    "difference from the planned speed, mean over the decisions driven",
    "m/s",
    partial(mean, column="speed_deviation_mps"),
    domains=("road",),
)
