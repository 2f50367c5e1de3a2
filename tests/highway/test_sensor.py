"""The radio on the road: whose noise it is, which filters are kept, what is told."""

import gymnasium as gym
import numpy as np
import pytest

from rss_gym.highway import RssRanging
from rss_gym.highway.env import RoadEnv
from rss_gym.highway.links import SLOW, START, TICK_COLOURED, TICK_LOSS, TICK_WHITE, VEHICLE, stream
from rss_gym.highway.observation import split
from rss_gym.highway.sensor import CAPACITY
from rss_gym.params import ParamsError, load_channel
from rss_gym.physics.noise import decay, driving_std, gauss_markov
from rss_gym.physics.path_loss import received_dbm
from rss_gym.physics.random import normal
from rss_gym.ranging import coloured
from rss_gym.streams import ROAD_STREAMS, ROAD_VEHICLES, STREAMS

STILL = {"path_loss_wander": 0.0, "white_variance_db2": 4.0, "coloured_variance_db2": 4.0, "coloured_tc_s": 2.0}


def links_of(env):
    """Copies of the links and of the vehicles."""
    sensor = env.ranging.sensor
    return sensor._links[: len(sensor.vehicles) - 1].copy(), sensor.vehicles.copy()


def test_filter_is_that_of_the_paper_on_the_noise_of_the_pair():
    """Ranges of vehicles that are never warned of, by (2), (8), (12)-(21) written out once more."""
    env = RoadEnv(channel=STILL)
    env.reset(seed=11)
    sensor, params, channel = env.ranging.sensor, env.params, load_channel(STILL)
    key, t = np.uint64(sensor.episode["key"]), params.clock.tick_s
    a = decay(t, channel.coloured_tc_s)
    drive, s = driving_std(channel.coloured_variance_db2, a), channel.coloured_variance_db2
    distances = []

    def watch():
        v = sensor.vehicles
        gap = v["position_m"][1:] - v["position_m"][0]
        distances.append(np.hypot(*gap.T))

    watch()
    for _ in range(10):  # as highway-env's own loop does for one decision
        env.road.road.act()
        env.road.road.step(t)
        watch()
    checked = 0
    for number in range(len(distances[0])):
        d_true = np.array([row[number] for row in distances])
        if sensor._contacts["valid"][number] or d_true.min() < 70.0 or d_true.max() > 149.0:
            continue
        phi = np.sqrt(s) * normal(key, stream(number) + START, 0)
        state = None
        for tick, d in enumerate(d_true):
            phi = gauss_markov(phi, a, drive, normal(key, stream(number) + TICK_COLOURED, tick))
            rss = received_dbm(channel.offset_dbm, channel.path_loss_factor, d * d) + phi
            rss += np.sqrt(channel.white_variance_db2) * normal(key, stream(number) + TICK_WHITE, tick)
            arguments = rss, channel.offset_dbm, channel.path_loss_factor, channel.white_variance_db2
            if state is None:
                prior = params.ranging.prior_range_m, params.ranging.prior_std_m
                state = coloured.start(*prior, s, *arguments)
            else:
                state = coloured.predict(*state, 0.0, params.ranging.process_noise_m2, a, drive)
                state = coloured.update(*state, *arguments, params.ranging.range_floor_m)
        assert sensor.range_m[number] == pytest.approx(state[0], rel=1e-9)
        checked += 1
    assert checked >= 2


def test_noise_belongs_to_the_pair_whatever_is_done():
    env = RoadEnv(channel=STILL)
    found = []
    for actions in ([1, 1, 1], [4, 0, 2]):
        env.reset(seed=3)
        for action in actions:
            env.step(action)
        found.append(links_of(env)[0]["coloured_db"])
    assert np.array_equal(*found)
    assert len(np.unique(found[0])) == len(found[0]) == 10
    env.reset(seed=4)
    assert not np.isin(links_of(env)[0]["coloured_db"], found[0]).any()


def test_number_observed_changes_no_filter():
    """Whoever leaves the set of the nearest keeps the filter."""
    found = []
    for vehicles in (1, 6):
        env = RoadEnv(vehicles=vehicles)
        env.reset(seed=6)
        for _ in range(4):
            observation = env.step(1)[0]
        found.append(links_of(env)[0])
        seen = split(observation, env.params)
        assert np.all(np.diff(seen["range_m"][seen["present"] > 0]) >= 0.0)
    for name in ("range_m", "p_dd", "coloured_hat_db"):
        assert np.array_equal(found[0][name], found[1][name])


def test_filter_ends_with_the_radio_range_and_begins_anew():
    env = RoadEnv()
    env.reset(seed=0)
    env.step(1)
    env.step(1)
    sensor, road = env.ranging.sensor, env.road.road
    other = road.vehicles[1]
    before = links_of(env)[0][0].copy()
    home = other.position.copy()
    other.position = home + np.array([1000.0, 0.0])
    sensor.tick(road)
    links, vehicles = links_of(env)
    assert not vehicles["heard"][1] and len(sensor.sense()[1]) == vehicles["heard"].sum()
    assert links[0]["coloured_db"] != before["coloured_db"]  # the noise goes on
    assert links[0]["range_m"] == before["range_m"]
    other.position = home
    sensor.tick(road)
    links, vehicles = links_of(env)
    assert vehicles["heard"][1]
    assert links[0]["p_dd"] > before["p_dd"]  # of the prior and one sample, not of a filter of many
    road.vehicles.remove(other)
    sensor.tick(road)
    assert not links_of(env)[1]["heard"][1]


