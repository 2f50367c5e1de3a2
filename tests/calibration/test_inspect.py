"""`rss-gym calibrate --inspect` and `rss-gym simulate-log`."""

import pytest

from rss_gym.cli import main


@pytest.fixture
def log(tmp_path, capsys):
    path = tmp_path / "flight.tlog"
    assert main(["simulate-log", "--format", "mavlink", "--seconds", "60", "--seed", "4", "--out", str(path)]) == 0
    assert capsys.readouterr().out == f"log: {path}\n"
    return path


def test_inspect_says_what_a_log_holds(capsys, log):
    assert main(["calibrate", "--inspect", str(log)]) == 0
    said = capsys.readouterr().out
    for words in (
        "flight.tlog: MAVLink telemetry log",
        "link 'ground', sender 51/68", "every 0.2 s", "dBm, median", "m/s, median",
        "500 a copy of another report", "not armed", "RSS, dBm (", "over distance, m (",
    ):  # fmt: skip
        assert words in said, words


def test_inspect_says_what_is_in_which_column(capsys, tmp_path):
    path = tmp_path / "log.csv"
    rows = "".join(f"{100 * k};{-60 - k % 9};{5 + k};x\n" for k in range(60))
    path.write_text("clock;Signal [dBm];dist_cm;remark\n" + rows)
    assert main(["calibrate", "--inspect", str(path), "--columns", "link=7"]) == 0
    said = [line.split() for line in capsys.readouterr().out.splitlines()]
    for words in ("t clock", "rss Signal [dBm]", "dist dist_cm", "link 7", "not used remark"):
        assert words.split() in said


def test_inspect_describes_a_log_that_would_be_refused(capsys, tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t,rss,dist\n" + "".join(f"{k},{'x' if k % 3 else -60 - k},{5 + k}\n" for k in range(60)))
    assert main(["calibrate", "--inspect", str(path)]) == 0
    said = capsys.readouterr().out
    assert "20 used of 60" in said and "note: refused: log 'log.csv': 40 of 60 rows" in said
    assert main(["calibrate", str(path), "--out", str(tmp_path / "c.toml")]) == 2


def test_the_page_of_an_inspection(capsys, log, tmp_path):
    assert main(["calibrate", "--inspect", str(log), "--report", str(tmp_path / "page")]) == 0
    page = (tmp_path / "page" / "index.html").read_text()
    assert "<svg" in page and "flight.tlog" in page and "a copy of another report" in page
    assert "http" not in page.replace("http://www.w3.org", "").replace("http-equiv", "")


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["--inspect", "{log}", "--out", "c.toml"], "--inspect writes no channel"),
        (["{log}"], "name the channel to write by --out"),
        (["{log}", "--out", "c.toml", "--station", "1,2"], "station must be LAT,LON,ALT"),
        (["{log}", "--out", "c.toml", "--columns", "t=t"], "columns are for tables"),
    ],
)
def test_options_that_do_not_go_together(capsys, log, arguments, words):
    assert main(["calibrate", *(text.format(log=log) for text in arguments)]) == 2
    assert words in capsys.readouterr().err


def test_a_station_south_of_the_equator(capsys, log, tmp_path):
    arguments = ["calibrate", "--inspect", str(log), "--station", "-35.36,149.16,584"]
    assert main(arguments) == 0
    assert "a distance out of its limits" in capsys.readouterr().out


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["--format", "tlog"], "format 'tlog' is unknown"),
        (["--seconds", "5"], "needs 30 s"),
        (["--channel", "papr"], "papr"),
        (["--seed", "-1"], "seed"),
    ],
)
def test_a_log_that_cannot_be_simulated(capsys, tmp_path, arguments, words):
    assert main(["simulate-log", *arguments, "--out", str(tmp_path / "a")]) == 2
    assert words in capsys.readouterr().err and list(tmp_path.iterdir()) == []


def test_an_older_file_is_not_replaced(capsys, log):
    before = log.read_bytes()
    assert main(["simulate-log", "--out", str(log)]) == 2
    assert "exists; name a new one" in capsys.readouterr().err and log.read_bytes() == before
