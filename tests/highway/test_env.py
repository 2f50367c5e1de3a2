"""The registered roads as environments: spaces, seeds, copies, events."""

import copy
import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env, data_equivalence

from rss_gym.highway.env import SCENES, RoadEnv
from rss_gym.highway.observation import fields, split
from rss_gym.ids import ROADS

pytestmark = pytest.mark.usefixtures("no_warnings")


@pytest.fixture(params=ROADS)
def road_id(request):
    """Every registered road."""
    return request.param


def drive(env, actions, **keywords):
    """Reset and take these actions; returns all observations."""
    found = [env.reset(**keywords)[0]]
    for action in actions:
        observation, _, terminated, truncated, _ = env.step(action)
        found.append(observation)
        if terminated or truncated:
            break
    return found


def test_check_env(road_id):
    check_env(gym.make(road_id).unwrapped, skip_render_check=True)


@pytest.mark.parametrize("information", ["ranges", "oracle"])
def test_check_env_with_information(information):
    check_env(gym.make("rss_gym/Highway-v0", information=information).unwrapped, skip_render_check=True)


def test_continuous_actions():
    env = RoadEnv(config={"action": {"type": "ContinuousAction"}})
    assert isinstance(env.action_space, gym.spaces.Box)
    drive(env, [np.array([0.1, 0.0], np.float32)] * 2, seed=0)


def test_spec_makes_the_same(road_id):
    env = gym.make(road_id, information="ranges", zone={"reaction_s": 0.5}, vehicles=3)
    twin = gym.make(gym.envs.registration.EnvSpec.from_json(env.spec.to_json()))
    assert twin.unwrapped.params == env.unwrapped.params
    assert data_equivalence(env.reset(seed=4), twin.reset(seed=4), exact=True)


def test_seed_begins_its_episodes_and_options_replay_them(road_id):
    env = gym.make(road_id)
    numbered = [drive(env, [1, 1], seed=7), drive(env, [1, 1])]
    replayed = [drive(env, [1, 1], seed=7, options={"episode": k}) for k in (0, 1)]
    assert data_equivalence(numbered, replayed, exact=True)
    other = env.reset(seed=7, options={"split": "suite"})[0]
    assert not np.array_equal(other, numbered[0][0])


def test_row_of_a_vector_is_the_single_environment():
    envs = gym.make_vec("rss_gym/Highway-v0", num_envs=2, vectorization_mode="sync")
    rows = envs.reset(seed=3)[0]
    assert np.array_equal(rows[1], gym.make("rss_gym/Highway-v0").reset(seed=4)[0])


def test_copy_goes_on_alike_and_alone():
    env = RoadEnv()
    drive(env, [1, 1], seed=1)
    twin = copy.deepcopy(env)
    expected = [env.step(1) for _ in range(3)]
    assert data_equivalence([twin.step(1) for _ in range(3)], expected, exact=True)


@pytest.mark.slow
def test_crossing_leaves_the_traffic_of_other_roads_alone():
    """highway-env's intersection writes into the class of its vehicles; alone in a process the result is the same."""
    code = (
        "import gymnasium as gym, rss_gym; env = gym.make('rss_gym/Highway-v0'); env.reset(seed=0)\n"
        "print(repr([env.step(1)[0].tolist() for _ in range(3)]))"
    )
    alone = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    drive(RoadEnv("intersection"), [1], seed=0)
    env = gym.make("rss_gym/Highway-v0")
    env.reset(seed=0)
    assert repr([env.step(1)[0].tolist() for _ in range(3)]) == alone.strip()


def test_steps_only_in_a_running_episode():
    env = RoadEnv()
    with pytest.raises(gym.error.ResetNeeded):
        env.step(1)
    env.reset(seed=0, options={"split": "suite"})
    ended = False
    while not ended:
        _, _, terminated, truncated, info = env.step(1)
        ended = terminated or truncated
    assert info["is_success"] != info["collision"]
    for stepped in (env, env.ranging):
        with pytest.raises(gym.error.ResetNeeded):
            stepped.step(1)
    env.reset()
    with pytest.raises(ValueError, match="action must be in Discrete"):
        env.step(17)


