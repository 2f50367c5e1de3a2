"""Manoeuvres where none was needed."""

from rss_gym.eval.intervals import Interval
from rss_gym.eval.metrics.metric import ONE, Flights, Metric, share

MANOEUVRE_M = 3.0  # displacement from the flight of `none` that counts as a manoeuvre


def unnecessary_manoeuvre_rate(flights: Flights) -> Interval:
    """Among the encounters in which `none` keeps clear of sNMAC: share in which the policy leaves its path.

    A manoeuvre is a distance of more than 3 m between the policy's and `none`'s position at one time; gusts are the
    same in both flights. Clopper-Pearson; `n` is the number of encounters in which `none` keeps clear.
    The rate is one that detect-and-avoid practice asks for; the limit of 3 m is ours.
    """
    return share(flights.table["manoeuvre_m"][~flights.none["snmac"]] > MANOEUVRE_M)


UNNECESSARY_MANOEUVRE_RATE = Metric(
    "share of encounters with a manoeuvre among those in which `none` keeps clear of sNMAC",
    ONE,
    unnecessary_manoeuvre_rate,
)
