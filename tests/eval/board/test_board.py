"""A season from its opening to its pages."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from rss_gym import baselines
from rss_gym.cli import main
from rss_gym.eval import evaluate
from rss_gym.eval.board import chain, fly, season, site, submit
from rss_gym.eval.board.entry import read
from rss_gym.eval.board.limits import fly_here
from rss_gym.eval.records import table_digest
from rss_gym.params import ParamsError

PATIENCE_S = 900.0  # until something counts as hanging: the machine may be loaded
SUITE, PUBLIC, SEALED = "smoke-v0", 24, 20


def lines_of(folder):
    return chain.read(folder / "board" / "board.jsonl")


def test_rows_are_what_the_evaluator_says(flown):
    line = next(line for line in lines_of(flown) if line["entry"]["name"] == "wide-turner")
    result = evaluate(["orthogonal:radius_m=60"], SUITE, episodes=PUBLIC, progress=False)
    assert line["public"]["table_sha256"] == table_digest(result.policies[1].table)
    metric = result["orthogonal:radius_m=60"]["cost_m"]
    assert (line["public"]["metrics"]["cost_m"]["value"], line["public"]["metrics"]["cost_m"]["high"]) == (
        metric.value,
        metric.high,
    )


def test_when_it_closes_anyone_can_fly_the_sealed_encounters(board):
    commitment = season.load(board / "season.json").commitment
    closed = season.close(board / "season.json")
    assert closed == season.load(board / "season.json") and closed.commitment == commitment
    seed = season.sealed_seed(closed.secret, SUITE)
    result = evaluate(["orthogonal:radius_m=60"], SUITE, episodes=SEALED, seed=seed, progress=False)
    line = next(line for line in lines_of(board) if line["entry"]["name"] == "wide-turner")
    assert line["sealed"]["table_sha256"] == table_digest(result.policies[1].table)
    assert season.secret_of(board / "season.json") == closed.secret


def test_private_files_are_private(flown):
    assert not (flown / "season.json.secret").stat().st_mode & 0o077
    assert not (flown / "board.key").stat().st_mode & 0o077
    published = [path.name for path in (flown / "board").rglob("*") if path.is_file()]
    assert "board.key" not in published and not any("secret" in name for name in published)


def test_what_is_there_is_not_flown_again(board):
    def runner(job):
        raise AssertionError(job)

    done = fly.fly(board / "entries", board / "season.json", board / "board", runner=runner, references=False)
    assert not done.appended and done.before == 3 and not done.refused


def test_two_processes_do_not_write_one_board(board):
    with fly.held(board / "board"), pytest.raises(ParamsError, match="in use by another process"):
        fly.fly(board / "entries", board / "season.json", board / "board", runner=fly_here, references=False)


@pytest.mark.slow
def test_a_second_season_is_appended_to_the_same_board(board):
    season.close(board / "season.json")
    season.new(board / "next.json", "second", [SUITE], 6, 6)
    done = fly.fly(board / "entries", board / "next.json", board / "board", runner=fly_here, references=False)
    assert len(done.appended) == 3 and len(lines_of(board)) == 6 and not done.refused
    out = site.build(board / "board", [board / "next.json", board / "season.json"], board / "site", count=0)
    text = out.read_text(encoding="utf-8")
    assert "Season second" in text and "Closed." in text and (out.parent / "second-smoke-v0.html").is_file()


@pytest.mark.slow
@pytest.mark.parametrize("executor", [None, "threads"])
def test_blocks_and_executors_give_the_same_tables(board, monkeypatch, executor):
    before = {line["entry_hash"]: line for line in lines_of(board)}
    monkeypatch.setitem(fly.BLOCK, "air", 7)
    (board / "board" / "board.jsonl").unlink()
    with ThreadPoolExecutor(2) as pool:
        done = fly.fly(
            board / "entries", board / "season.json", board / "board", runner=fly_here, references=False,
            executor=pool if executor else None,
        )  # fmt: skip
    for line in done.appended:
        for part in ("public", "sealed"):
            assert line[part]["table_sha256"] == before[line["entry_hash"]][part]["table_sha256"]


KILLED = """
import sys, time
from rss_gym import baselines
from rss_gym.eval.board import fly
from rss_gym.eval.board.limits import fly_here
fly.BLOCK["air"] = 4
baselines.able = lambda params: ["none", "orthogonal", "right-turn"]
def runner(job):
    table = fly_here(job)
    time.sleep(0.2)
    return table
