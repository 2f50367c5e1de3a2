"""Missed detection: the intruder is inside the zone and the estimate says it is not; beside the paper's bound."""

from rss_gym.eval.intervals import Interval
from rss_gym.eval.metrics.metric import ONE, Flights, Metric, share


def missed_detection_decision_rate(flights: Flights) -> Interval:
    """P(true range <= S | estimated range > S), the left side of (34), per decision.

    From the flights of `none`, one decision drawn of each encounter, so that they are independent. Clopper-Pearson;
    `n` is the number of decisions with an estimate above S.
    """
    above = flights.none[flights.none["sample_range_m"] > flights.suite_radius_m]
    return share(above["sample_separation_m"] <= flights.suite_radius_m)


def missed_detection_encounter_rate(flights: Flights) -> Interval:
    """Share of the encounters in which `none` enters the zone that have n_d successive missed ticks.

    The event whose probability (36) bounds, if errors were independent. Clopper-Pearson; `n` is the number of
    encounters in which `none` enters the zone.
    """
    return share(flights.none["missed_ticks"][flights.none["zone"]] >= flights.trials)


def late_warning_rate(flights: Flights) -> Interval:
    """Share of the collisions of `none` whose first warning, if any, left less than t_r before contact.

    The flown counterpart of Fig. 12: what the bound (36) is meant to hold down. Clopper-Pearson; `n` is the number of
    collisions of `none`.
    """
    hit = flights.none[flights.none["collision"]]
    return share((hit["warned_s"] < 0.0) | (hit["warned_s"] > hit["closest_s"] - flights.reaction_s))


def missed_detection_bound(flights: Flights) -> Interval:
    """(1 - P(delta))^n_d of (36): computed, not observed, hence without interval and with n = 0."""
    return Interval(float((1.0 - flights.range_error_probability) ** flights.trials), None, None, 0)


MISSED_DETECTION_DECISION_RATE = Metric(
    "share of decisions with the intruder inside the zone, among those with an estimate outside it",
    ONE,
    missed_detection_decision_rate,
    sensor=True,
)
MISSED_DETECTION_ENCOUNTER_RATE = Metric(
    "share of zone entries that n_d successive estimates miss", ONE, missed_detection_encounter_rate, sensor=True
)
LATE_WARNING_RATE = Metric(
    "share of collision courses warned of less than t_r before contact", ONE, late_warning_rate, sensor=True
)
MISSED_DETECTION_BOUND = Metric(
    "the paper's bound (36) of that share, for independent errors", ONE, missed_detection_bound, sensor=True
)
