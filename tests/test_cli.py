"""The command line: listings, scores, bad input."""

import importlib
import json
import os
import subprocess
import sys

import pytest

from rss_gym import baselines
from rss_gym.cli import main
from rss_gym.params import Params


def run(capsys, *arguments):
    """Exit status, standard output and error."""
    try:
        status = main(list(arguments))
    except SystemExit as stop:
        status = stop.code
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def test_list_names_everything(capsys):
    status, out, _ = run(capsys, "list")
    assert status == 0
    for name in ("rss_gym/Encounter-v0", "orthogonal", "quadcopter", "mixed", "ppo-short", "encounter-v0"):
        assert name in out


def test_list_json(capsys):
    status, out, _ = run(capsys, "list", "--json")
    titles = {"ids", "policies", "drivers", "channels", "estimators", "trackers", "families", "recipes", "suites"}
    assert status == 0 and set(json.loads(out)) == titles


def test_eval_writes_scores_and_prints_the_table(capsys, tmp_path):
    folder = tmp_path / "run"
    status, out, _ = run(
        capsys, "eval", "--policy", "orthogonal:radius_m=60", "--episodes", "50", "--seed", "3", "--out", str(folder)
    )
    assert status == 0 and "orthogonal:radius_m=60" in out and "none" in out
    scores = json.loads((folder / "scores.json").read_text())
    assert [policy["name"] for policy in scores["policies"]] == ["none", "orthogonal:radius_m=60"]
    assert (scores["episodes"], scores["seed"], scores["official"]) == (50, 3, False)
    rate = scores["policies"][0]["metrics"]["collision_rate"]
    assert rate["n"] == 50 and 0.0 <= rate["low"] <= rate["value"] <= rate["high"] <= 1.0


@pytest.mark.slow
def test_all_on_several_levels_of_information(capsys, tmp_path):
    folder = tmp_path / "runs" / "all"
    arguments = ["--policy", "all", "--information", "positions", "ranges", "--episodes", "5", "--out", str(folder)]
    status, out, _ = run(capsys, "eval", *arguments)
    assert status == 0 and sorted(path.name for path in folder.iterdir()) == ["positions", "ranges"]
    for level in ("positions", "ranges"):
        assert f"scores: {folder / level / 'scores.json'}" in out
        scores = json.loads((folder / level / "scores.json").read_text())
        flown = {policy["name"]: policy["information"] for policy in scores["policies"]}
        able = set(baselines.able(Params.of(information=level)))
        assert set(flown) == able and set(flown.values()) == {level}
    assert "orca" in flown and "modified-orthogonal" in flown


def test_what_cannot_fly_on_a_later_level_is_refused_before_the_first_is_flown(capsys, tmp_path, monkeypatch):
    module = importlib.import_module("rss_gym.eval.evaluate")  # its name in the package is the function's
    monkeypatch.setattr(module, "fly_blocks", lambda *_: pytest.fail("flown"))
    arguments = [
        "--policy",
        "modified-orthogonal",
        "--information",
        "ranges",
        "positions",
        "--out",
        str(tmp_path / "run"),
    ]
    status, out, err = run(capsys, "eval", *arguments)
    assert status == 2 and not out and "cannot fly on information 'positions'" in err and not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--policy", "nobody"], ["'nobody'", "known: "]),
        (["--policy", "none", "--episodes", "0"], ["episodes", "0"]),
        (["--policy", "none", "--episodes", "-5"], ["episodes", "-5"]),
        (["--policy", "none", "--seed", "-1"], ["seed", "-1"]),
        (["--policy", "none", "--workers", "0"], ["workers", "0"]),
        (["--policy", "none", "--suite", "encounter-v1"], ["'encounter-v1'", "encounter-v0"]),
        (["--policy", "none", "--channel", "quadcoptr"], ["'quadcoptr'", "did you mean 'quadcopter'"]),
        (["--policy", "none", "--information", "blind"], ["information", "'blind'"]),
        (["--policy", "none", "--tracker", "bearing"], ["'bearing'", "did you mean 'bearings'"]),
        (["--policy", "none", "--tracker", "bearings"], ["tracker 'bearings'", "information"]),
        (["--policy", "none", "--families", "crosing"], ["'crosing'", "did you mean 'crossing'"]),
        (["--policy", "modified-orthogonal"], ["modified-orthogonal", "'ranges'"]),
        (["--policy", "json:loads"], ["json:loads"]),
        (["--policy", "no_such_module:thing"], ["no_such_module:thing"]),
        (["--policy", "none", "none"], ["'none'", "twice"]),
        (["--policy", "all", "orca"], ["'orca'", "twice"]),
        (["--policy", "climb"], ["'climb'", "space", "planar"]),
        (["--policy", "none", "--information", "ranges", "ranges"], ["information", "'ranges'", "twice"]),
        (["--policy", "none", "--information", "ranges", "--episodes", "0"], ["episodes"]),
        (["--policy", "none", "--episodes", "2", "--information", "ranges", "blind"], ["information", "'blind'"]),
    ],
)
def test_bad_input_is_one_sentence(capsys, tmp_path, arguments, words):
    folder = tmp_path / "run"
    status, out, err = run(capsys, "eval", *arguments, "--out", str(folder))
    assert status == 2 and not out and len(err.strip().splitlines()) == 1
    for word in words:
        assert word in err
    assert not folder.exists() and not list(tmp_path.iterdir())


