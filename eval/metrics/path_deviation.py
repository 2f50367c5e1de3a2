"""Distance from the predefined trajectory, |u - u^d|, while flown."""

from rss_gym.eval.intervals import Interval, mean_t
from rss_gym.eval.metrics.metric import ONE, Flights, Metric, share

REGAINED_M = 10.0  # a flight that ends nearer to its path has regained it


def path_deviation_mean(flights: Flights) -> Interval:
    """Mean over encounters of the mean of |u - u^d| while flown, in m. Student's t.

    `none` is the floor of tracking. A flight that a collision ends early is not charged here but in `cost_m`.

    References
    ----------
    The first term of (42), as a mean.
    """
    return mean_t(flights.table["deviation_mean_m"])


def path_deviation_max(flights: Flights) -> Interval:
    """Mean over encounters of the greatest |u - u^d| while flown, in m. Student's t."""
    return mean_t(flights.table["deviation_max_m"])


def path_deviation_completed(flights: Flights) -> Interval:
    """Mean of the mean of |u - u^d|, in m, over the encounters that policy and reference end without collision.

    A figure over a policy's own completed flights rewards early crashes; this set is common to both. Student's t;
    undefined without a reference.
    """
    return mean_t(flights.table["deviation_mean_m"][flights.completed])


def path_regained_rate(flights: Flights) -> Interval:
    """Share of the flights without collision that end within 10 m of the path, as a mean over the last decision.

    Clopper-Pearson; `n` is the number of flights without collision.
    """
    return share(flights.table["deviation_end_m"][~flights.table["collision"]] < REGAINED_M)


PATH_DEVIATION_MEAN_M = Metric("distance from the predefined path, mean over the time flown", "m", path_deviation_mean)
PATH_DEVIATION_MAX_M = Metric("greatest distance from the predefined path, mean", "m", path_deviation_max)
PATH_DEVIATION_COMPLETED_M = Metric(
    "distance from the predefined path, mean over encounters that policy and reference complete",
    "m",
    path_deviation_completed,
)
PATH_REGAINED_RATE = Metric(
    "share of the flights without collision that end within 10 m of the predefined path", ONE, path_regained_rate
)
