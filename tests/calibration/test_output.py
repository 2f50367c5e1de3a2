"""The command, the channel file and the page."""

import dataclasses
import json
import re

import gymnasium as gym
import pytest

from rss_gym.cli import main
from rss_gym.eval.studies.calibration import output, report
from rss_gym.params import load_channel


@pytest.fixture
def logs(tmp_path, flown, write):
    """Two logs of two links and one of one."""
    two = [(flown(240, 2 * k, "a"), flown(240, 2 * k + 1, "b")) for k in range(2)]
    folder = tmp_path / "logs"
    folder.mkdir()
    return [
        *(write(folder / f"{k}.csv", *records) for k, records in enumerate(two)),
        write(folder / "2.csv", flown(240, 9, "a")),
    ]


def run(capsys, *arguments):
    """Exit status, standard output and error."""
    try:
        status = main(["calibrate", *map(str, arguments)])
    except SystemExit as stop:
        status = stop.code
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def test_the_channel_flies(capsys, tmp_path, logs):
    out, folder = tmp_path / "channel.toml", tmp_path / "report"
    status, printed, _ = run(capsys, *logs[:2], "--test", logs[2], "--out", out, "--report", folder)
    assert status == 0 and "coloured EKF" in printed and f"channel: {out}" in printed
    channel = load_channel(out)
    found = json.loads((folder / output.JSON).read_text())
    assert channel.to_dict() == found["channel"]
    env = gym.make("rss_gym/Encounter-v0", channel=str(out))
    observation, _ = env.reset(seed=0)
    for _ in range(3):
        observation, *_ = env.step(env.action_space.sample() * 0.0)
    assert env.observation_space.contains(observation)
    scores = tmp_path / "scores"
    arguments = ["eval", "--policy", "none", "--episodes", "5", "--channel", str(out), "--out", str(scores)]
    assert main(arguments) == 0
    assert load_channel(json.loads((scores / "scores.json").read_text())["params"]["channels"][0]) == channel
    comments = [line for line in out.read_text().splitlines() if line.startswith("#")]
    assert "960 samples of 2 links in 0.csv, 1.csv" in comments[0]
    assert str(tmp_path) not in out.read_text()


def test_json_is_what_the_folder_holds(capsys, tmp_path, logs):
    folder = tmp_path / "report"
    status, printed, _ = run(capsys, *logs, "--out", tmp_path / "c.toml", "--report", folder, "--json")
    assert status == 0
    found = json.loads(printed)
    assert found == json.loads((folder / output.JSON).read_text())
    assert found["tested"]["held_out"] == "last third of each record"
    assert (found["fitted"]["samples"], found["tested"]["samples"]) == (800, 400)
    assert set(found["links"]) == {"a", "b"} and "ekf-coloured" in found["methods"]


def test_an_older_channel_is_replaced(capsys, tmp_path, logs):
    out = tmp_path / "channel.toml"
    run(capsys, logs[0], "--out", out)
    first = load_channel(out)
    status, _, _ = run(capsys, logs[1], "--out", out)
    assert status == 0 and load_channel(out) != first
    assert sorted(path.name for path in tmp_path.iterdir()) == ["channel.toml", "logs"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["{log}", "--out", "{folder}/channel.csv"], ["channel.csv", "ends in .toml"]),
        (["{log}", "--out", "{folder}/no/channel.toml"], ["not a folder"]),
        (["{log}", "--out", "{folder}/other.toml"], ["other.toml", "not a channel"]),
        (["{log}", "--out", "{folder}/c.toml", "--report", "{folder}/logs"], ["exists and is not empty"]),
        (["{log}", "--test", "{log}", "--out", "{folder}/c.toml"], ["0.csv", "a log of its own"]),
        (["{log}", "{folder}/logs/../logs/0.csv", "--out", "{folder}/c.toml"], ["0.csv", "named twice"]),
        (["{log}", "--out", "{folder}/c.toml", "--report", "{folder}/c.toml"], ["c.toml", "the report's folder"]),
        (["{folder}/none.csv", "--out", "{folder}/c.toml"], ["none.csv", "missing"]),
        (["{log}", "--format", "cvs", "--out", "{folder}/c.toml"], ["'cvs'", "did you mean 'csv'"]),
        (["{log}", "--columns", "t", "--out", "{folder}/c.toml"], ["'t'", "KEY=NAME"]),
        (["{log}", "--columns", "t=t,t=rss", "--out", "{folder}/c.toml"], ["'t=rss'", "different keys"]),
        (["{log}", "--columns", "rss=power", "--out", "{folder}/c.toml"], ["'power'", "known: "]),
        (["{log}", "--columns", "dist=link", "--out", "{folder}/c.toml"], ["distance"]),
        (["{log}"], ["--out"]),
        (["--out", "{folder}/c.toml"], ["FIT"]),
    ],
)
def test_bad_input_leaves_nothing_behind(capsys, tmp_path, logs, arguments, words):
    (tmp_path / "other.toml").write_text("[project]\nname = 'x'\n")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    status, _, error = run(capsys, *(text.format(log=logs[0], folder=tmp_path) for text in arguments))
    assert status == 2
    sentence = error.strip().splitlines()[-1]
    assert all(word in sentence for word in words), sentence
    assert error.count("\n") == 1 or sentence.startswith("rss-gym calibrate: error")
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


