"""The cost of a drive: the return is minus it, however a drive ends; what counts as a near miss."""

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.highway.cost import Cost
from rss_gym.highway.env import RoadEnv
from rss_gym.highway.near_miss import time_to_contact_s
from rss_gym.ids import ROADS
from rss_gym.params import Reward

OTHER_PRICES = {"deviation_price": 0.5, "snmac_price_m": 7.0, "collision_price_m": 30.0}


def drive(env, choose, **keywords):
    """Rewards, deviations and last info of a whole drive."""
    env.reset(**keywords)
    rewards, infos, done = [], [], False
    while not done:
        _, reward, terminated, truncated, info = env.step(choose(len(infos)))
        assert reward == pytest.approx(sum(info[f"reward_{term}"] for term in ("deviation", "snmac", "collision")))
        rewards.append(reward)
        infos.append(info)
        done = terminated or truncated
    return rewards, infos, terminated


# Who keeps lane and speed collides on some drives; who brakes first and then goes on at will mostly does not.
ENDS = {
    "crash": ("rss_gym/Highway-v0", lambda step: 1, 0),
    "time": ("rss_gym/Highway-v0", lambda step: 4, 0),
    "end of the road": ("rss_gym/Merge-v0", lambda step: 4, 0),
    "arrival or time": ("rss_gym/Intersection-v0", lambda step: 0 if step < 3 else 2, 0),
}


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("prices", [{}, OTHER_PRICES])
def test_return_is_minus_the_cost(end, prices):
    name, choose, seed = ENDS[end]
    env = gym.make(name, reward=prices).unwrapped
    rewards, infos, terminated = drive(env, choose, seed=seed)
    last = infos[-1]
    assert last["collision"] == (end == "crash")
    assert terminated == (end in ("crash", "end of the road")) or end == "arrival or time"
    assert sum(rewards) + last["cost_m"] == pytest.approx(0.0, abs=1e-9)
    want = Reward(**prices)
    mean_m = np.mean([info["deviation_m"] for info in infos])
    assert last["deviation_mean_m"] == pytest.approx(mean_m)
    assert last["cost_m"] == pytest.approx(
        want.deviation_price * mean_m + want.snmac_price_m * last["snmac"] + want.collision_price_m * last["collision"]
    )
    assert last["snmac"] >= last["collision"]


@pytest.mark.slow
@pytest.mark.parametrize("name", ROADS)
def test_return_is_minus_the_cost_of_random_drives(name):
    env, rng = gym.make(name).unwrapped, np.random.default_rng(0)
    for seed in range(6):
        rewards, infos, _ = drive(env, lambda _: int(rng.integers(env.action_space.n)), seed=seed)
        assert sum(rewards) + infos[-1]["cost_m"] == pytest.approx(0.0, abs=1e-9)


@given(st.lists(st.floats(0.0, 1e4), min_size=1, max_size=30), st.integers(0, 30), st.integers(0, 30))
def test_return_is_minus_the_cost_of_any_course(deviations_m, snmac, collision):
    """Events that happen at any decision, or never."""
    cost = Cost(Reward())
    near = np.arange(len(deviations_m)) >= snmac
    hit = np.arange(len(deviations_m)) >= collision
    rewards = [cost.decided(d, bool(n), bool(h)) for d, n, h in zip(deviations_m, near, hit, strict=True)]
    assert sum(rewards) + cost.total_m == pytest.approx(0.0, abs=1e-9)
    assert cost.terms["deviation"] == pytest.approx(np.mean(deviations_m))


@pytest.mark.parametrize(
    ("other", "seconds"),
    [
        ((25.0, 0.0, -10.0, 0.0, 1.0, 0.0), 2.0),  # 20 m between the bodies
        ((-25.0, 0.0, 10.0, 0.0, 1.0, 0.0), 2.0),  # from behind
        ((25.0, 0.0, 10.0, 0.0, 1.0, 0.0), np.inf),
        ((25.0, 3.0, -10.0, 0.0, 1.0, 0.0), np.inf),  # on the next lane
        ((0.0, 4.0, 0.0, -1.0, 1.0, 0.0), 2.0),  # comes over from the next lane
        ((0.0, -4.0, 0.0, 0.0, 1.0, 0.0), np.inf),
        ((0.0, 1.0, 0.0, 0.0, 1.0, 0.0), 0.0),
        ((23.5, -23.5, -10.0, 10.0, 0.0, 1.0), 2.0),  # crosses at a right angle: 3.5 m of both bodies
        ((23.5, -43.5, -10.0, 10.0, 0.0, 1.0), np.inf),  # later than the agent
    ],
)
def test_time_to_contact(other, seconds):
    assert time_to_contact_s(*other) == pytest.approx(seconds)


CORNERS = np.array([[-2.5, -1.0], [-2.5, 1.0], [2.5, 1.0], [2.5, -1.0]])


def overlap(x, y, forward, right):
    """Whether two bodies overlap, by the axes that separate rectangles."""
    turn = np.array([[forward, right], [-right, forward]])
    one, two = CORNERS, CORNERS @ turn + [x, y]
    gaps = []
    for axis in (np.array([1.0, 0.0]), np.array([0.0, 1.0]), turn[0], turn[1]):
        a, b = one @ axis, two @ axis
        gaps.append(max(a.min() - b.max(), b.min() - a.max()))
    return max(gaps) <= 0.0


OFFSETS, SPEEDS = st.floats(-40.0, 40.0), st.floats(-30.0, 30.0)


@given(OFFSETS, OFFSETS, SPEEDS, SPEEDS, st.floats(-np.pi, np.pi))
def test_nobody_touches_before_the_time_to_contact(x, y, v, w, heading):
    forward, right = np.cos(heading), np.sin(heading)
    contact_s = time_to_contact_s(x, y, v, w, forward, right)
    for t in np.linspace(0.0, min(contact_s, 10.0), 200, endpoint=False)[: 200 * (contact_s > 0.0)]:
        assert not overlap(x + v * t, y + w * t, forward, right)


@given(OFFSETS, OFFSETS, SPEEDS, SPEEDS, st.integers(0, 3))
def test_parallel_and_crossing_bodies_touch_at_it(x, y, v, w, quarter):
    forward, right = np.round(np.cos(quarter * np.pi / 2)), np.round(np.sin(quarter * np.pi / 2))
    contact_s = time_to_contact_s(x, y, v, w, forward, right)
    if contact_s < 100.0:
        grown = 1.0 - 1e-9  # towards the other, for the rounding
        assert overlap((x + v * contact_s) * grown, (y + w * contact_s) * grown, forward, right)


def test_a_drive_behind_a_slower_vehicle_is_a_near_miss_before_it_is_a_collision():
    env = RoadEnv()
    _, infos, _ = drive(env, lambda step: 1, seed=ENDS["crash"][2])
    near = [info["snmac"] for info in infos]
    assert near == sorted(near) and near[-1]
    assert not infos[0]["snmac"]


def test_in_a_training_a_metre_costs_the_same_at_every_decision():
    prices = Reward(**OTHER_PRICES)
    cost = Cost(prices, decisions=20)
    rewards = [cost.decided(8.0, False, False) for _ in range(20)]
    assert rewards == pytest.approx([-0.5 * 8.0 / 20.0] * 20)
    assert cost.total_m == pytest.approx(0.5 * 8.0) and cost.deviation_mean_m == pytest.approx(8.0)
    whole = Cost(prices)
    for _ in range(20):
        whole.decided(8.0, False, False)
    assert whole.total_m == pytest.approx(cost.total_m)