def test_an_existing_folder_is_not_overwritten(capsys, tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "mine.txt").write_text("precious")
    status, _, err = run(capsys, "eval", "--policy", "none", "--episodes", "5", "--out", str(tmp_path / "run"))
    assert status == 2 and "exists" in err
    assert (tmp_path / "run" / "mine.txt").read_text() == "precious"


@pytest.mark.skipif(hasattr(os, "geteuid") and os.geteuid() == 0, reason="root may write everywhere")
def test_an_unwritable_folder_is_refused(capsys, tmp_path):
    tmp_path.chmod(0o500)
    status, _, err = run(capsys, "eval", "--policy", "none", "--episodes", "5", "--out", str(tmp_path / "run"))
    assert status == 2 and "cannot be written" in err


def test_a_folder_below_a_file_is_refused(capsys, tmp_path):
    (tmp_path / "file").write_text("")
    status, _, err = run(capsys, "eval", "--policy", "none", "--episodes", "5", "--out", str(tmp_path / "file" / "run"))
    assert status == 2 and "cannot be written" in err


def test_help_needs_nothing_heavy():
    code = "import sys; from rss_gym.cli import parser; parser(); assert 'numba' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_every_parameter_has_a_meaning_and_a_line(capsys):
    from rss_gym.listing import parameters
    from rss_gym.meanings import MEANINGS

    assert {row["name"] for row in parameters()} == set(MEANINGS)
    status, out, _ = run(capsys, "params")
    assert status == 0 and all(f"  {name} " in out for name in MEANINGS)
    for row in parameters():
        assert row["range"]
        assert row["unit"] or not row["name"].endswith(("_m", "_s", "_mps", "_db", "_dbm"))


@pytest.mark.parametrize("word", ["collision_m", "Tc", "wander", "zone", "fused"])
def test_parameters_with_a_word(capsys, word):
    status, out, _ = run(capsys, "params", word)
    lines = [line for line in out.splitlines() if line.startswith("  ")]
    assert status == 0 and 0 < len(lines) < 30
    rows = json.loads(run(capsys, "params", word, "--json")[1])
    assert len(rows) == len(lines) and {"name", "default", "unit", "range", "meaning"} <= set(rows[0])


def test_a_parameter_that_names_a_part_lists_those_that_fly(capsys):
    rows = {row["name"]: row["range"] for row in json.loads(run(capsys, "params", "t", "--json")[1])}
    assert rows["estimator"] == "ls, ekf-white-r, ekf-white, ekf-coloured, ekf-log"
    assert rows["tracker"] == "latest, fused, bearings"


def test_no_such_parameter(capsys):
    status, out, err = run(capsys, "params", "colision_m")
    assert status == 2 and not out and "did you mean 'collision_m'" in err