@pytest.fixture(scope="module")
def page(result):
    return report.markup(result)


def test_a_report_that_cannot_be_written_leaves_no_channel(result, tmp_path, monkeypatch):
    monkeypatch.setattr(report, "markup", lambda _: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        output.save(result, tmp_path / "c.toml", tmp_path / "report")
    assert list(tmp_path.iterdir()) == []


def test_the_page_needs_no_network(result, page):
    rest = re.sub(r'xmlns(:xlink)?="http://www\.w3\.org/[^"]*"', "", page).replace("http-equiv", "")
    for pattern in ("http", r"\bsrc\s*=", "<link", "@import", r"url\((?!#)", "<iframe", "<image"):
        assert not re.search(pattern, rest), pattern
    assert page == report.markup(result)


def test_every_figure_shows_something(result, page):
    figures = re.findall(r'<figure class="plot">(.*?)</figure>', page, flags=re.DOTALL)
    assert len(figures) == 5
    for svg in figures:
        curves = re.findall(r'<g id="[^"]*line2d_\d+">\s*<path d="([^"]*)"', svg)
        assert max(path.count("L") for path in curves) >= 15
        assert not re.search(r"\bnan\b", svg, flags=re.IGNORECASE)
        labels = re.findall(r"<text[^>]*>([^<]+)</text>", svg)
        assert any(re.search(r", (m|s|dB|dBm|dB²)$", label) for label in labels)
    assert len(page) < 3_000_000
    for link in result.fit.links:
        assert f'<th scope="row">{link}</th>' in page
    assert "a note" in page


def test_dropped_rows_are_in_one_table(result):
    record = dataclasses.replace(result.tested[0], reasons={"on the ground": 1234, "no RSS": 7}, dropped=1241)
    changed = dataclasses.replace(result, tested=(record, *result.tested[1:]))
    page, found = report.markup(changed), output.to_dict(changed)["dropped"]
    assert '<th scope="col">on the ground</th>' in page and '<td data-value="1234">1,234</td>' in page
    assert {
        "log": record.source,
        "link": record.link,
        "used": 500,
        "dropped": {"on the ground": 1234, "no RSS": 7},
    } in found
    assert sum(one["used"] for one in found) == sum(len(r.time_s) for r in (*result.fit.records, *result.tested))


@pytest.mark.slow
def test_names_from_outside_are_text(result, tmp_path):
    bad = "<script>alert(1)</script>$\\x$\n[channel]"
    link = result.fit.links["a"]
    records = tuple(dataclasses.replace(record, link=bad, source=bad) for record in link.records)
    links = {bad: dataclasses.replace(link, records=records)}
    tested = tuple(dataclasses.replace(record, link=bad, source=bad) for record in result.tested)
    named = dataclasses.replace(result, fit=dataclasses.replace(result.fit, links=links), tested=tested, notes=(bad,))
    page = report.markup(named)
    assert "<script>alert" not in page and "&lt;script&gt;alert(1)" in page
    out = tmp_path / "c.toml"
    output.save(named, out)
    assert load_channel(out) == result.fit.channel
    assert "<script>alert(1)</script>$\\x$?[channel]" in " ".join(output.table(named).splitlines())


def test_the_comment_of_many_logs_stays_short(result):
    records = [dataclasses.replace(result.tested[0], source=f"{k}.csv") for k in range(500)]
    text = output.comment(dataclasses.replace(result, tested=tuple(records)))
    assert "and 488 more" in text and max(map(len, text.splitlines())) <= 118
