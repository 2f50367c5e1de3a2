"""Shares of encounters with one of the three nested events, on true states."""

from functools import partial

from rss_gym.eval.intervals import Interval
from rss_gym.eval.metrics.metric import ONE, Flights, Metric, share


def event_rate(flights: Flights, event: str) -> Interval:
    """Share of the encounters in which the policy's flight has the event, with Clopper and Pearson's interval.

    Rates are per encounter of the suite's distribution, not per flight hour. The least separation is computed
    analytically within each tick, so that nothing passes between two of them.

    Parameters
    ----------
    flights : Flights
    event : str
        `collision`: separation < 4.5 m. `snmac`: < 15.24 m (50 ft) horizontally and < 4.57 m (15 ft) vertically at one
        instant, the small near mid-air collision of MIT-LL's sNMAC proposal. `zone`: separation < S of (40).
    """
    return share(flights.table[event])


COLLISION_RATE = Metric("share of encounters with a collision", ONE, partial(event_rate, event="collision"))
SNMAC_RATE = Metric(
    "share of encounters with a small near mid-air collision (sNMAC)", ONE, partial(event_rate, event="snmac")
)
ZONE_VIOLATION_RATE = Metric(
    "share of encounters in which the safety zone is entered", ONE, partial(event_rate, event="zone")
)
