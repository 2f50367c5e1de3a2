"""The example, the benchmark, the picture and the table run."""

import importlib.util
import io
import sys
from pathlib import Path

import pytest

from rss_gym.eval import evaluate
from rss_gym.eval.records import save
from rss_gym.eval.studies import roads

ROOT = Path(__file__).resolve().parents[2]


def run(path, monkeypatch, *arguments):
    """A script's `main`, and the module."""
    monkeypatch.setattr(sys, "argv", [str(path), *arguments])
    monkeypatch.syspath_prepend(str(path.parent))
    spec = importlib.util.spec_from_file_location(f"script_{path.stem}", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_example(monkeypatch, capsys):
    run(ROOT / "examples" / "highway.py", monkeypatch).main()
    assert "nearest vehicle" in capsys.readouterr().out


def test_benchmark(monkeypatch, capsys):
    module = run(ROOT / "benchmarks" / "highway.py", monkeypatch, "--seconds", "0.05")
    for owner, name in ((module.sensor.Sensor, "tick"), (module.sensor.Sensor, "advance_slow_noise")):
        monkeypatch.setattr(owner, name, getattr(owner, name))  # put back afterwards
    for name in ("_observe", "_info"):
        monkeypatch.setattr(module.wrapper.RssRanging, name, getattr(module.wrapper.RssRanging, name))
    module.main()
    assert capsys.readouterr().out.count("decisions/s") == 3


def test_picture_and_table(tmp_path, monkeypatch):
    pytest.importorskip("pygame")
    image = pytest.importorskip("PIL.Image")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")  # taken away by the picture, put back afterwards
    from rss_gym.eval.studies.roads import picture

    assert image.open(io.BytesIO(picture.picture())).size == (picture.WIDTH_PX, picture.HEIGHT_PX)
    record = save(evaluate(["rule"], "highway-v0", episodes=2, progress=False), tmp_path / "record")
    lines = roads.drivers(record).splitlines()
    assert lines[2].startswith("| `rule` | 2 |") and lines[3].startswith("| `none` | 2 |")  # the cheapest first
