"""The risk ratio of collisions, and its two parts."""

import numpy as np

from rss_gym.eval.intervals import Interval, clopper_pearson, odds_exact, paired_risk_ratio
from rss_gym.eval.metrics.metric import ONE, Flights, Metric


def collision_pairs(flights: Flights) -> tuple[int, int, int]:
    """Encounters with a collision under both the policy and `none`, under the policy only, under `none` only."""
    policy, none = flights.table["collision"], flights.none["collision"]
    return (
        int(np.count_nonzero(policy & none)),
        int(np.count_nonzero(policy & ~none)),
        int(np.count_nonzero(~policy & none)),
    )


def risk_ratio(flights: Flights) -> Interval:
    """Collisions with the policy over collisions with `none`, on the same encounters and noise.

    Bonett and Price's paired interval with Clopper-Pearson ends (`paired_risk_ratio`). Undefined where `none` never
    collides. `n` is the number of encounters.

    References
    ----------
    MIT Lincoln Laboratory, degas-core, computeMetric.m, with all weights equal; its induced part likewise.
    """
    return paired_risk_ratio(*collision_pairs(flights), len(flights))


def risk_ratio_unresolved(flights: Flights) -> Interval:
    """Collisions of `none` that remain with the policy, over all collisions of `none`.

    An exact Clopper-Pearson interval: the collisions of `none` are the trials. `n` is the number of encounters.
    """
    both, _, only_none = collision_pairs(flights)
    return clopper_pearson(both, both + only_none)._replace(n=len(flights))


def risk_ratio_induced(flights: Flights) -> Interval:
    """Collisions with the policy in encounters where `none` has none, over all collisions of `none`.

    The two kinds of encounter are disjoint, so the interval is exact (`odds_exact`). Unresolved and induced sum to
    `risk_ratio`. `n` is the number of encounters.
    """
    both, only_policy, only_none = collision_pairs(flights)
    return odds_exact(only_policy, both + only_none)._replace(n=len(flights))


RISK_RATIO = Metric("collisions with the policy / collisions with `none`", ONE, risk_ratio)
RISK_RATIO_UNRESOLVED = Metric(
    "part of the risk ratio: collisions of `none` that the policy leaves", ONE, risk_ratio_unresolved
)
RISK_RATIO_INDUCED = Metric("part of the risk ratio: collisions that the policy makes", ONE, risk_ratio_induced)
