"""Scores on a road, by the evaluator of the air: the same result in every process, records verified and ranked."""

import json
import sys
import types

import numpy as np
import pytest

from rss_gym.cli import main
from rss_gym.domain import ROAD, domain_of
from rss_gym.eval import evaluate, fly, leaderboard, merge, ranking, reading, records, report
from rss_gym.eval.episodes import Block, PolicyError, fly_episodes
from rss_gym.eval.suites import SUITES, find
from rss_gym.eval.verify import verify
from rss_gym.highway.env import RoadEnv
from rss_gym.highway.params import actions
from rss_gym.params import ParamsError

pytestmark = pytest.mark.slow

ROADS = {name: suite for name, suite in SUITES.items() if suite.domain is ROAD}
SUITE = find("highway-v0")


@pytest.fixture(scope="module")
def result():
    """Five episodes of the three drivers."""
    return evaluate(["rule", "idm"], "highway-v0", episodes=5, progress=False)


@pytest.fixture(scope="module")
def folder(result, tmp_path_factory):
    """Its record."""
    return records.save(result, tmp_path_factory.mktemp("record") / "run", page=report.write)


def test_drives_are_paired_by_key(result):
    assert [scored.entry.name for scored in result.policies] == ["none", "rule", "idm"]
    none, rule, _ = (scored.table for scored in result.policies)
    assert none["episode"].tolist() == rule["episode"].tolist() == list(range(5))
    assert not none["manoeuvre_m"].any() and rule["manoeuvre_m"].any()
    assert none["collision"].any()
    env = RoadEnv()
    env.reset(seed=0, options={"split": "suite", "episode": 2})
    start, done = env.vehicle.position.copy(), False
    while not done:
        _, _, terminated, truncated, _ = env.step(1)
        done = terminated or truncated
    assert none["flown_m"][2] == pytest.approx(np.linalg.norm(env.vehicle.position - start), rel=1e-6)


def test_a_batch_is_its_rows(result):
    """Drives that end at times of their own leave each other alone, and manoeuvres end with the drive of `none`."""
    rule = result.policies[1]
    for episode in range(5):
        alone = evaluate("rule", SUITE, episodes=range(episode, episode + 1), progress=False)
        assert alone.policies[1].table.tobytes() == rule.table[episode : episode + 1].tobytes()


def test_metrics_follow_from_the_tables(result):
    for scored in result.policies:
        collisions = int(scored.table["collision"].sum())
        assert scored.metrics["collision_rate"].value == pytest.approx(collisions / 5)
        assert scored.metrics["lane_deviation_m"].value == pytest.approx(scored.table["lane_deviation_m"].mean())
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


def test_parts_and_processes_change_nothing(result):
    again = evaluate(["rule", "idm"], "highway-v0", episodes=5, workers=2, block=3, progress=False)
    parts = merge(fly(["rule", "idm"], "highway-v0", numbers) for numbers in (range(2, 5), range(2)))
    for one, two, three in zip(result.policies, again.policies, parts.policies, strict=True):
        assert one.table.tobytes() == two.table.tobytes() == three.table.tobytes()


def test_a_record_is_verified(folder):
    verdict = verify(folder, every=True)
    assert verdict.verified and verdict.flown == {"none": 5, "rule": 5, "idm": 5}
    page = (folder / "report.html").read_text()
    assert "Replays" in page and "Not flown again" not in page


def test_a_false_record_is_found_out(folder, tmp_path):
    import shutil

    copy = shutil.copytree(folder, tmp_path / "copy")
    content = json.loads((copy / "scores.json").read_text())
    content["policies"][1]["metrics"]["lane_deviation_m"]["value"] += 1.0
    (copy / "scores.json").write_text(json.dumps(content))
    assert any("lane_deviation_m" in str(difference) for difference in verify(copy).differences)


