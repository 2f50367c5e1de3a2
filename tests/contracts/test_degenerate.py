"""The degenerate suite: whatever the policy, corners of the geometry give finite flights within the limits."""

import numpy as np
import pytest

from rss_gym import baselines
from rss_gym.core import Batch
from rss_gym.eval.suites import DEGENERATE
from rss_gym.params import Params, ParamsError
from rss_gym.testing.flights import ended, fresh, step
from rss_gym.testing.rule import check_rule_on

COUNT = 24
FLYABLE = [(name, level) for name, kind in sorted(baselines.POLICIES.items()) for level in kind.information]


def flown(name, family):
    """A finished batch."""
    policy = baselines.make(name, Params.of(families=family))
    batch, state = fresh(policy.params, COUNT), None
    while not ended(batch).all():
        actions, state = policy.predict(batch.observations, state)
        step(batch, actions)
    return batch


@pytest.mark.slow
@pytest.mark.parametrize("family", DEGENERATE)
@pytest.mark.parametrize(("name", "information"), FLYABLE)
def test_any_policy_stays_finite_and_within_the_speed_limit(name, information, family):
    check_rule_on(name, family, information)


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
    batch = flown("none", family)
    assert (batch.episode["collision"] == collides).all()


def test_equal_velocities_keep_their_distance():
    batch = flown("none", "equal-velocities")
    np.testing.assert_allclose(batch.episode["min_separation_m"], 30.0, atol=2.5)


def test_start_near_the_zone_begins_on_its_edge():
    batch = Batch(Params.of(families="start-near-zone"), COUNT)
    batch.seed(np.arange(COUNT, dtype=np.uint64))
    batch.reset(np.ones(COUNT, bool))
    np.testing.assert_allclose(batch.episode["min_separation_m"], batch.params.zone.radius_m, atol=0.1)


@pytest.mark.parametrize("family", ["exact-head-on", "tail-chase", "equal-velocities", "start-near-zone"])
def test_the_rule_on_true_states_never_collides(family):
    batch = flown("orthogonal@oracle:radius_m=60", family)
    assert not batch.episode["collision"].any()


def test_written_encounters_are_for_one_intruder():
    with pytest.raises(ParamsError, match=r"hovering.*one intruder"):
        Batch(Params.of(families="hovering", intruders=2), 1)


def test_they_are_not_drawn_by_mixed():
    from rss_gym import encounters

    assert not set(DEGENERATE) & set(encounters.chosen(Params().encounter))
