"""How long before a conflict the first warning comes, and how often none comes."""

from functools import partial

from rss_gym.eval.intervals import Interval, quantile_order_statistics
from rss_gym.eval.metrics.metric import ONE, Flights, Metric, share


def alert_lead_time(flights: Flights, q: float) -> Interval:
    """Quantile of the time from the policy's first warning to the closest approach that `none` would have had, in s.

    Over the conflicts (encounters in which `none` enters sNMAC) in which the policy's flight is warned; a warning
    after that time counts with its negative lead. The closest approach is that of `none`, so that a policy which stays
    further away, or turns back, is not credited with another time to act. Order statistics.
    """
    conflict, warned_s = flights.none["snmac"], flights.table["warned_s"]
    lead_s = flights.none["closest_s"] - warned_s
    return quantile_order_statistics(lead_s[conflict & (warned_s >= 0.0)], q)


def never_alerted_rate(flights: Flights) -> Interval:
    """Share of the conflicts (encounters in which `none` enters sNMAC) in which the policy's flight has no warning.

    A policy that keeps clear of the zone before any warning counts too: read it beside `zone_violation_rate`.
    Clopper-Pearson; `n` is the number of conflicts.
    """
    return share(flights.table["warned_s"][flights.none["snmac"]] < 0.0)


ALERT_LEAD_TIME_P50_S = Metric(
    "time from first warning to `none`'s closest approach in conflicts, median", "s", partial(alert_lead_time, q=0.5)
)
ALERT_LEAD_TIME_P5_S = Metric(
    "time from first warning to `none`'s closest approach in conflicts, 5 % quantile",
    "s",
    partial(alert_lead_time, q=0.05),
)
NEVER_ALERTED_RATE = Metric("share of conflicts without any warning", ONE, never_alerted_rate)
