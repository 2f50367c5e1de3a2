"""The reward is minus the cost: the undiscounted return and the cost add up to zero however an episode ends."""

import numpy as np
import pytest

from rss_gym.core import INFO, Batch
from rss_gym.params import Params

N = 48
TERMS = [name for name in INFO if name.startswith("reward_")]
WORLDS = {
    "default": {},
    "space": {"planar": False},
    "oracle": {"information": "oracle"},
    "ranges": {"information": "ranges"},
    "several": {"intruders": 4, "intruders_min": 2},
    "several in space, on ranges": {"intruders": 3, "information": "ranges", "planar": False},
    "other prices": {"deviation_price": 3.5, "snmac_price_m": 17.0, "collision_price_m": 250.0},
    "nothing but near misses": {"deviation_price": 0.0, "collision_price_m": 0.0, "families": "head-on"},
    "proximity": {"proximity_price_m": 40.0, "comfort_m": 50.0},
    "adaptive zone, late messages": {"zone": "adaptive", "message_latency_s": 1.0, "message_loss": 0.5},
    "no tail": {"tail_min_s": 0.0, "tail_max_s": 0.0},
    "wide collisions": {"collision_m": 4.57, "snmac_horizontal_m": 40.0},
}


def flown(actions=0.3, n=N, **keywords):
    """Final episode records of flights, the rewards (n, steps, 0 after the end), and the terms' sums."""
    batch = Batch(Params.of(**keywords), n)
    batch.seed(np.arange(n, dtype=np.uint64))
    batch.reset(np.ones(n, bool))
    assert (batch.episode["cost_m"] == 0.0).all()
    generator, ended, rewards, terms = np.random.default_rng(0), np.zeros(n, bool), [], dict.fromkeys(TERMS, 0.0)
    potential = [batch.episode["potential_m"].copy()]
    while not ended.all():
        if len(rewards) % 10 == 0:
            held = actions * generator.uniform(-1, 1, (n, 3)) * (np.arange(n) % 2)[:, None]  # half of them do nothing
        before = batch.episode["cost_m"].copy()
        batch.step(held, ~ended)
        flying = ~ended
        rewards.append(np.where(flying, batch.rewards, 0.0))
        for name in TERMS:
            terms[name] = terms[name] + np.where(flying, batch.episode[name], 0.0)
        gain = batch.rewards - batch.episode["reward_shaping"]
        # Decision by decision, too.
        np.testing.assert_allclose(gain[flying], (before - batch.episode["cost_m"])[flying], rtol=0, atol=1e-9)
        ended = ended | batch.episode["terminated"] | batch.episode["truncated"]
        potential.append(batch.episode["potential_m"].copy())
    return batch, np.stack(rewards, axis=1), terms, np.stack(potential, axis=1)