def test_a_record_may_not_name_code_for_highway_env_to_import(folder, tmp_path):
    import shutil

    copy = shutil.copytree(folder, tmp_path / "copy")
    content = json.loads((copy / "scores.json").read_text())
    content["params"]["road"]["config"] = {"other_vehicles_type": "os.path"}
    (copy / "scores.json").write_text(json.dumps(content))
    with pytest.raises(reading.RecordError, match=r"params\.road\.config = .* must be empty"):
        reading.load(copy)


def test_records_are_ranked_on_a_leaderboard(folder, tmp_path):
    site = leaderboard.build([folder], tmp_path / "site")
    page = site.page.read_text()
    assert "Suite highway-v0" in page and "rule" in page and "near miss" not in page


def test_command(tmp_path, capsys):
    out = tmp_path / "run"
    arguments = ["eval", "--suite", "merge-v0", "--policy", "rule", "--episodes", "2", "--out", str(out)]
    assert main(arguments) == 0
    shown = capsys.readouterr().out
    assert all(
        title in shown for title in ("cost, m", "collisions", "near misses", "mean deviation, m", "zone violations")
    )
    scores = json.loads((out / "scores.json").read_text())
    assert [policy["name"] for policy in scores["policies"]] == ["none", "rule"]
    assert scores["families"] == ["merge"] and not scores["official"]
    assert "Safety against deviation" in (out / "report.html").read_text()
    assert main(["verify", str(out)]) == 0


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (["--families", "crossing"], "a road has no parameter 'families'"),
        (["--policy", "ruel"], "policy 'ruel' is unknown on a road; did you mean 'rule'"),
        (["--policy", "rule:lateral_m=1,lateral_m=2"], "given twice"),
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


class Braker:
    """Brakes at every decision; made from the parameters of the road, as a function that `module:attribute` names."""

    def __init__(self, params):
        self.action = actions(params).index("SLOWER")

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.full(len(observation), self.action), state


def test_policies_of_ones_own(monkeypatch):
    monkeypatch.setitem(sys.modules, "mine", types.SimpleNamespace(Braker=Braker))
    found = evaluate({"one": Braker(SUITE.params), "two": "mine:Braker"}, SUITE, episodes=2, progress=False)
    none, one, two = (scored.table for scored in found.policies)
    assert one.tobytes() == two.tobytes() and (one["speed_deviation_mps"] > none["speed_deviation_mps"] + 1.0).all()


class Coast:
    """Neither accelerates nor steers."""

    kind = np.float32

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((len(observation), 2), self.kind), state


def test_other_actions_of_highway_env():
    params = SUITE.changed(config={"action": {"type": "ContinuousAction"}}).params
    table, _ = fly_episodes(Coast(), "coast", params, Block("suite", 0, [0, 1]))
    assert (table["flown_m"] > 10.0).all()
    Coast.kind = np.float64
    with pytest.raises(PolicyError, match=r"'coast': actions must be 2 of Box\(.*, got array\(\[0\., 0\.\]\)"):
        fly_episodes(Coast(), "coast", params, Block("suite", 0, [0, 1]))


def test_a_policy_of_the_air_is_refused_on_a_road():
    from rss_gym.baselines import make

    with pytest.raises(ParamsError, match="made for the air"):
        evaluate({"mine": make("none")}, "highway-v0", episodes=1)


def test_a_policy_that_fails_is_named():
    class Broken:
        def predict(self, observation, state=None, episode_start=None, deterministic=True):
            return np.array([99]), None

    with pytest.raises(PolicyError, match=r"'broken': discrete actions must be in 0\.\.4, got 99.*of episode 3"):
        fly_episodes(Broken(), "broken", SUITE.params, Block("suite", 0, [3]))


def test_suites_are_told_apart_by_their_hash():
    assert len({found.hash for found in ROADS.values()}) == len(ROADS) == 3
    assert SUITE.changed(information="ranges").hash != SUITE.hash == SUITE.changed().hash
    assert all(domain_of(suite.params).packages == ("highway-env",) for suite in ROADS.values())
