"""What an action commands: a change of the way point's velocity from the planned velocity, within the limits."""

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.core import DISCRETE_ACTIONS, Batch, decode, spaces
from rss_gym.params import Params

N = 16
WORLDS = {"plane": Params(), "space": Params.of(planar=False), "turning": Params.of(families="turning", gust_mps=0.0)}
BATCHES = {}


def fresh(name):
    """The batch of a world, started anew; one for all examples."""
    batch = BATCHES.setdefault(name, Batch(WORLDS[name], N))
    batch.seed(np.arange(N, dtype=np.uint64))
    batch.reset(np.ones(N, bool))
    return batch


def offset(batch):
    """Commanded way points minus predefined trajectories, in the axes of the legs (n, 3)."""
    aircraft = batch.state.aircraft[:, 0]
    r, along = aircraft["way_point_m"] - aircraft["planned_m"], aircraft["along"]
    return np.stack(
        [r[:, 0] * along[:, 0] + r[:, 1] * along[:, 1], r[:, 0] * along[:, 1] - r[:, 1] * along[:, 0], r[:, 2]], axis=1
    )


shares = st.floats(-1.0, 1.0)


@pytest.mark.parametrize("name", WORLDS)
@given(first=st.tuples(shares, shares, shares), decisions=st.integers(1, 6))
def test_zero_keeps_the_offset(name, first, decisions):
    """Whatever it is: the way point then moves as the path does, round its turns too."""
    batch, every_row = fresh(name), np.ones(N, bool)
    first = np.array(first) * [1.0, 1.0, 0.0 if WORLDS[name].encounter.planar else 1.0]
    batch.step(np.tile(first, (N, 1)), every_row)
    aircraft = batch.state.aircraft[:, 0]
    before = aircraft["way_point_m"] - aircraft["planned_m"]
    for _ in range(decisions):
        batch.step(np.zeros((N, 3)), every_row)
        np.testing.assert_allclose(aircraft["way_point_m"] - aircraft["planned_m"], before, atol=1e-9)


@pytest.mark.parametrize("name", ["plane", "space"])
@given(action=st.tuples(shares, shares, shares))
def test_the_way_point_moves_at_the_planned_velocity_plus_the_change(name, action):
    """Its vertical part held within the vertical limit, the whole shortened to the speed limit."""
    params, batch = WORLDS[name], fresh(name)
    aircraft = params.aircraft
    action = np.array(action) * [1.0, 1.0, 0.0 if params.encounter.planar else 1.0]
    straight = batch.state.aircraft["path_points"][:, 0] == 2
    batch.step(np.tile(action, (N, 1)), np.ones(N, bool))
    cruise = np.linalg.norm(batch.state.aircraft["planned_mps"][:, 0], axis=1)
    change = action * [aircraft.speed_max_mps, aircraft.speed_max_mps, aircraft.vertical_speed_max_mps]
    planned = np.stack([cruise, np.zeros(N), np.zeros(N)], axis=1)
    v = planned + change
    v *= np.minimum(1.0, aircraft.speed_max_mps / np.maximum(np.linalg.norm(v, axis=1), 1e-12))[:, None]
    np.testing.assert_allclose(offset(batch)[straight], 0.5 * (v - planned)[straight], atol=1e-9)
    assert straight.sum() > 5


def test_the_height_stays_in_its_band():
    batch = fresh("space")
    band_m = WORLDS["space"].encounter.altitude_band_m
    for _ in range(40):
        batch.step(np.tile([0.0, 0.0, 1.0], (N, 1)), ~batch.episode["terminated"])
    flying = ~batch.episode["terminated"]
    np.testing.assert_allclose(offset(batch)[flying, 2], band_m, atol=1e-9)


@pytest.mark.parametrize(("planar", "count"), [(True, 9), (False, 11)])
def test_discrete_actions(planar, count):
    """No change; eight in the plane, of half the speed limit; in space climb and descent."""
    params = Params.of(action="discrete", planar=planar)
    space = spaces(params)[1]
    assert isinstance(space, gym.spaces.Discrete) and space.n == count
    changes = decode(np.arange(count), params, count)
    assert len({tuple(change) for change in changes}) == count
    assert (changes[0] == 0.0).all()
    level = {(along, right) for along in (0.0, 0.5, -0.5) for right in (0.0, 0.5, -0.5)}
    assert {tuple(change[:2]) for change in changes[:9]} == level
    assert (changes[:9, 2] == 0.0).all()
    assert changes[9:].tolist() == [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]][: count - 9]
    np.testing.assert_array_equal(changes, DISCRETE_ACTIONS[:count])
    with pytest.raises(ValueError, match=rf"0\.\.{count - 1}"):
        decode(np.array([count]), params, 1)


@pytest.mark.parametrize("planar", [True, False])
def test_a_discrete_action_is_the_continuous_one_of_its_row(planar):
    discrete = gym.make("rss_gym/Encounter-v0", action="discrete", planar=planar)
    continuous = gym.make("rss_gym/Encounter-v0", planar=planar)
    for number in range(9 if planar else 11):
        for env in (discrete, continuous):
            env.reset(seed=number)
        for _ in range(10):
            one = discrete.step(number)
            two = continuous.step(DISCRETE_ACTIONS[number, : 2 if planar else 3])
            np.testing.assert_array_equal(one[0], two[0])
            assert one[1:] == two[1:]
