"""A small season of one suite, entries for it, and flights in this process."""

import shutil
from pathlib import Path

import pytest

from rss_gym import baselines
from rss_gym.eval.board import fly, season, submit
from rss_gym.eval.board.limits import fly_here

SUITE, PUBLIC, SEALED = "smoke-v0", 24, 20
LINK = "https://example.org/code"


def entry_in(folder, policy="orthogonal:radius_m=60", name="wide-turner", author="Ada", **more):
    """Write an entry; `more` changes lines of its file."""
    submit.init(folder, str(policy), name=name, author=author, link=LINK, suite=more.pop("suite", SUITE))
    edit(folder, **more)
    return Path(folder)


def edit(folder, **lines):
    file = Path(folder) / "entry.toml"
    rows = [row for row in file.read_text().splitlines() if row.split(" = ")[0] not in lines]
    file.write_text("\n".join([*rows, *(f"{key} = {value}" for key, value in lines.items())]) + "\n")


@pytest.fixture
def make_entry(tmp_path):
    """Function (folder name, policy, name, author, **lines) -> folder in tmp_path/entries."""
    (tmp_path / "entries").mkdir()
    return lambda folder, *args, **more: entry_in(tmp_path / "entries" / folder, *args, **more)


@pytest.fixture
def change():
    """Function (folder, **lines of entry.toml)."""
    return edit


@pytest.fixture(scope="session")
def flown(tmp_path_factory):
    """A season with three entries flown: folder with `entries`, `season.json` and `board`."""
    root = tmp_path_factory.mktemp("flown")
    (root / "entries").mkdir()
    entry_in(root / "entries" / "a")
    entry_in(root / "entries" / "b", baselines.AGENTS["ppo-plane"], name="ppo copy", author="Bob <b>&")
    entry_in(root / "entries" / "c", "constant:right_m=900", name="Fleeing", author="Cy")
    season.new(root / "season.json", "first", [SUITE], PUBLIC, SEALED)
    done = fly.fly(root / "entries", root / "season.json", root / "board", runner=fly_here, references=False)
    assert len(done.appended) == 3 and not done.refused
    return root


@pytest.fixture
def board(flown, tmp_path):
    """A copy to change."""
    return shutil.copytree(flown, tmp_path / "copy")
