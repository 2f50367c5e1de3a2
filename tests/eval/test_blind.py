"""The sweep of policies that do not listen: what they fly, and that leaving out the radio changes nothing for them."""

import math

import numpy as np
import pytest

from rss_gym.core import Batch
from rss_gym.eval import blind
from rss_gym.eval.blind import Blind, Displaced, Drifting
from rss_gym.eval.episodes import Block, fly_episodes, start
from rss_gym.eval.suites import find
from rss_gym.params import Params


def displacement(policy, params, decisions, n=6):
    """Way point minus predefined trajectory after so many decisions, in m, (n, 3)."""
    batch = start(params, Block("suite", 0, range(n)))
    state, first, done = None, np.ones(n, bool), np.zeros(n, bool)
    for _ in range(decisions):
        actions, state = policy.predict(batch.observations, state, first)
        padded = np.zeros((n, 3))
        padded[:, : actions.shape[1]] = actions
        batch.step(padded, ~done)
        first = np.zeros(n, bool)
    return apart(batch)


def apart(batch: Batch):
    own = batch.state.aircraft[:, 0]
    away, along = own["way_point_m"] - own["planned_m"], own["along"]
    forth = away[:, 0] * along[:, 0] + away[:, 1] * along[:, 1]
    right = away[:, 0] * along[:, 1] - away[:, 1] * along[:, 0]
    return np.stack([forth, right, away[:, 2]], axis=1)


@pytest.mark.parametrize("target_m", [(0.0, 10.0, 0.0), (-20.0, 5.0, 0.0), (6.0, -3.0, 8.0)])
def test_a_displacement_is_reached_and_kept(target_m):
    params = Params.of(planar=target_m[2] == 0.0, families="crossing", tail_min_s=45.0)
    policy = Blind(Displaced("there", target_m), params)
    for decisions in (60, 70):
        found = displacement(policy, params, decisions)
        np.testing.assert_allclose(found, np.tile(target_m, (6, 1)), atol=0.3)


def test_what_is_far_is_reached_too():
    """The observation stretches a displacement and clips none."""
    params = Params.of(families="crossing", tail_min_s=45.0)
    found = displacement(Blind(Displaced("", (0.0, -100.0, 0.0)), params), params, 90)
    np.testing.assert_allclose(found, np.tile([0.0, -100.0, 0.0], (6, 1)), atol=0.5)


def test_drifting_stopping_and_running_back():
    params = Params.of(families="crossing", gust_mps=0.0)
    t = 10 * params.clock.decision_s
    np.testing.assert_allclose(
        displacement(Blind(Drifting("", (0.0, 2.0, 0.0)), params), params, 10),
        np.tile([0.0, 2.0 * t, 0.0], (6, 1)),
        atol=1e-4,
    )
    cruise = np.linalg.norm(start(params, Block("suite", 0, range(6))).state.aircraft[:, 0]["planned_mps"], axis=1)
    stopped = displacement(Blind(Drifting("", planned=-1.0), params), params, 10)
    np.testing.assert_allclose(stopped[:, 0], -cruise * t, atol=1e-4)
    back = displacement(Blind(Drifting("", (-5.0, 0.0, 0.0), -1.0), params), params, 10)
    np.testing.assert_allclose(back[:, 0], -5.0 * t, atol=1e-4)  # an action changes the velocity by the limit at most


@pytest.mark.parametrize("suite", ["encounter-v0", "encounter3d-v0", "merging-v0", "gnss-v0"])
def test_the_radio_changes_nothing_for_who_does_not_listen(suite):
    params = find(suite).params
    tried = list(blind.manoeuvres(params))
    for manoeuvre in (tried[1], tried[7], tried[-1]):
        tables = [
            fly_episodes(Blind(manoeuvre, one), manoeuvre.name, one, Block("suite", 0, range(40)))[0]
            for one in (params, blind.deafened(params))
        ]
        for column in ("collision", "snmac", "cost_m", "deviation_mean_m", "min_separation_m", "flown_m"):
            assert np.array_equal(tables[0][column], tables[1][column]), (manoeuvre.name, column)


def test_what_is_swept():
    flat, space = (list(blind.manoeuvres(Params.of(planar=planar))) for planar in (True, False))
    names = [manoeuvre.name for manoeuvre in space]
    assert len(set(names)) == len(names) and [one.name for one in flat] == names[: len(flat)]
    sizes = {round(math.hypot(*one.target_m[:2])) for one in flat if isinstance(one, Displaced)}
    assert sizes == {5, 10, 20, 30, 60, 120, 300, 1000}
    assert {"stopping", "running back"} <= set(names) and any("down" in name for name in names)


def test_the_cheapest_comes_first_and_flies_all_encounters(monkeypatch):
    few = [Displaced("near", (0.0, 5.0, 0.0)), Displaced("far", (0.0, 120.0, 0.0)), Drifting("stopping", planned=-1.0)]
    monkeypatch.setattr(blind, "manoeuvres", lambda params: iter(few))
    swept = blind.sweep("encounter-v0", 60, first=20, kept=2)
    assert len(swept) == 2 and [one.cost_m.n for one in swept] == [60, 60]
    assert (
        swept[0].cost_m.value <= swept[1].cost_m.value and blind.cheapest("encounter-v0", 60, first=20).name != "near"
    )