@pytest.mark.parametrize("name", WORLDS)
def test_return_and_cost_add_up_to_zero(name):
    batch, rewards, terms, _ = flown(**WORLDS[name])
    e, prices = batch.episode, batch.params.reward
    np.testing.assert_allclose(rewards.sum(axis=1) + e["cost_m"], 0.0, rtol=0, atol=1e-9)
    np.testing.assert_allclose(sum(terms.values()), rewards.sum(axis=1), rtol=0, atol=1e-9)
    # The cost is what the module says, of what the records hold.
    cost_m = prices.deviation_price * e["deviation_mean_m"] + prices.snmac_price_m * e["snmac"]
    cost_m = (
        cost_m + prices.collision_price_m * e["collision"] + prices.proximity_price_m * e["proximity_sum"] / e["tick"]
    )
    np.testing.assert_allclose(e["cost_m"], cost_m, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(terms["reward_deviation"], -prices.deviation_price * e["deviation_mean_m"], atol=1e-9)
    np.testing.assert_array_equal(terms["reward_snmac"], -prices.snmac_price_m * e["snmac"])
    np.testing.assert_array_equal(terms["reward_collision"], -prices.collision_price_m * e["collision"])
    if name in ("default", "space", "oracle", "several", "other prices", "proximity", "wide collisions"):
        assert e["collision"].any() and e["truncated"].any()
        assert (e["snmac"] & ~e["collision"]).any()
        assert (~e["snmac"] & e["truncated"]).any()


def test_mean_deviation_is_the_flights():
    """By NumPy from the records of every tick (a decision of one tick), until the collision."""
    batch = Batch(Params.of(decision_s=0.1, families="head-on"), 16)
    batch.seed(np.arange(16, dtype=np.uint64))
    batch.reset(np.ones(16, bool))
    ended, distances = np.zeros(16, bool), [[] for _ in range(16)]
    generator = np.random.default_rng(0)
    while not ended.all():
        batch.step(generator.uniform(-0.5, 0.5, (16, 3)), ~ended)
        agent = batch.state.aircraft[:, 0]
        for i in np.flatnonzero(~ended):
            distances[i].append(np.linalg.norm(agent["position_m"][i] - agent["planned_m"][i]))
        ended |= batch.episode["terminated"] | batch.episode["truncated"]
    np.testing.assert_allclose(batch.episode["deviation_mean_m"], [np.mean(d) for d in distances], rtol=1e-9)
    np.testing.assert_allclose(batch.episode["deviation_max_m"], [np.max(d) for d in distances], rtol=1e-9)
    assert batch.episode["collision"].any()


def test_a_collision_in_the_first_decision():
    """Two aircraft that start on top of each other; the flight ends in the middle of the decision."""
    for information in ("oracle", "positions"):
        params = Params.of(
            information=information, start_range_min=0.5, start_range_max=0.5, start_range_unit_m=10.0,
            closing_min_mps=4.5, decision_s=3.0, families="head-on",
        )  # fmt: skip
        batch = Batch(params, 64)
        batch.seed(np.arange(64, dtype=np.uint64))
        batch.reset(np.ones(64, bool))
        batch.step(np.zeros((64, 3)), np.ones(64, bool))
        e = batch.episode
        hit = e["terminated"]
        assert hit.sum() > 10
        assert (e["tick"][hit] < params.clock.ticks_per_decision).all()
        np.testing.assert_allclose(batch.rewards + e["cost_m"], 0.0, rtol=0, atol=1e-9)
        assert (e["cost_m"][hit] >= 10100.0).all()
        np.testing.assert_allclose(e["cost_m"][hit] - 10100.0, e["deviation_mean_m"][hit], atol=1e-9)


@pytest.mark.parametrize("discount", [1.0, 0.99, 0.5])
@pytest.mark.parametrize("keywords", [{}, {"planar": False, "intruders": 3}, {"information": "ranges"}])
def test_shaping_changes_the_discounted_return_by_the_first_potential(keywords, discount):
    """It telescopes; what is left is minus the potential at the start, and at the end that of a running clock."""
    shaped, rewards, _, potential = flown(shaping_m=70.0, shaping_discount=discount, **keywords)
    plain, unshaped, _, _ = flown(**keywords)
    assert shaped.state.aircraft["position_m"].tobytes() == plain.state.aircraft["position_m"].tobytes()
    np.testing.assert_array_equal(shaped.episode["cost_m"], plain.episode["cost_m"])
    steps = rewards.shape[1]
    weights = discount ** np.arange(steps)
    difference = ((rewards - unshaped) * weights).sum(axis=1)
    last = discount ** (plain.episode["tick"] / plain.params.clock.ticks_per_decision).round()
    last = np.where(shaped.episode["terminated"], 0.0, last * potential[:, -1])
    np.testing.assert_allclose(difference, last - potential[:, 0], rtol=0, atol=1e-9)
    assert (potential[shaped.episode["terminated"], -1] == 0.0).all()
    assert (potential <= 0.0).all() and (potential[:, 0] < -1.0).any()


def test_potential_is_of_the_true_predicted_miss():
    batch, _, _, _ = flown(shaping_m=70.0, comfort_m=30.0, intruders=2, intruders_min=2, n=16)
    batch.reset(np.ones(16, bool))
    for _ in range(20):
        batch.step(np.zeros((16, 3)), np.ones(16, bool))
    aircraft = batch.state.aircraft
    r = aircraft["position_m"][:, 1:] - aircraft["position_m"][:, :1]
    v = aircraft["velocity_mps"][:, 1:] - aircraft["velocity_mps"][:, :1]
    t = np.clip(-(r * v).sum(-1) / (v * v).sum(-1), 0.0, 60.0)
    miss = np.linalg.norm(r + v * t[..., None], axis=-1).min(axis=1)
    wanted = -70.0 * np.maximum(0.0, 1.0 - miss / 30.0) ** 2
    going = ~batch.episode["terminated"]
    np.testing.assert_allclose(batch.episode["potential_m"][going], wanted[going], rtol=1e-9, atol=1e-9)
    assert (wanted < -0.1).any()


def test_info_of_prices_that_are_not_set_is_zero():
    _, _, terms, _ = flown(n=8)
    assert (terms["reward_proximity"] == 0.0).all() and (terms["reward_shaping"] == 0.0).all()
