"""What every scripted policy must keep."""

from __future__ import annotations

from typing import Any

import numpy as np

from rss_gym import baselines
from rss_gym.eval.suites import DEGENERATE
from rss_gym.params import Params
from rss_gym.testing.flights import ended, fresh, step
from rss_gym.testing.policy import check_policy

COUNT = 24
WORLDS: dict[str, dict[str, Any]] = {
    "plane": {},
    "space": {"planar": False},
    "several": {"intruders": 4, "intruders_min": 1},
}


def check_rule(name: str) -> None:
    """A registered rule on every information, in the plane and in space, with one intruder and with several.

    It has a summary; it keeps the contract of `check_policy`; and it stays finite and within the speed limit in the
    corners of the geometry, whatever is known there.
    """
    summary = baselines.describe()[name]["summary"]
    assert summary.endswith("."), f"the first line of the docstring of rule {name!r} must be a sentence: {summary!r}"
    for world in WORLDS:
        check_rule_in(name, world)
    for information in baselines.POLICIES[name].information:
        for family in DEGENERATE:
            check_rule_on(name, family, information)


def check_rule_in(name: str, world: str) -> None:
    """`check_policy` in one of `WORLDS`, on each information of the rule."""
    rule = baselines.POLICIES[name]
    space = {"planar": False} if rule.in_space else {}
    for information in rule.information:
        params = Params.of(**{"information": information, **WORLDS[world], **space})
        policy = baselines.make(name, params)
        check_policy(policy, policy.params)


def check_rule_on(name: str, family: str, information: str) -> None:
    """Finite flights within the speed limit on a hand-written encounter."""
    params = Params.of(families=family, information=information, planar=not baselines.POLICIES[name].in_space)
    policy = baselines.make(name, params)
    batch, state = fresh(policy.params, COUNT), None
    while not ended(batch).all():
        actions, state = policy.predict(batch.observations, state)
        assert np.isfinite(actions).all(), f"{family}: an action is not finite"
        step(batch, actions)
        assert np.isfinite(batch.observations).all() and np.isfinite(batch.rewards).all(), f"{family}: not finite"
        speed_mps = np.linalg.norm(batch.state.aircraft["velocity_mps"], axis=-1).max()
        assert speed_mps <= batch.params.aircraft.speed_max_mps * (1 + 1e-12), f"{family}: {speed_mps} m/s"
    for field in ("position_m", "solution_m", "way_point_m"):
        assert np.isfinite(batch.state.aircraft[field]).all(), f"{family}: {field} is not finite"
    assert (batch.state.links["range_m"][:, 0] > 0.0).all(), f"{family}: a range is not positive"
