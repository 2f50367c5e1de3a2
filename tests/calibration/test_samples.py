"""The sample logs of examples/data: made by `rss-gym simulate-log`, and calibrated as the README says."""

import re
import shlex
from pathlib import Path

import pytest

from rss_gym.calibration.simulated import HOME, fly
from rss_gym.calibration.simulated.tables import TABLES
from rss_gym.cli import main
from rss_gym.params import load_channel

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "examples" / "data"
SECONDS, RATE_HZ, SEED = 200.0, 2.0, 1
STATION = ["--station", ",".join(map(str, HOME))]
OPTIONS = {
    "csv": [],
    "positions": STATION,
    "milliseconds": [],
    "wide": ["--melt"],
    "prose": [],
    "bare": ["--columns", "1=t,2=rss,3=dist"],
    "relative": ["--offset-db", "-120"],
    "edgetx": STATION,
}


def path_of(name):
    return DATA / f"{'flight' if name == 'csv' else name}.csv"


def test_every_kind_of_table_has_a_sample():
    assert set(OPTIONS) == set(TABLES)
    assert {path.name for path in DATA.iterdir()} == {path_of(name).name for name in TABLES}


@pytest.mark.parametrize("name", OPTIONS)
def test_a_sample_is_what_the_command_writes(name):
    assert path_of(name).read_bytes() == TABLES[name](fly("outdoor", SECONDS, RATE_HZ, SEED))


@pytest.mark.parametrize("name", OPTIONS)
def test_a_sample_is_calibrated(name, tmp_path, capsys):
    out = tmp_path / "channel.toml"
    assert main(["calibrate", str(path_of(name)), *OPTIONS[name], "--out", str(out)]) == 0
    channel, truth = load_channel(out), load_channel("outdoor")
    assert channel.path_loss_factor == pytest.approx(truth.path_loss_factor, abs=0.5)
    total = channel.white_variance_db2 + channel.coloured_variance_db2
    assert total == pytest.approx(truth.white_variance_db2 + truth.coloured_variance_db2, rel=0.4)
    assert "coloured EKF" in capsys.readouterr().out


def test_a_log_after_melt_is_no_pattern(tmp_path, capsys):
    assert main(["calibrate", "--melt", str(path_of("wide")), "--out", str(tmp_path / "channel.toml")]) == 0
    assert "2 links in the first two thirds of wide.csv" in capsys.readouterr().out


@pytest.mark.parametrize("page", ["README.md", "docs/calibration.md"])
def test_the_lines_of_the_documents_run_as_typed(page, tmp_path, monkeypatch, capsys):
    text = (ROOT / page).read_text(encoding="utf-8")
    lines = re.findall(r"^rss-gym ((?:calibrate|simulate-log)\b.*)$", text, flags=re.MULTILINE)
    assert lines
    (tmp_path / "examples").symlink_to(ROOT / "examples", target_is_directory=True)
    monkeypatch.chdir(tmp_path)
    for line in lines:
        assert main(shlex.split(line, comments=True)) == 0, line
    assert capsys.readouterr().out
