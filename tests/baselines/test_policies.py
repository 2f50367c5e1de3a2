"""Contracts over the registry of policies."""

import numpy as np
import pytest

from rss_gym import baselines, observation
from rss_gym.core import Batch, decode
from rss_gym.params import Params, ParamsError
from rss_gym.testing.rule import WORLDS, check_rule_in


def flown(policy, count, steps=60):
    """Observations, actions and states of a flight of `count` rows."""
    batch = Batch(policy.params, count)
    batch.seed(np.arange(count, dtype=np.uint64))
    batch.reset(np.ones(count, bool))
    state, trace = None, []
    for step in range(steps):
        actions, state = policy.predict(batch.observations, state, np.full(count, step == 0))
        trace.append((batch.observations.copy(), actions.copy(), state.copy()))
        ended = batch.episode["terminated"] | batch.episode["truncated"]
        batch.step(decode(actions, policy.params, count), ~ended)
    return trace


@pytest.mark.parametrize("world", [pytest.param(w, marks=[pytest.mark.slow] * (w == "several")) for w in WORLDS])
@pytest.mark.parametrize("name", baselines.POLICIES)
def test_every_rule_keeps_the_contract_of_a_policy(name, world):
    check_rule_in(name, world)


def test_every_policy_has_a_summary():
    for item in baselines.describe().values():
        assert item["summary"].endswith(".")


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ("ortogonal", ["'ortogonal'", "did you mean 'orthogonal'"]),
        ("orthogonal:radius=60", ["'radius'", "did you mean 'radius_m'"]),
        ("orthogonal:radius_m=wide", ["radius_m", "'wide'", "number"]),
        ("orthogonal:radius_m", ["radius_m", "number"]),
        ("orthogonal:radius_m=nan", ["radius_m", "nan"]),
        ("orthogonal:radius_m=-5", ["radius_m", "-5"]),
        ("orthogonal:radius_m=121", ["121", "zone radius 120"]),
        ("none:radius_m=1", ["radius_m", "it has none"]),
    ],
)
def test_bad_specifications_are_refused_in_one_sentence(spec, words):
    with pytest.raises(ParamsError) as caught:
        baselines.make(spec)
    for word in words:
        assert word in str(caught.value)


def test_the_rule_stays_on_its_path_until_it_is_warned():
    policy = baselines.make("orthogonal:radius_m=60")
    warned = np.zeros(32, bool)
    for observations, actions, _ in flown(policy, 32, 120):
        warned |= observation.split(observations, policy.params)["warning"][:, 0] > 0.5
        assert not np.abs(actions[~warned]).max(initial=0.0) > 1e-6
    assert warned.any()


def test_climb_flies_its_height():
    policy = baselines.make("climb:up_m=8", Params.of(planar=False))
    batch = Batch(policy.params, 64)
    batch.reset(np.ones(64, bool))
    for _ in range(40):
        actions, _ = policy.predict(batch.observations)
        batch.step(decode(actions, policy.params, 64), np.ones(64, bool))
    agent = batch.state.aircraft[:, 0]
    np.testing.assert_allclose(np.mean(agent["position_m"] - agent["planned_m"], axis=0)[2], 8.0, atol=1.5)


@pytest.mark.parametrize("planar", [True, False])
def test_those_able_in_a_world_can_be_made_in_it(planar):
    for information in ("oracle", "positions", "ranges"):
        params = Params.of(information=information, planar=planar)
        names = baselines.able(params)
        assert ("climb" in names) is not planar and {"none", "constant", "orca", "mpc"} <= set(names)
        assert ("modified-orthogonal" in names) is (information == "ranges")
        assert all(baselines.make(name, params).params == params for name in names)


def displaced(spec, decisions, **keywords):
    """Own positions minus the predefined ones along the leg, to the right and up, of straight flights; speeds."""
    policy = baselines.make(spec, Params.of(gust_mps=0.0, **keywords))
    batch = Batch(policy.params, 8)
    batch.seed(np.arange(8, dtype=np.uint64))
    batch.reset(np.ones(8, bool))
    state = None
    for _ in range(decisions):
        actions, state = policy.predict(batch.observations, state)
        batch.step(decode(actions, policy.params, 8), np.ones(8, bool))
    agent = batch.state.aircraft[:, 0]
    agent = agent[(agent["path_points"] == 2) & ~batch.episode["collision"]]
    assert len(agent) >= 3
    along = agent["along"]
    axes = np.stack([along, np.stack([along[:, 1], -along[:, 0], along[:, 2]], axis=1), [[0.0, 0.0, 1.0]] * len(agent)])
    offset = agent["position_m"] - agent["planned_m"]
    return (axes * offset).sum(axis=2).T, (axes * agent["velocity_mps"]).sum(axis=2).T, agent


def test_constant_flies_to_the_displacement_it_names():
    offset, _, _ = displaced("constant:right_m=12,along_m=-5", 40)
    np.testing.assert_allclose(offset[:, :2], np.tile([-5.0, 12.0], (len(offset), 1)), atol=0.5)


def test_a_displacement_of_a_kilometre_is_flown_to_at_full_speed():
    offset, velocity, _ = displaced("constant:right_m=1000", 60)
    np.testing.assert_allclose(np.linalg.norm(velocity, axis=1), 5.0, rtol=0.01)
    assert (offset[:, 1] > 100.0).all()


def test_a_constant_velocity_is_flown():
    _, velocity, _ = displaced("velocity:along_mps=-1,right_mps=2,up_mps=0.5", 20, planar=False)
    np.testing.assert_allclose(velocity, np.tile([-1.0, 2.0, 0.5], (len(velocity), 1)), atol=0.05)


def test_who_stops_stands_still_and_who_runs_back_goes_back():
    _, velocity, _ = displaced("stop", 20)
    np.testing.assert_allclose(velocity, 0.0, atol=0.02)
    _, velocity, agent = displaced("back", 20)
    cruise = np.linalg.norm(agent["planned_mps"], axis=1)
    np.testing.assert_allclose(velocity[:, 0], cruise - 5.0, atol=0.05)


@pytest.mark.parametrize("target", [(-60.0, -110.0), (-110.0, 30.0)])
def test_far_displacements_are_reached_though_the_observation_is_clipped(target):
    offset, _, _ = displaced(f"constant:along_m={target[0]},right_m={target[1]}", 150, families="parallel-pass")
    np.testing.assert_allclose(offset[:, :2], np.tile(target, (len(offset), 1)), atol=1.0)


DEAF = {"agent": "gnss", "intruder": "gnss", "estimator": "ls", "channel": {"sensitivity_dbm": 0.0}}


@pytest.mark.parametrize("spec", ["constant:along_m=10,right_m=150", "velocity", "stop", "back", "climb", "blind"])
def test_the_radio_changes_nothing_for_who_does_not_listen(spec):
    ends = []
    for keywords in ({}, DEAF):
        policy = baselines.make(spec, Params.of(planar=spec != "climb", **keywords))
        batch, done, state = Batch(policy.params, 100), np.zeros(100, bool), None
        batch.seed(np.arange(100, dtype=np.uint64))
        batch.reset(~done)
        while not done.all():
            actions, state = policy.predict(batch.observations, state)
            batch.step(decode(actions, policy.params, 100), ~done)
            done = batch.episode["terminated"] | batch.episode["truncated"]
        ends.append(batch.episode.copy())
    for column in ("collision", "snmac", "min_separation_m", "cost_m"):
        np.testing.assert_array_equal(ends[0][column], ends[1][column])
