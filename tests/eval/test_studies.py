"""Studies: their sections, and that the one of learning trains with what the example shows."""

import ast
from pathlib import Path

import numpy as np
import pytest

from rss_gym import cli
from rss_gym.eval.studies import Scale
from rss_gym.eval.studies.section import Criterion, Section
from rss_gym.eval.studies.world import leak, learning, order, radio, rows, sensor

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "sb3_ppo.py"
TINY = Scale(episodes=40, workers=1, decisions=0, seeds=0)


def test_a_section_says_what_was_met_and_missed():
    criteria = [Criterion("at least 2", "3", True), Criterion("at most 2", "3", False)]
    section = Section("Title", "How.", ("a", "bb"), [("1", "2"), ("333", "4")], criteria)
    assert section.text.splitlines()[3:6] == ["a    bb", "1    2", "333  4"]
    assert "met: at least 2; measured: 3" in section.text and "MISSED: at most 2; measured: 3" in section.text
    assert "| a | bb |\n| --- | --- |\n| 1 | 2 |\n| 333 | 4 |" in section.markdown


def test_the_study_trains_with_the_settings_of_the_example():
    found = {}
    for node in ast.walk(ast.parse(EXAMPLE.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("make_vec_env", "VecNormalize", "PPO"):
            found[node.func.id] = {word.arg: word.value for word in node.keywords if word.arg}
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") in ("options", "prices"):
            found[node.targets[0].id] = ast.literal_eval(node.value)
    vec = {name: ast.literal_eval(value) for name, value in found["make_vec_env"].items()}
    assert vec == {"n_envs": learning.ROWS, "seed": 0}
    assert found["prices"] == learning.WORLD
    assert found["options"] == learning.OPTIONS
    assert ast.literal_eval(found["VecNormalize"]["norm_obs"]) is False
    rate = found["PPO"]["learning_rate"].body
    assert learning.LEARNING_RATE in [n.value for n in ast.walk(rate) if isinstance(n, ast.Constant)]


def test_ratio_names_what_never_happened():
    assert sensor.ratio(0.02, 0.001, 100) == "20.0 times"
    assert sensor.ratio(0.02, 0.0, 100) == "2.00e-02 against none in 100"


def test_rows_have_the_header_s_columns():
    scores = rows.fly(["orca:radius_m=20"], TINY)["orca:radius_m=20"]
    assert len(rows.row("orca", "here", scores)) == len(rows.HEADER)
    assert rows.danger(scores) == rows.value(scores, "collision_rate") + rows.value(scores, "snmac_rate")


def test_the_radio_of_the_paper_gives_its_numbers():
    section = radio.section()
    assert len(section.rows) == len(section.criteria) == 4
    assert all(criterion.met for criterion in section.criteria), section.text


def test_residual_is_that_of_the_half_that_was_not_fitted():
    random = np.random.default_rng(0)
    x = random.normal(size=4000)
    assert leak.residual([x], 3.0 * x + 1.0) < 1e-9
    assert leak.residual([x], random.normal(size=4000)) == pytest.approx(1.0, abs=0.05)


def test_return_and_cost_are_those_of_the_flights(monkeypatch):
    monkeypatch.setattr(order, "EPISODES", 50)
    mean_return, mean_cost = order._means("orthogonal:radius_m=40")
    assert mean_return == pytest.approx(-mean_cost, abs=1e-9)
    assert mean_cost > 0.0


def test_an_unknown_study_is_refused_by_name(capsys):
    assert cli.main(["study", "wrold"]) == 2
    assert "study 'wrold' is unknown; did you mean 'world'?" in capsys.readouterr().err
