"""Pathwise gradients: each factor against an independent way to it, the whole against flights of the world itself."""

import numpy as np
import pytest
from scipy.stats import norm

pytest.importorskip("stable_baselines3")

import torch
from stable_baselines3.common.vec_env import VecFrameStack

from rss_gym.baselines.agent import load as load_agent
from rss_gym.core import Batch
from rss_gym.params import Params, ParamsError
from rss_gym.sb3 import make_vec_env
from rss_gym.train import actor, recipe, run
from rss_gym.train.pathwise import Pathwise
from rss_gym.train.pathwise.flights import fly, gradient, least_margins
from rss_gym.train.pathwise.linearised_actor import LinearisedActor
from rss_gym.train.pathwise.price import SmoothPrice

PRICE = SmoothPrice((100.0, 10_000.0, 20.0), (15.24, 4.5, -3.0), (3.0, 3.0, 1.0))


def model_of(activation=torch.nn.Tanh, **world):
    env = make_vec_env("rss_gym/Encounter-v0", n_envs=8, seed=0, **world)
    return Pathwise("MlpPolicy", env, seed=0, policy_kwargs={"net_arch": [16, 16], "activation_fn": activation})


@pytest.mark.parametrize("activation", [torch.nn.Tanh, torch.nn.ReLU])
def test_the_jacobian_of_the_actor_is_autograds(activation):
    policy = model_of(activation).policy
    rows = torch.randn(5, policy.observation_space.shape[0])
    actions, jacobian = (torch.from_numpy(found) for found in LinearisedActor(policy)(rows.numpy()))
    torch.testing.assert_close(actions, actor.outputs(policy, rows).detach())
    for row, found in zip(rows, jacobian, strict=True):
        expected = torch.autograd.functional.jacobian(lambda x: actor.outputs(policy, x[None])[0], row)
        torch.testing.assert_close(found, expected, rtol=1e-4, atol=1e-6)


def test_the_smooth_price_is_half_at_each_limit_and_falls_with_separation():
    price = SmoothPrice((100.0, 0.0, 20.0), (15.24, 4.5, -3.0), (1.5, 1.5, 1.0))
    d = np.linspace(0.0, 40.0, 4001)
    slope = price.slope(np.stack([d, d, -d], axis=1), np.zeros((4001, 3)))
    total = np.cumsum(slope[:, 0]) * (d[1] - d[0])
    assert np.all(slope <= 0.0) and np.all(slope[:, 1] == 0.0)
    assert np.argmin(slope[:, 2]) == 300
    assert total[1524] == pytest.approx(-50.0, abs=0.2)
    assert total[-1] == pytest.approx(-100.0, abs=0.2)
    assert abs(price.slope(np.full((1, 3), np.inf), np.ones((1, 3)))[0, 0]) < 1e-20


def test_a_price_is_as_soft_as_the_track_is_uncertain():
    margins, prices, limits = np.array([[9.0, 9.0, -2.0]]), (100.0, 1e4, 20.0), (15.24, 4.5, -3.0)
    certain = SmoothPrice(prices, limits, (3.0, 3.0, 1.0), 0.5)
    wider = SmoothPrice(prices, limits, (5.0, 5.0, 1.0))
    np.testing.assert_allclose(certain.slope(margins, np.full((1, 3), 8.0)), wider.slope(margins, np.zeros((1, 3))))


def cost(batch, decisions, price):
    """What `gradient` differentiates, of each flight."""
    least = least_margins(batch.n, decisions).least_m
    near = sum(
        price.prices_m[event] * norm.cdf((price.limits_m[event] - least[:, event]) / price.softness_m[event])
        for event in range(3)
    )
    return batch.episode["deviation_sum_m"] / batch.episode["ticks"] + near


def flown(policy, price):
    batch = Batch(Params.of(information="oracle", gust_mps=0.0), 64)
    batch.seed(np.arange(64, dtype=np.uint64))
    batch.reset(np.ones(64, bool))
    decisions = fly(batch, policy, np.ones(batch.observations.shape[1], np.float32))
    return batch, decisions, cost(batch, decisions, price)


@pytest.mark.parametrize("near", [False, True])
def test_the_gradient_is_the_slope_of_the_cost_over_flights_of_the_world(near):
    """With true states for observations nothing is left out; off its path |u - u^d| is smooth."""
    price = PRICE if near else SmoothPrice((0.0, 0.0, 0.0), PRICE.limits_m, PRICE.softness_m)
    policy = model_of(information="oracle").policy
    with torch.no_grad():
        policy.action_net.bias.copy_(torch.tensor([-0.1, 0.05]))
    batch, decisions, _ = flown(policy, price)
    observations, gradients = gradient(batch, decisions, least_margins(64, decisions), price, 1e9, np.ones(64))
    policy.optimizer.zero_grad()
    torch.sum(actor.outputs(policy, observations) * gradients).backward()
    for axis, slope in enumerate(policy.action_net.bias.grad.tolist()):
        costs = []
        for step in (1e-3, -2e-3):
            with torch.no_grad():
                policy.action_net.bias[axis] += step
            costs.append(flown(policy, price)[2].sum())
        with torch.no_grad():
            policy.action_net.bias[axis] += 1e-3
        assert slope == pytest.approx((costs[0] - costs[1]) / 2e-3, rel=0.02)


def test_after_learning_collisions_end_the_flights_of_the_rows_again():
    model = model_of()
    model.learn(100)
    batch = model.env.unwrapped.batch
    assert batch.state.config["collision_m"][0] == batch.params.zone.collision_m > 0.0


def test_rows_that_change_observations_are_refused():
    env = VecFrameStack(make_vec_env("rss_gym/Encounter-v0", n_envs=4, seed=0), 2)
    with pytest.raises(ParamsError, match="VecFrameStack"):
        Pathwise("MlpPolicy", env, seed=0).learn(100)


def test_a_recipe_with_stacked_rows_is_refused():
    with pytest.raises(ParamsError, match="stack = 1"):
        recipe.load("pathwise", {"vec.stack": 2})


SMALL = {
    "recipe.steps": 60_000,
    "vec.n_envs": 64,
    "imitation.episodes": 128,
    "imitation.epochs": 4,
    "validation.every_steps": 30_000,
    "validation.episodes": 200,
    "checkpoint.every_steps": 10_000,
}


@pytest.mark.slow
def test_a_run_of_the_recipe_ends_cheaper_than_it_began(tmp_path):
    folder = run.start(recipe.load("pathwise", SMALL), tmp_path / "run", show=False)
    agent = load_agent(folder)
    rows = (tmp_path / "run" / "seed-0" / "validation.csv").read_text(encoding="utf-8").splitlines()
    column = rows[0].split(",").index("cost_m")
    costs = [float(row.split(",")[column]) for row in rows[1:]]
    assert len(costs) >= 3
    assert min(costs[1:]) < costs[0]
    assert agent.document["training"]["validation"]["cost_m"] == pytest.approx(min(costs))
