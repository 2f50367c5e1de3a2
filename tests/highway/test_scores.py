"""Scores on a road: the same table as in the world, the same result in every process, the command."""

import json
import sys
from typing import ClassVar

import numpy as np
import pytest

from rss_gym.cli import main
from rss_gym.eval import ranking, reading, road
from rss_gym.eval.episodes import Block, PolicyError
from rss_gym.eval.road.drives import drive, environment
from rss_gym.params import ParamsError


@pytest.fixture(scope="module")
def result():
    """Five episodes of the three drivers."""
    return road.evaluate(["rule", "idm"], episodes=5)


@pytest.mark.slow
def test_drives_are_paired_by_key(result):
    assert [scored.entry.name for scored in result.policies] == ["none", "rule", "idm"]
    none, rule, _ = (scored.table for scored in result.policies)
    assert none["episode"].tolist() == rule["episode"].tolist() == list(range(5))
    assert not none["manoeuvre_m"].any() and rule["manoeuvre_m"].any()
    assert none["collision"].any()
    same_start = environment(road.SUITES["highway-v0"], {})
    same_start.reset(seed=0, options={"split": "suite", "episode": 2})
    x_m = same_start.road.vehicle.position[0]
    assert none["flown_m"][2] == pytest.approx(
        np.linalg.norm(_last_position(same_start, 2) - [x_m, same_start.road.vehicle.position[1]]), rel=1e-6
    )


def _last_position(env, episode):
    """Where `none` ends, driven by hand; `env` is left at the start of the episode."""
    start = env.reset(seed=0, options={"split": "suite", "episode": episode})
    assert start is not None
    done = False
    while not done:
        _, _, terminated, truncated, _ = env.step(1)
        done = terminated or truncated
    last = env.road.vehicle.position.copy()
    env.reset(seed=0, options={"split": "suite", "episode": episode})
    return last


def test_metrics_follow_from_the_tables(result):
    for scored, deviations in zip(result.policies, result.deviations, strict=True):
        collisions = int(scored.table["collision"].sum())
        assert scored.metrics["collision_rate"].value == pytest.approx(collisions / 5)
        assert scored.metrics["lane_deviation_m"].value == pytest.approx(deviations["lane_deviation_m"].mean())
        assert scored.metrics["speed_deviation_mps"].unit == "m/s"
        assert "zone_severity" not in scored.metrics
        lost_s = scored.table["duration_s"] - scored.table["flown_s"]
        assert (lost_s[~scored.table["collision"]] == 0.0).all() and (lost_s >= 0.0).all()
    assert result["none"]["risk_ratio"].value == 1.0
    assert result["none"]["lane_deviation_m"].value == pytest.approx(0.0, abs=1e-6)


def test_drives_are_ranked_by_their_mean_cost(result):
    for scored in result.policies:
        table = scored.table
        cost_m = table["deviation_mean_m"] + 100.0 * table["snmac"] + 10_000.0 * table["collision"]
        assert table["cost_m"] == pytest.approx(cost_m)
        assert scored.metrics["cost_m"].value == pytest.approx(cost_m.mean())
        assert (table["snmac"] >= table["collision"]).all()
    places = ranking.of(result, differences=True)
    assert [place.name for place in places["oracle"]] == ["idm"]  # which sees true states
    assert [place.name for place in places["positions"]] == ["rule", "none"]
    means = [result[place.name]["cost_m"].value for place in places["positions"]]
    gap = places["positions"][1].difference
    assert gap.value == pytest.approx(means[1] - means[0]) and gap.low < gap.value < gap.high


@pytest.mark.slow
def test_processes_change_nothing(result, monkeypatch):
    monkeypatch.setattr(sys.modules["rss_gym.eval.road.evaluate"], "CHUNK", 3)
    again = road.evaluate(["rule", "idm"], episodes=5, workers=2)
    for one, two in zip(result.policies, again.policies, strict=True):
        assert np.array_equal(one.table, two.table)


def test_command(tmp_path, capsys):
    out = tmp_path / "run"
    arguments = ["eval", "--suite", "merge-v0", "--policy", "rule", "--episodes", "2", "--out", str(out)]
    assert main(arguments) == 0
    shown = capsys.readouterr().out
    assert all(title in shown for title in ("cost m", "collision rate", "near misses", "deviation m"))
    scores = json.loads((out / "scores.json").read_text())
    assert [policy["name"] for policy in scores["policies"]] == ["none", "rule"]
    assert scores["families"] == ["merge"] and not scores["official"]
    assert np.load(out / "deviations.npz")["lane_deviation_m"].shape == (2, 2)
    assert "Safety against deviation" in (out / "report.html").read_text()
    with pytest.raises(reading.RecordError, match="is of a road"):
        reading.load(out)


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (["--families", "crossing"], "only channel, information, estimator can be changed"),
        (["--policy", "ruel"], "policy 'ruel' is unknown on a road; did you mean 'rule'"),
        (["--reference", "idm"], "reference 'idm' is not among the policies"),
        (["--episodes", "0"], "episodes must be a whole number >= 1"),
        (["--channel", "papre"], "did you mean 'paper'"),
    ],
)
def test_refused(more, sentence, tmp_path, capsys):
    arguments = ["eval", "--suite", "highway-v0", "--policy", "rule", "--out", str(tmp_path / "run"), *more]
    assert main(arguments) == 2
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_unknown_road():
    with pytest.raises(ParamsError, match="did you mean 'highway-v0'"):
        road.evaluate(["rule"], "higway-v0")


def test_a_policy_that_fails_is_named():
    class Broken:
        keywords: ClassVar[dict[str, object]] = {}

        def predict(self, observation, state=None, episode_start=None, deterministic=True):
            return np.array([99]), None

    suite = road.SUITES["highway-v0"]
    with pytest.raises(
        PolicyError, match=r"'broken': action must be in Discrete\(5\), got .*99.*decision 0 of episode 3"
    ):
        next(drive(Broken(), "broken", environment(suite, {}), Block("suite", 0, [3])))


def test_suites_are_told_apart_by_their_hash():
    suite = road.SUITES["highway-v0"]
    assert len({found.hash for found in road.SUITES.values()}) == len(road.SUITES)
    assert suite.changed(information="ranges").hash != suite.hash == suite.changed().hash
