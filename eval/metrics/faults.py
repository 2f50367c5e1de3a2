"""Flights that the policy broke."""

import numpy as np

from rss_gym.eval.intervals import Interval
from rss_gym.eval.metrics.metric import Flights, Metric


def faults(flights: Flights) -> Interval:
    """Number of encounters in which the policy raised, or gave an action of wrong shape or not finite; exact."""
    count = float(np.count_nonzero(flights.table["fault"]))
    return Interval(count, count, count, len(flights))


FAULTS = Metric(
    "encounters in which the policy raised or gave no valid action; any bars it from the ranking", "count", faults
)
