"""Studies: their sections, their records and pages, and that the one of learning trains with what the example shows."""

import argparse
import ast
import re
from pathlib import Path

import numpy as np
import pytest

from rss_gym import cli
from rss_gym.eval import studies
from rss_gym.eval.columns import AIR
from rss_gym.eval.studies import world
from rss_gym.eval.studies.section import Criterion, Scale, Section
from rss_gym.eval.studies.study import Job, Part, fly, read
from rss_gym.eval.studies.world import leak, learning, order, radio, rows, sensor
from rss_gym.params import ParamsError

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "examples" / "sb3_ppo.py"
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


def test_pages_that_are_no_clone_are_refused_before_anything_is_flown(tmp_path):
    with pytest.raises(ParamsError, match="must be the root of a clone"):
        studies.run("world", ["--pages", str(tmp_path)])


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


def test_docs_hold_no_python_but_what_builds_the_site():
    found = {path.relative_to(ROOT / "docs").parts[0] for path in (ROOT / "docs").rglob("*.py")}
    assert found <= {"conf.py", "extensions", "gallery"}  # the last is made by the build, of examples/gallery


def test_the_command_names_every_study(capsys):
    with pytest.raises(SystemExit):
        cli.main(["study", "--help"])
    shown = " ".join(capsys.readouterr().out.split())
    *most, last = studies.STUDIES
    assert f"{', '.join(most)} or {last}" in shown


@pytest.mark.parametrize("name", studies.STUDIES)
def test_every_study_can_be_called(name, capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main(["study", name, "--help"])
    assert stop.value.code == 0 and "--pages" in capsys.readouterr().out


def test_a_part_stands_between_its_marks(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("a\n<!-- one -->\nold\n<!-- /one -->\nb\n")
    Part("new\\1", "page.md", mark="one").put(tmp_path)
    assert page.read_text() == "a\n<!-- one -->\nnew\\1\n<!-- /one -->\nb\n"
    Part("shown", "whole.bin", b"content").put(tmp_path)
    assert (tmp_path / "whole.bin").read_bytes() == b"content"
    Part("only printed").put(tmp_path)
    with pytest.raises(ParamsError, match="must have the marks <!-- two --> once, got 0 times"):
        Part("new", "page.md", mark="two").put(tmp_path)
    with pytest.raises(ParamsError, match="--pages names the root of a clone"):
        Part("new", "missing.md", mark="one").put(tmp_path)


@pytest.mark.parametrize("name", studies.STUDIES)
def test_the_pages_of_a_study_have_its_marks(name):
    files = [*(ROOT / "eval" / "studies").glob(f"{name}/*.py"), *(ROOT / "eval" / "studies").glob(f"{name}.py")]
    source = "\n".join(path.read_text() for path in files)
    constants = dict(re.findall(r'\b([A-Z]+)(?:, \w+)? = "([^"]+)"', source))
    found = re.findall(r'Part\(.*, ("[^"]+"|[A-Z]+), mark="(\w+)"\)', source)
    assert len(found) == source.count("mark=")
    for path, mark in found:
        page = (ROOT / constants.get(path, path.strip('"'))).read_text()
        assert page.count(f"<!-- {mark} -->") == page.count(f"<!-- /{mark} -->") == 1, (path, mark)


def test_a_record_on_disk_is_not_flown_again(tmp_path, capsys, monkeypatch):
    job = Job("tiny", "encounter-v0", ("stop",), 20)
    folders = fly([job], 1, tmp_path / "runs")
    rows = read(folders.values())
    assert rows["stop"].episodes == 20 and "1 records, 0 of them flown before" in capsys.readouterr().out
    monkeypatch.setattr(Job, "fly", None)
    assert fly([job], 1, tmp_path / "runs") == folders
    assert Job("tiny", "encounter-v0", ("stop",), 21).folder != job.folder


@pytest.mark.slow
def test_the_study_of_the_readme_gives_what_it_shows():
    pytest.importorskip("PIL")
    parts = list(studies.load("readme").run(argparse.Namespace(pages=ROOT)))
    pages = (ROOT / "README.md").read_text() + (ROOT / "docs" / "agents.md").read_text()
    assert [part.mark for part in parts if part.mark and part.text not in pages] == []
    assert parts[-1].content.startswith(b"GIF89a") and len(parts[-1].content) < 1_000_000


def test_calibration_says_which_folder_it_needs(tmp_path, capsys):
    assert cli.main(["study", "calibration", str(tmp_path)]) == 2
    assert "has no folder 'ble_tracks'" in capsys.readouterr().err


def test_titles_of_the_page_are_those_of_the_study():
    """Until it is flown again, the page holds what the study would print today."""
    page = (ROOT / "docs" / "world.md").read_text(encoding="utf-8")
    assert page.startswith("\n".join(["# Study: world", "", world.page([]).splitlines()[2], ""]))
    learned = ("policy", "decisions", "CPU s", *(AIR[metric].heading for metric in learning.METRICS))
    for header in (rows.HEADER, learned):
        assert f"\n| {' | '.join(header)} |\n" in page
    assert "cost m" not in page
