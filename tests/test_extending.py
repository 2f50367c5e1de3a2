"""The examples of docs/extending.md as a plug-in of another distribution, in processes of their own."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
BLOCKS = dict(re.findall(r"^## (?:A|An) ([\w ]+)\n```python\n(.*?)```", PAGE, re.DOTALL | re.MULTILINE))
COMMAND = ["-c", "import sys; from rss_gym.cli import main; sys.exit(main())"]
KINDS = ["channel", "family of encounters", "suite", "rule", "metric", "estimator", "tracker"]


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory):
    """A folder of a distribution `my-parts`: one module an example, and the entry point that imports them all."""
    folder = tmp_path_factory.mktemp("site")
    package = folder / "my_parts"
    package.mkdir()
    names = []
    for number, code in enumerate(BLOCKS.values()):
        names.append(f"part_{number}")
        (package / f"{names[-1]}.py").write_text(code, encoding="utf-8")
    imports = "".join(f"    import my_parts.{name}\n" for name in names)
    (package / "__init__.py").write_text(f"def register():\n{imports}", encoding="utf-8")
    written(folder, "my-parts", "my_parts:register")
    return folder


def written(folder, name, value):
    """The metadata that an installer would leave of a distribution with one plug-in."""
    info = folder / f"{name.replace('-', '_')}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[rss_gym.plugins]\n{name} = {value}\n")


def run(folder, *arguments, status=0):
    """A Python process in the folder; its output."""
    path = os.pathsep.join([str(folder), str(ROOT), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == status, done.stderr[-3000:]
    return done.stdout if status == 0 else done.stderr


def test_every_door_has_an_example_of_twenty_lines():
    assert list(BLOCKS) == KINDS
    for code in BLOCKS.values():
        assert len([line for line in code.splitlines() if line.strip()]) <= 20


@pytest.mark.slow
def test_the_command_line_lists_and_flies_them(elsewhere, tmp_path):
    listed = json.loads(run(elsewhere, *COMMAND, "list", "--json"))
    assert "fitted to three flights" in listed["channels"]["my-radio"]
    assert "[weight 0]" in listed["families"]["fading-overtaker"]
    assert listed["policies"]["sidestep"].endswith("[share=0.4]")
    assert "[2000 encounters]" in listed["suites"]["my-suite-v0"]
    assert listed["estimators"]["weighed"] == "inverted samples, weighed"
    assert listed["trackers"]["at-range"].endswith("[information positions]")
    out = tmp_path / "record"
    command = [*COMMAND, "eval", "--policy", "sidestep:share=0.8", "--suite", "my-suite-v0"]
    command += ["--estimator", "weighed", "--tracker", "at-range"]
    run(elsewhere, *command, "--episodes", 40, "--workers", 2, "--out", out)
    scores = json.loads((out / "scores.json").read_text())
    assert scores["families"] == ["overtaking", "fading-overtaker"]
    assert scores["params"]["channels"][0]["coloured_variance_db2"] == 9.0
    assert (scores["params"]["ranging"]["estimator"], scores["params"]["tracking"]["tracker"]) == (
        "weighed",
        "at-range",
    )
    metrics = {policy["spec"]: policy["metrics"] for policy in scores["policies"]}
    assert 0.0 < metrics["sidestep:share=0.8"]["warned_share"]["value"] < 1.0
    assert "verified" in run(elsewhere, *COMMAND, "verify", out)
    assert "share of the flight before the first warning" in (out / "report.html").read_text()


@pytest.mark.slow
def test_each_passes_the_contract_tests_of_its_kind_by_one_call(elsewhere):
    code = """
from rss_gym import testing
testing.check_channel("my-radio")
testing.check_family("fading-overtaker")
testing.check_suite("my-suite-v0")
testing.check_rule("sidestep")
testing.check_metric("warned_share")
testing.check_estimator("weighed")
testing.check_tracker("at-range")
print("kept")
"""
    assert run(elsewhere, "-c", code) == "kept\n"


def test_gymnasium_makes_worlds_of_them(elsewhere):
    code = """
import gymnasium as gym
import rss_gym
parts = {"estimator": "weighed", "tracker": "at-range"}
env = gym.make("rss_gym/Encounter-v0", channel="my-radio", families="fading-overtaker", **parts)
print(env.reset(seed=0)[0].shape == env.observation_space.shape)
envs = gym.make_vec("rss_gym/Encounter-v0", num_envs=3, channel=["my-radio", "paper"], **parts)
print(len(envs.reset(seed=0)[0]))
"""
    assert run(elsewhere, "-c", code).split() == ["True", "3"]


SCRIPT = """
import rss_gym
from rss_gym.encounters.family import Family
from rss_gym.eval import evaluate

def main():
    rss_gym.register_family("mine", Family(summary="mine", weight=0.0, conflict_share=1.0))
    keywords = {"episodes": 600, "block": 200, "families": "mine", "progress": False}
    serial, spread = (evaluate("orca", workers=workers, **keywords) for workers in (1, 2))
    print(serial["orca"] == spread["orca"], serial["orca"]["collision_rate"].n)

if __name__ == "__main__":
    main()
"""


@pytest.mark.slow
def test_what_a_script_registers_is_sent_to_its_workers(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    assert run(tmp_path, "script.py").split() == ["True", "600"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("broken:register", ["'broken' = 'broken:register' of broken", "ZeroDivisionError: by zero", "uninstall"]),
        ("missing_module", ["of broken failed (ModuleNotFoundError: No module named 'missing_module')"]),
        ("broken:twice", ["of broken failed (ParamsError: channel 'paper' is registered already"]),
    ],
)
def test_a_broken_plug_in_is_one_sentence(tmp_path, value, words):
    (tmp_path / "broken.py").write_text(
        "def register():\n    raise ZeroDivisionError('by zero\\nmore')\n\n"
        "def twice():\n    import rss_gym\n    rss_gym.register_channel('paper', {}, 'x')\n"
    )
    written(tmp_path, "broken", value)
    said = run(tmp_path, *COMMAND, "list", status=2)
    assert said.count("\n") == 1 and said.startswith("rss-gym: plug-in ")
    assert all(word in said for word in words), said
