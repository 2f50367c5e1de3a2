"""Families of encounters, one file each.

A new family is one file and one line in `FAMILIES`, or `rss_gym.register_family`. `mixed` draws from all that carry a
weight; the others are named explicitly.
"""

import numpy as np

from rss_gym.encounters.accelerating import ACCELERATING
from rss_gym.encounters.crossing import CROSSING
from rss_gym.encounters.deceitful import DECEITFUL
from rss_gym.encounters.degenerate import EQUAL_VELOCITIES, EXACT_HEAD_ON, HOVERING, START_NEAR_ZONE, TAIL_CHASE
from rss_gym.encounters.family import Family
from rss_gym.encounters.from_behind import FROM_BEHIND
from rss_gym.encounters.head_on import HEAD_ON
from rss_gym.encounters.late_turn import LATE_TURN
from rss_gym.encounters.merging import MERGING
from rss_gym.encounters.near_parallel import NEAR_PARALLEL
from rss_gym.encounters.no_conflict import NO_CONFLICT
from rss_gym.encounters.outage import OUTAGE
from rss_gym.encounters.overtaking import OVERTAKING
from rss_gym.encounters.parallel_pass import PARALLEL_PASS
from rss_gym.encounters.path_loss_jump import PATH_LOSS_JUMP
from rss_gym.encounters.turning import TURNING
from rss_gym.params import Encounter, ParamsError, suggestion
from rss_gym.registry import Registry
from rss_gym.state import FAMILY

MIXED = "mixed"
_SHIPPED: dict[str, Family] = {
    "crossing": CROSSING,
    "head-on": HEAD_ON,
    "overtaking": OVERTAKING,
    "from-behind": FROM_BEHIND,
    "turning": TURNING,
    "parallel-pass": PARALLEL_PASS,
    "no-conflict": NO_CONFLICT,
    "near-parallel": NEAR_PARALLEL,
    "late-turn": LATE_TURN,
    "accelerating": ACCELERATING,
    "deceitful": DECEITFUL,
    "path-loss-jump": PATH_LOSS_JUMP,
    "outage": OUTAGE,
    "merging": MERGING,
    "exact-head-on": EXACT_HEAD_ON,
    "tail-chase": TAIL_CHASE,
    "equal-velocities": EQUAL_VELOCITIES,
    "hovering": HOVERING,
    "start-near-zone": START_NEAR_ZONE,
}


def _check(name: str, family: Family) -> None:
    if name == MIXED:
        raise ParamsError(f"family name {MIXED!r} stands for all that carry a weight; give the new one another name")
    if not isinstance(family, Family):
        raise ParamsError(f"family {name!r} must be a rss_gym.encounters.family.Family, got {type(family).__name__}")
    if not family.summary.strip():
        raise ParamsError(f"family {name!r} must have a summary, one line for listings")
    if family.weight != 0.0:
        raise ParamsError(
            f"family {name!r}: weight must be 0, got {family.weight!r}: {MIXED!r} is the distribution of the package; "
            "name the new family in `families`"
        )


FAMILIES: Registry[Family] = Registry("family", _SHIPPED, _check, like="my-family")


def chosen(encounter: Encounter) -> list[str]:
    """Names of the families that `encounter.families` asks for, in the order of the registry.

    Raises
    ------
    ParamsError
        For an unknown name.
    """
    names = [encounter.families] if isinstance(encounter.families, str) else list(encounter.families)
    for name in names:
        if name != MIXED and name not in FAMILIES:
            raise ParamsError(f"family {name!r} is unknown{suggestion(name, [*FAMILIES, MIXED])}")
    return [name for name, family in FAMILIES.items() if name in names or (MIXED in names and family.weight > 0.0)]


def table(encounter: Encounter) -> np.ndarray:
    """The chosen families for the sampler, with cumulative weights that end at 1. Shape (f,)."""
    names = chosen(encounter)
    for name in names:
        if FAMILIES[name].script is not None and encounter.intruders > 1:
            raise ParamsError(f"family {name!r} is written for one intruder, got intruders = {encounter.intruders}")
    out = np.zeros(len(names), FAMILY)
    for index, name in enumerate(names):
        out[index] = FAMILIES[name].record(encounter.horizontal_offset_m)
    out["weight"] = np.cumsum(out["weight"]) / np.sum(out["weight"])
    out["weight"][-1] = 1.0
    return out
