"""From way points to velocities: the way point is reached within a decision where the limits allow it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rss_gym import baselines
from rss_gym.baselines.way_points import commanded, path_following, towards
from rss_gym.core import Batch
from rss_gym.params import Params

PLANE, SPACE = Params(), Params.of(planar=False)
metre = st.floats(-4.0, 4.0)


def integrated(action, cruise_mps, params):
    """Way the way point goes against the predefined trajectory in one decision, by the equations of the world."""
    aircraft = params.aircraft
    velocity = np.array([cruise_mps, 0.0, 0.0])
    velocity += np.clip(action, -1.0, 1.0) * [
        aircraft.speed_max_mps,
        aircraft.speed_max_mps,
        aircraft.vertical_speed_max_mps,
    ]
    velocity[2] = np.clip(velocity[2], -aircraft.vertical_speed_max_mps, aircraft.vertical_speed_max_mps)
    velocity *= min(1.0, aircraft.speed_max_mps / max(np.linalg.norm(velocity), 1e-12))
    return (velocity - [cruise_mps, 0.0, 0.0]) * params.clock.decision_s


def own(way_point, cruise_mps):
    """Own fields of one row."""
    names = ("way_point_along_m", "way_point_right_m", "way_point_up_m")
    return {name: np.array([value]) for name, value in zip(names, way_point, strict=True)} | {
        "cruise_mps": np.array([cruise_mps])
    }


@given(st.tuples(metre, metre, metre), st.tuples(metre, metre, metre), st.floats(2.0, 4.0))
def test_the_way_point_is_reached_when_the_limits_allow_it(start, target, cruise_mps):
    aircraft, period_s = SPACE.aircraft, SPACE.clock.decision_s
    way = np.array(target) - start
    needed = way / period_s + [cruise_mps, 0.0, 0.0]
    reachable = (
        np.linalg.norm(needed) <= aircraft.speed_max_mps
        and abs(needed[2]) <= aircraft.vertical_speed_max_mps
        and way[0] / period_s >= -aircraft.speed_max_mps
    )
    action = towards(np.array([target]), own(start, cruise_mps), SPACE)[0]
    moved = integrated(action, cruise_mps, SPACE)
    if reachable:
        np.testing.assert_allclose(moved, way, atol=1e-9)
    else:
        assert np.linalg.norm(moved / period_s + [cruise_mps, 0.0, 0.0]) <= aircraft.speed_max_mps * (1 + 1e-9)


@given(st.tuples(metre, metre, metre), st.floats(2.0, 4.0))
def test_a_velocity_within_the_limits_is_commanded_as_it_is(velocity, cruise_mps):
    velocity = np.array(velocity) * [1.0, 0.7, 0.4]
    action = commanded(velocity[None], own((0, 0, 0), cruise_mps), SPACE)[0]
    if velocity[0] - cruise_mps >= -5.0 and np.linalg.norm(velocity) <= 5.0:
        moved = integrated(action, cruise_mps, SPACE)
        np.testing.assert_allclose(moved / SPACE.clock.decision_s + [cruise_mps, 0.0, 0.0], velocity, atol=1e-9)


def test_path_following_heads_for_the_path_within_the_limits():
    velocity = path_following(own((30.0, -200.0, 0.0), 3.0), PLANE)[0]
    assert np.linalg.norm(velocity) == pytest.approx(5.0) and velocity[1] > 4.9
    np.testing.assert_allclose(path_following(own((0.0, 0.0, 0.0), 3.0), PLANE)[0], [3.0, 0.0, 0.0])


@settings(max_examples=10)
@given(st.tuples(metre, metre))
def test_the_world_brings_the_way_point_where_it_is_told_to(target):
    """In flight: within a few decisions the commanded way point is at the displacement, and stays."""
    policy = baselines.make(f"constant:along_m={target[0]!r},right_m={target[1]!r}")
    batch = Batch(policy.params, 4)
    batch.seed(np.arange(4, dtype=np.uint64))
    batch.reset(np.ones(4, bool))
    for _ in range(30):
        actions, _ = policy.predict(batch.observations)
        batch.step(np.column_stack([actions, np.zeros(4)]).astype(float), np.ones(4, bool))
    agent = batch.state.aircraft[:, 0]
    apart = agent["way_point_m"] - agent["planned_m"]
    straight = (agent["path_points"] == 2) & ~batch.episode["collision"]
    along = (apart * agent["along"]).sum(axis=1)
    right = apart[:, 0] * agent["along"][:, 1] - apart[:, 1] * agent["along"][:, 0]
    np.testing.assert_allclose(along[straight], target[0], atol=1e-4)
    np.testing.assert_allclose(right[straight], target[1], atol=1e-4)