fly.fly(None, sys.argv[1] + "/season.json", sys.argv[1] + "/board", runner=runner)
"""


@pytest.mark.slow
def test_it_goes_on_after_a_kill(tmp_path, monkeypatch):
    season.new(tmp_path / "season.json", "first", [SUITE], 12, 8)
    process = subprocess.Popen([sys.executable, "-c", KILLED, str(tmp_path)], start_new_session=True)
    work = tmp_path / "season.private" / "work"
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline and len([p for p in work.rglob("*") if p.is_file()]) < 3:
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    kept = {path.name: path.stat().st_mtime_ns for path in work.rglob("*") if path.is_file()}
    flown = []

    def runner(job):
        flown.append((job.seed, job.name, job.first))
        return fly_here(job)

    monkeypatch.setitem(fly.BLOCK, "air", 4)
    monkeypatch.setattr(baselines, "able", lambda params: ["none", "orthogonal", "right-turn"])
    done = fly.fly(None, tmp_path / "season.json", tmp_path / "board", runner=runner)
    assert kept and len(done.appended) == 3 - done.before
    now = {path.name: path.stat().st_mtime_ns for path in work.rglob("*") if path.is_file()}
    assert all(now[name] == kept[name] for name in kept if not name.startswith("."))
    assert (0, "none", 0) not in flown


def test_the_packages_policies_are_flown_as_references(tmp_path, monkeypatch):
    monkeypatch.setattr(baselines, "able", lambda params: ["none", "orthogonal"])
    season.new(tmp_path / "season.json", "first", [SUITE], 6, 6)
    done = fly.fly(None, tmp_path / "season.json", tmp_path / "board", runner=fly_here)
    assert [line["entry"]["name"] for line in done.appended] == ["none", "orthogonal"]


@pytest.mark.slow
def test_roads_too(tmp_path):
    season.new(tmp_path / "season.json", "roads", ["highway-v0"], 2, 2)
    (tmp_path / "entries").mkdir()
    submit.init(tmp_path / "entries" / "a", "idm", name="follower", author="Ada", suite="highway-v0")
    done = fly.fly(
        tmp_path / "entries", tmp_path / "season.json", tmp_path / "board", runner=fly_here, references=False
    )
    (line,) = done.appended
    assert not line["failed"] and line["public"]["episodes"] == 2 and "highway-env" in line["versions"]
    site.build(tmp_path / "board", [tmp_path / "season.json"], tmp_path / "site")


# Entering


def test_init_check_pack(tmp_path, capsys):
    said = []
    folder = submit.init(tmp_path / "mine", str(baselines.AGENTS["ppo-plane"]), name="mine", author="Ada", suite=SUITE)
    entry = submit.check(folder, 6, fly_here, said.append)
    assert entry == read(folder) and re.fullmatch(r"smoke-v0: cost .* over 6 public encounters", said[-1])
    assert main(["submit", "pack", str(folder)]) == 0 and (tmp_path / "mine.zip").is_file()
    assert main(["submit", "init", str(folder), "--policy", "orthogonal"]) == 2
    assert main(["submit", "init", str(tmp_path / "other"), "--policy", "nobody"]) == 2
    assert main(["submit", "pack", str(tmp_path / "nowhere")]) == 2
    assert all(len(line) < 300 for line in capsys.readouterr().err.splitlines())


def test_an_entry_for_all_flies_where_it_can(tmp_path):
    said = []
    submit.init(tmp_path / "mine", str(baselines.AGENTS["ppo-plane"]), name="mine", author="Ada", suite="all")
    submit.check(tmp_path / "mine", 2, lambda job: np.zeros(2, fly.TABLES[job.world().domain.name]), said.append)
    assert any(line.startswith("does not fly on range-only-v0") for line in said)
    assert any(line.startswith("encounter-v0: cost") for line in said)


# Pages


def test_pages(flown, tmp_path):
    out = site.build(flown / "board", [flown / "season.json"], tmp_path / "site", count=1).parent
    names = {path.name for path in out.iterdir()}
    assert {"index.html", "enter.html", "first-smoke-v0.html", "board.json", "board.jsonl", "feed.xml"} <= names
    for page in out.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        outside = {link for link in re.findall(r'(?:href|src)="([^"]*)"', text) if "://" in link}
        assert outside <= {"https://example.org/code"} and "default-src 'none'" in text
        for link in re.findall(r'href="([^"#:]+)"', text):
            assert (page.parent / link).exists(), (page, link)
    pages = {page: page.read_text(encoding="utf-8") for page in (out / "entries").glob("*.html")}
    entry = next(page for page, text in pages.items() if "ppo copy" in text and 'id="player"' not in text)
    text = entry.read_text(encoding="utf-8")
    assert 'aria-label="Paths from above"' in text and "policy.safetensors" in text and "Bob &lt;b&gt;&amp;" in text
    (played,) = (out / "entries").glob(f"{entry.stem}-first-*.html")
    text = played.read_text(encoding="utf-8")
    assert f'<a href="{entry.name}">' in text and 'id="player"' in text and '"beside":1' in text
    rows = json.loads((out / "board.json").read_text())["seasons"][0]["tables"][0]["rows"]
    assert [row["place"] for row in rows] == [1, 2, 3] and rows[-1]["entry"] == "Fleeing"


def test_a_suite_may_have_a_number_of_its_own(tmp_path):
    made = season.new(tmp_path / "s.json", "s", [f"{SUITE}:5", "encounter-v0"], 20, 30)
    assert [(one.name, one.public, one.sealed) for one in made.suites] == [(SUITE, 5, 5), ("encounter-v0", 20, 30)]
    assert season.load(tmp_path / "s.json") == made
    for text in (f"{SUITE}:", f"{SUITE}:0", f"{SUITE}:many", f"{SUITE}:-3"):
        with pytest.raises(ParamsError, match=r"number of encounters|public = (0|-3) must be"):
            season.new(tmp_path / "t.json", "t", [text], 20, 30)
    assert not (tmp_path / "t.json").exists()


@pytest.mark.slow
def test_the_season_of_the_site_can_be_flown_again():
    """One sealed table of the package's own season comes out with the digest of its line."""
    folder = Path(__file__).parents[3] / "docs" / "season"
    lines, told = chain.read(folder / chain.BOARD), season.load(folder / "2026-1.json")
    (line,) = [one for one in lines if (one["entry"]["name"], one["suite"]) == ("orca", "encounter-v0")]
    seed = season.sealed_seed(told.secret, "encounter-v0")
    result = evaluate("orca", "encounter-v0", line["sealed"]["episodes"], seed, workers=1, progress=False)
    assert table_digest(result.policies[-1].table) == line["sealed"]["table_sha256"]


def test_the_commands(tmp_path, flown, capsys):
    new = ["board", "new", str(tmp_path / "s.json"), "--name", "s", "--suites", SUITE, "--public", "3", "--sealed", "3"]
    assert main(new) == 0 and main(new) == 2
    assert "commitment" in capsys.readouterr().out
    assert main(["board", "close", str(tmp_path / "s.json")]) == 0
    assert main(["board", "check", str(flown / "board")]) == 0
    assert "3 lines follow each other" in capsys.readouterr().out
    assert main(["board", "check", str(flown / "board"), "--key", "0" * 64]) == 2
    assert main(["board", "new", str(tmp_path / "t.json"), "--name", "T!", "--suites", SUITE]) == 2
    assert not (tmp_path / "t.json").exists()
