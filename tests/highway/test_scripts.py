"""The example, the benchmark and the picture run."""

import importlib.util
import sys
from pathlib import Path

import pytest

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
    for owner, name in ((module.sensor.Sensor, "tick"), (module.sensor.Sensor, "decide")):
        monkeypatch.setattr(owner, name, getattr(owner, name))  # put back afterwards
    for name in ("_observe", "_info"):
        monkeypatch.setattr(module.wrapper.RssRanging, name, getattr(module.wrapper.RssRanging, name))
    module.main()
    assert capsys.readouterr().out.count("decisions/s") == 3


def test_a_driver_is_shipped_with_its_card(monkeypatch, tmp_path):
    module = run(ROOT / "docs" / "highway.py", monkeypatch)
    agent = tmp_path / "run" / "agent"
    agent.mkdir(parents=True)
    for name in ("policy.json", "policy.safetensors", "card.md"):
        (agent / name).write_text(name)
    (agent / "card.md").write_text("# Driver `highway`, seed 0 of 3\n")
    (tmp_path / "agents" / "mine").mkdir(parents=True)
    (tmp_path / "agents" / "mine" / "old").touch()
    folder = module.ship(tmp_path / "run", "mine", tmp_path / "agents")
    assert sorted(path.name for path in folder.iterdir()) == ["card.md", "policy.json", "policy.safetensors"]
    assert (folder / "card.md").read_text() == "# Driver `mine`, seed 0 of 3\n"


def test_picture_and_table(monkeypatch, tmp_path):
    pytest.importorskip("pygame")
    pytest.importorskip("matplotlib")
    module = run(ROOT / "docs" / "highway.py", monkeypatch)
    assert module.picture().size == (module.WIDTH_PX, module.HEIGHT_PX)
    record = module.road.save(module.road.evaluate(["rule"], episodes=2), tmp_path / "record")
    lines = module.table(record).splitlines()
    assert lines[2].startswith("| `rule` | 2 |") and lines[3].startswith("| `none` | 2 |")  # the cheapest first
