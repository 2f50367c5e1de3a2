"""Distance from the predefined trajectory, |u - u^d|."""

import numpy as np

from rss_gym.eval.intervals import Interval, mean_t
from rss_gym.eval.metrics.metric import Flights, Metric

COLLIDED_M = 120.0  # the deviation from a collision on, so that crashing never pays; in every suite the same


def deviations_m(table: np.ndarray) -> np.ndarray:
    """Of each flight the time mean of |u - u^d| over the encounter's fixed length, 120 m from a collision on. (n,)."""
    lost_s = table["duration_s"] - table["flown_s"]
    deviations: np.ndarray = (table["deviation_mean_m"] * table["flown_s"] + COLLIDED_M * lost_s) / table["duration_s"]
    return deviations


def path_deviation_mean(flights: Flights) -> Interval:
    """Mean over encounters of the time mean of |u - u^d| over the encounter's fixed length, in m.

    From a collision on the deviation counts as 120 m. `none` is the floor of tracking. Student's t.

    References
    ----------
    The first term of (42), as a mean.
    """
    return mean_t(deviations_m(flights.table))


def path_deviation_max(flights: Flights) -> Interval:
    """Mean over encounters of the greatest |u - u^d|, in m; a collision counts with at least 120 m. Student's t."""
    rows = flights.table
    return mean_t(np.maximum(rows["deviation_max_m"], np.where(rows["collision"], COLLIDED_M, 0.0)))


def path_deviation_completed(flights: Flights) -> Interval:
    """Mean of the time mean of |u - u^d|, in m, over the encounters that policy and reference end without collision.

    A figure over a policy's own completed flights rewards early crashes; this set is common to both. Student's t;
    undefined without a reference.
    """
    return mean_t(flights.table["deviation_mean_m"][flights.completed])


PATH_DEVIATION_MEAN_M = Metric(
    "distance from the predefined path, mean over time (120 m after a collision)", "m", path_deviation_mean
)
PATH_DEVIATION_MAX_M = Metric(
    "greatest distance from the predefined path (at least 120 m with a collision), mean", "m", path_deviation_max
)
PATH_DEVIATION_COMPLETED_M = Metric(
    "distance from the predefined path, mean over encounters that policy and reference complete",
    "m",
    path_deviation_completed,
)