def test_zone_of_each_road_is_that_of_its_speeds():
    """(40): (4 / 0.8 + |v| t_r) n_d with t_r = 1 s and n_d = 3, as 0.2^3 = 0.008 <= 0.01 < 0.2^2."""
    found = {name: RoadEnv(name).params.zone for name in SCENES}
    assert {name: zone.trials for name, zone in found.items()} == dict.fromkeys(SCENES, 3)
    assert {name: zone.radius_m for name, zone in found.items()} == {
        "highway": pytest.approx(45.0),
        "merge": pytest.approx(51.0),
        "intersection": pytest.approx(72.0),
    }


def test_fields_are_what_is_known(road_id):
    env = gym.make(road_id).unwrapped
    seen = split(env.reset(seed=0)[0], env.params)
    vehicle = env.road.vehicle
    assert seen["speed_mps"] == pytest.approx(vehicle.speed, rel=1e-6)
    assert seen["speed_error_mps"] == pytest.approx(vehicle.speed - env.ranging.plan.speed_mps, abs=1e-5)
    assert seen["range_m"].shape == (6,)
    start, end, _ = vehicle.lane_index
    lanes = len(env.road.road.network.graph[start][end])
    assert seen["lanes_left"] + seen["lanes_right"] + 1 == pytest.approx(lanes)
    assert len(fields(env.params)) == env.observation_space.shape[0]


def test_without_radio_the_vehicles_are_not_seen():
    with_radio, without = RoadEnv(), RoadEnv(radio=False)
    one, two = drive(with_radio, [1, 0, 1], seed=2)[-1], drive(without, [1, 0, 1], seed=2)[-1]
    own = 10
    assert np.array_equal(one[:own], two[:own])
    assert one[own:].any() and not two[own:].any()


def test_deviation_is_from_the_plan():
    env = RoadEnv()
    env.reset(seed=0)
    assert env.step(1)[4]["deviation_m"] == pytest.approx(0.0, abs=1e-9)
    env.reset(seed=0)
    env.step(4)
    info = env.step(1)[4]
    lag_m = 2.0 * 25.0 - (env.road.vehicle.position[0] - env.ranging.plan.position_m(0.0)[0])
    assert lag_m > 2.0
    assert info["deviation_m"] == pytest.approx(lag_m, abs=0.05)
    assert info["lane_error_m"] == pytest.approx(0.0, abs=1e-6)
    env.step(2 if env.road.vehicle.lane_index[2] < 2 else 0)
    assert env.step(1)[4]["lane_error_m"] > 2.0


def test_seed_may_be_numpys():
    env = RoadEnv()
    assert np.array_equal(env.reset(seed=np.int64(7))[0], env.reset(seed=7)[0])
    with pytest.raises(ValueError, match="seed must be a whole number"):
        env.reset(seed=-1)


def test_road_and_vehicle_of_highway_env_are_at_hand():
    env = gym.make("rss_gym/Highway-v0").unwrapped
    env.reset(seed=0)
    assert env.vehicle is env.road.vehicle and env.config["lanes_count"] == 3


def test_own_driver_of_highway_env_takes_the_vehicle():
    env, still = RoadEnv(driver="idm"), RoadEnv(driver="idm")
    left, idle = drive(env, [0] * 8, seed=5), drive(still, [1] * 8, seed=5)
    assert data_equivalence(left, idle, exact=True)
    assert type(env.road.vehicle).__name__ == "IDMVehicle"
    traffic = [RoadEnv().reset(seed=5)[0], env.reset(seed=5)[0]]
    assert np.array_equal(*traffic)


def test_rendering():
    pytest.importorskip("pygame")
    env = gym.make("rss_gym/Highway-v0", render_mode="rgb_array")
    env.reset(seed=0)
    assert env.render().shape == (150, 600, 3)
    env.close()
