"""The degenerate suite: whatever the policy, corners of the geometry give finite flights within the limits."""

import numpy as np
import pytest

from rss_gym import baselines
from rss_gym.core import Batch, decode
from rss_gym.eval.suites import DEGENERATE
from rss_gym.params import Params, ParamsError

COUNT = 24
FLYABLE = [(name, level) for name, kind in sorted(baselines.POLICIES.items()) for level in kind.information]


def flown(name, family, information="positions"):
    """A finished batch, and the greatest speed seen."""
    planar = name not in baselines.POLICIES or not baselines.POLICIES[name].in_space
    policy = baselines.make(name, Params.of(families=family, information=information, planar=planar))
    assert "@" in name or policy.params.interface.information == information
    batch = Batch(policy.params, COUNT)
    batch.seed(np.arange(COUNT, dtype=np.uint64))
    batch.reset(np.ones(COUNT, bool))
    ended, state, fastest_mps = np.zeros(COUNT, bool), None, 0.0
    while not ended.all():
        actions, state = policy.predict(batch.observations, state)
        assert np.isfinite(actions).all()
        batch.step(decode(actions, policy.params, COUNT), ~ended)
        assert np.isfinite(batch.observations).all() and np.isfinite(batch.rewards).all()
        fastest_mps = max(fastest_mps, np.linalg.norm(batch.state.aircraft["velocity_mps"], axis=-1).max())
        ended = batch.episode["terminated"] | batch.episode["truncated"]
    return batch, fastest_mps


@pytest.mark.parametrize("family", DEGENERATE)
@pytest.mark.parametrize(("name", "information"), FLYABLE)
def test_any_policy_stays_finite_and_within_the_speed_limit(name, information, family):
    batch, fastest_mps = flown(name, family, information)
    assert fastest_mps <= batch.params.aircraft.speed_max_mps * (1 + 1e-12)
    for field in ("position_m", "solution_m", "way_point_m"):
        assert np.isfinite(batch.state.aircraft[field]).all()
    assert (batch.state.links["range_m"][:, 0] > 0.0).all()


@pytest.mark.parametrize(
    ("family", "collides"),
    [
        ("exact-head-on", True),
        ("tail-chase", True),
        ("equal-velocities", False),
        ("hovering", True),
        ("start-near-zone", True),
    ],
)
def test_what_happens_if_nobody_acts(family, collides):
    batch, _ = flown("none", family)
    assert (batch.episode["collision"] == collides).all()


def test_equal_velocities_keep_their_distance():
    batch, _ = flown("none", "equal-velocities")
    np.testing.assert_allclose(batch.episode["min_separation_m"], 30.0, atol=2.5)


def test_start_near_the_zone_begins_on_its_edge():
    batch = Batch(Params.of(families="start-near-zone"), COUNT)
    batch.seed(np.arange(COUNT, dtype=np.uint64))
    batch.reset(np.ones(COUNT, bool))
    np.testing.assert_allclose(batch.episode["min_separation_m"], batch.params.zone.radius_m, atol=0.1)


@pytest.mark.parametrize("family", ["exact-head-on", "tail-chase", "equal-velocities", "start-near-zone"])
def test_the_rule_on_true_states_never_collides(family):
    batch, _ = flown("orthogonal@oracle:radius_m=60", family)
    assert not batch.episode["collision"].any()


def test_written_encounters_are_for_one_intruder():
    with pytest.raises(ParamsError, match=r"hovering.*one intruder"):
        Batch(Params.of(families="hovering", intruders=2), 1)


def test_they_are_not_drawn_by_mixed():
    from rss_gym import encounters

    assert not set(DEGENERATE) & set(encounters.chosen(Params().encounter))
