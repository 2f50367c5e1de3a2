"""The demo: rules and agents on two channels in one page, with radio logs at hand and without."""

import json
import re

import numpy as np
import pytest

from rss_gym import demo
from rss_gym.baselines import AGENTS
from rss_gym.cli import main
from rss_gym.eval import verify
from rss_gym.params import load_channel
from rss_gym.radio import simulate

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def no_logs(monkeypatch, tmp_path):
    """No recorded logs, wherever the tests run."""
    monkeypatch.setenv("RSS_GYM_DATA", str(tmp_path / "data"))
    monkeypatch.chdir(tmp_path)


def specs(folder):
    return [policy["spec"] for policy in json.loads((folder / "scores.json").read_text())["policies"]]


def channel(folder):
    return json.loads((folder / "scores.json").read_text())["params"]["channels"]


def test_the_rule_over_its_radius_on_two_channels(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("rss_gym.demo.able", lambda params: ["none"])  # whatever is shipped
    assert main(["demo", "--episodes", "20", "--workers", "1"]) == 0
    out, folder = capsys.readouterr().out, tmp_path / "runs" / "demo"
    assert "report: runs/demo/report.html" in out and "No learned agent" in out
    assert re.search(r"No radio logs are at hand.*quadcopter", out, re.DOTALL)
    assert specs(folder) == ["none", *demo.RULE, *demo.OTHERS] and specs(folder / "radio") == ["none", *demo.RULE]
    assert channel(folder / "radio") == [load_channel("quadcopter").to_dict()] != channel(folder)
    page = (folder / "report.html").read_text()
    assert demo.SECTION in page and 'href="radio/report.html"' in page and "preset quadcopter" in page
    assert page.count('aria-label="Collisions per encounter against mean deviation"') == 6  # two charts, three sizes
    anchors = re.findall(r'\bid="([^"]*)"', page)
    assert len(anchors) == len(set(anchors))
    assert str(tmp_path) not in page


def test_a_channel_from_the_logs_at_hand(tmp_path, capsys):
    logs = tmp_path / "data" / "wifi_walk"
    logs.mkdir(parents=True)
    for number in range(2):
        log = simulate(np.linspace(60.0, 10.0, 3000), 0.1, load_channel("clean"), seed=number)
        rows = np.stack([log.time_s, log.rss_dbm, log.distance_m], axis=1)
        np.savetxt(logs / f"walk_{number}.csv", rows, delimiter=",", header="t,rss,dist", comments="")
    assert main(["demo", "--episodes", "10", "--workers", "1", "--out", "here"]) == 0
    out, folder = " ".join(capsys.readouterr().out.split()), tmp_path / "here"
    assert "Calibrated from 3,000 samples of 1 link in walk_0.csv of wifi_walk, at up to 60 m" in out
    fitted = load_channel(folder / "radio" / "channel.toml")
    assert channel(folder / "radio") == [fitted.to_dict()] and "walk_0.csv" in (folder / "report.html").read_text()
    assert fitted.path_loss_factor == pytest.approx(load_channel("clean").path_loss_factor, rel=0.05)
    verdict = verify.verify(folder / "radio")
    assert verdict.verified and not verdict.not_flown


def test_shipped_agents_fly_on_both_channels_and_are_replayed_beside_the_rule(
    tmp_path, capsys, monkeypatch, tiny_agent
):
    monkeypatch.setitem(AGENTS, "ppo-tiny", tiny_agent)
    assert main(["demo", "--episodes", "10", "--workers", "1"]) == 0
    assert "No learned agent" not in capsys.readouterr().out
    for folder in (tmp_path / "runs" / "demo", tmp_path / "runs" / "demo" / "radio"):
        assert specs(folder)[:1] == ["none"] and "ppo-tiny" in specs(folder) and demo.REFERENCE in specs(folder)
        page = (folder / "report.html").read_text()
        data = json.loads(re.search(r'id="data-replays">(.*?)</script>', page, re.DOTALL)[1])
        own = next(item for item in data["policies"] if item["name"] == "ppo-tiny")
        names = [data["flights"][case[side]]["name"] for case in own["cases"] for side in ("flight", "beside")]
        assert data["beside"] == demo.REFERENCE and set(names) == {"ppo-tiny", demo.REFERENCE}
        assert [case["least_m"] for case in own["cases"]] == sorted(case["least_m"] for case in own["cases"])


def test_spoilt_logs_are_refused_before_anything_is_flown(tmp_path, capsys, monkeypatch):
    logs = tmp_path / "data" / "wifi_walk"
    logs.mkdir(parents=True)
    for number in range(2):
        (logs / f"{number}.csv").write_text("nothing,here\n")
    monkeypatch.setattr("rss_gym.demo.evaluate", lambda *_, **__: pytest.fail("flown"))
    assert main(["demo"]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1 and not (tmp_path / "runs").exists()