def test_messages_come_while_the_warning_is_open():
    env = RoadEnv(zone={"speed_relative_max_mps": 10.0})
    env.reset(seed=0)
    for _ in range(8):
        observation, _, terminated, truncated, _ = env.step(1)
        seen = split(observation, env.params)
        held, warned = seen["message_valid"] > 0.5, seen["warning"] > 0.5
        assert np.array_equal(held, warned)
        assert not seen["relative_along_m"][~held].any() and not seen["message_age_s"].any()
        if terminated or truncated:
            break
    assert held.any()
    heard = env.ranging.sensor.sense()[1][:1]
    x = heard["position_m"][0, 0] - env.road.vehicle.position[0]
    assert seen["relative_along_m"][0] == pytest.approx(x, abs=5.0)


def test_lost_packets_make_messages_old():
    env = RoadEnv(channel={**STILL, "packet_loss": 0.9})
    env.reset(seed=0)
    ages = []
    for _ in range(6):
        seen = split(env.step(1)[0], env.params)
        ages += list(seen["message_age_s"][seen["message_valid"] > 0.5])
    assert max(ages) > 0.2


def test_ranges_tell_no_positions_and_oracle_the_truth():
    env = RoadEnv(information="ranges")
    assert "relative_along_m" not in split(env.reset(seed=0)[0], env.params)
    env = RoadEnv(information="oracle")
    env.reset(seed=0)
    seen = split(env.step(1)[0], env.params)
    vehicles = env.ranging.sensor.vehicles
    gap = vehicles["position_m"][1:] - vehicles["position_m"][0]
    true_m = np.sort(np.hypot(*gap.T))[:6]
    assert seen["range_m"] == pytest.approx(true_m, rel=1e-5)
    assert not seen["range_std_m"].any() and (seen["message_valid"] == 1.0).all()
    assert np.hypot(seen["relative_along_m"][0], seen["relative_right_m"][0]) == pytest.approx(true_m[0], rel=1e-4)


def test_filter_says_how_far_it_errs():
    """Over all vehicles that are heard, one decision in four: rms of (error / std), 1 for a consistent filter."""
    env, ratios = RoadEnv(), []
    for seed in range(6):
        env.reset(seed=seed)
        for step in range(8):
            _, _, terminated, truncated, _ = env.step(1)
            if step % 4 == 3:
                links, vehicles = links_of(env)
                gap = vehicles["position_m"][1:] - vehicles["position_m"][0]
                heard = vehicles["heard"][1:]
                error = (links["range_m"] - np.hypot(*gap.T))[heard]
                ratios += list(error / np.sqrt(links["p_dd"][heard]))
            if terminated or truncated:
                break
    assert len(ratios) > 60
    assert 0.5 < np.sqrt(np.mean(np.square(ratios))) < 1.7


def test_any_environment_of_highway_env_can_be_wrapped():
    env = RssRanging(gym.make("roundabout-v1", disable_env_checker=True), vehicles=2, estimator="ls")
    observation, info = env.reset(seed=0)
    assert observation in env.observation_space and not info["collision"]
    observation, reward, *_ = env.step(1)
    assert observation in env.observation_space and isinstance(float(reward), float)
    assert env.params.clock.tick_s == pytest.approx(1.0 / 15.0)


def test_streams_of_a_vehicle_are_its_own():
    """All that a vehicle draws from is within the width that the registry gives it."""
    assert {TICK_COLOURED, TICK_WHITE, TICK_LOSS, START, *range(SLOW, SLOW + 5)} <= set(range(ROAD_STREAMS))
    assert len({TICK_COLOURED, TICK_WHITE, TICK_LOSS, START, *range(SLOW, SLOW + 5)}) == 9
    road = STREAMS["road"]
    assert stream(-1) == road.start and stream(0) == road.start + ROAD_STREAMS
    assert stream(ROAD_VEHICLES - 2) + ROAD_STREAMS == road.start + road.width  # of the last that has room


def test_a_road_with_more_vehicles_than_there_is_noise_for_is_refused():
    sensor = RoadEnv().ranging.sensor
    sensor._allocate(ROAD_VEHICLES)
    with pytest.raises(ParamsError, match="a road holds at most 4096 vehicles"):
        sensor._grow()


def test_more_vehicles_than_room():
    env = RoadEnv(config={"vehicles_count": 3 * CAPACITY, "simulation_frequency": 5}, radio_range_m=10_000.0)
    env.reset(seed=0)
    sensor = env.ranging.sensor
    assert sensor.vehicles.dtype == VEHICLE
    assert sensor.vehicles["heard"].sum() == 3 * CAPACITY
    assert (sensor.range_m > 0.0).all()
