"""How deep flights go into the safety zone, and for how long."""

from rss_gym.eval.intervals import Interval, mean_t
from rss_gym.eval.metrics.metric import ONE, Flights, Metric


def zone_severity(flights: Flights) -> Interval:
    """Mean over encounters of the mean over the time flown of max(0, 1 - separation / S).

    0 is outside the zone, 1 in contact, all the time. After the severity of loss of well clear (SLoWC) of MIT-LL's
    degas-core, on the zone of (40) and over the whole flight. Student's t.
    """
    return mean_t(flights.table["zone_severity"])


ZONE_SEVERITY = Metric(
    "depth in the safety zone (0 outside, 1 in contact), mean over the time flown",
    ONE,
    zone_severity,
    domains=("air",),  # no zone of a road is of fixed radius
)
