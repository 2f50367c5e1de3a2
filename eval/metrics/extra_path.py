"""Length flown beyond that of the predefined trajectory."""

from rss_gym.eval.intervals import Interval, mean_t
from rss_gym.eval.metrics.metric import ONE, Flights, Metric


def extra_path(flights: Flights) -> Interval:
    """Mean of (length flown) / (length of the predefined trajectory) - 1.

    Over the encounters that policy and reference both end without collision; those without a planned length (a hover)
    are left out. Student's t; undefined without a reference.
    """
    rows = flights.table[flights.completed & (flights.table["planned_m"] > 0.0)]
    return mean_t(rows["flown_m"] / rows["planned_m"] - 1.0)


EXTRA_PATH = Metric("length flown / length planned - 1, mean over encounters both complete", ONE, extra_path)
