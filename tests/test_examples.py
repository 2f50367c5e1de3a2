"""Every example runs, small, and prints what it promises."""

import re
import runpy
import sys
from pathlib import Path

import pytest

from rss_gym.eval import evaluate

FOLDER = Path(__file__).resolve().parent.parent / "examples"
SMALL = ["policy.net_arch=[8]", "vec.n_envs=64", "algorithm.batch_size=256", "validation.episodes=40"]
# File -> arguments, packages that it needs, words of its last lines
EXAMPLES = {
    "step.py": (["--rows", "32", "--steps", "250"], [], ["32 rows of 250 decisions", "with a collision"]),
    "train_in_minutes.py": (
        ["--steps", "4096", "--episodes", "30", "--out", "run", "--set", *SMALL],
        ["stable_baselines3"],
        ["agent ", "orthogonal ", "orca ", "30 encounters"],
    ),
    "sb3_ppo.py": (["8192", "20"], ["stable_baselines3"], ["ppo ", "rule ", "orca ", "20 encounters"]),
    "score_own_policy.py": (["--episodes", "50"], [], ["pass-behind ", "orthogonal ", "50 encounters"]),
    "cluster.py": (
        ["--episodes", "60", "--part", "20"],
        ["distributed"],
        ["orthogonal ", "60 encounters", "parts and blocks agree: True"],
    ),
    "ppo_single_file.py": (
        ["--steps", "32768", "--episodes", "30"],
        ["torch"],
        ["32,768 decisions", "ppo ", "30 encounters"],
    ),
}
SLOW = ("cluster.py", "sb3_ppo.py", "ppo_single_file.py", "train_in_minutes.py")


# Script -> number of its figures
GALLERY = {
    "estimators.py": 2,
    "front.py": 1,
    "range_of_an_encounter.py": 1,
    "signal_strength.py": 2,
    "two_policies.py": 2,
    "zones.py": 1,
}


def test_every_example_is_run_here():
    assert {path.name for path in (FOLDER / "gallery").glob("*.py")} == set(GALLERY)
    assert {path.name for path in FOLDER.glob("*.py")} - {"highway.py"} == set(EXAMPLES)


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in EXAMPLES])
def test_it_runs(name, tmp_path, monkeypatch, capsys):
    arguments, packages, words = EXAMPLES[name]
    for package in packages:
        pytest.importorskip(package, reason=f"{package} (extra `train` or `cluster`) is not installed")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [name, *arguments])
    runpy.run_path(str(FOLDER / name), run_name="__main__")
    out = capsys.readouterr().out
    for word in words:
        assert word in out


@pytest.mark.parametrize("name", GALLERY)
def test_the_gallery_draws(name, tmp_path, monkeypatch):
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    monkeypatch.setattr(
        "rss_gym.eval.evaluate", lambda policy, **options: evaluate(policy, **options | {"episodes": 20})
    )
    drawn = []
    monkeypatch.setattr(pyplot, "show", lambda: drawn.append(pyplot.gcf().axes) or pyplot.close())
    monkeypatch.chdir(tmp_path)
    with matplotlib.rc_context():
        runpy.run_path(str(FOLDER / "gallery" / name), run_name="__main__")
    assert len(drawn) == GALLERY[name]
    assert all(axes.get_xlabel() or axes.get_ylabel() for figure in drawn for axes in figure)
    assert list(tmp_path.iterdir()) == []


def test_the_gallery_is_listed_in_its_order():
    order = re.search(r"for name in \(([^)]+)\)", (FOLDER.parent / "docs" / "conf.py").read_text(encoding="utf-8"))[1]
    assert {f"{name}.py" for name in re.findall(r'"(\w+)"', order)} == set(GALLERY)


def test_the_single_file_learns():
    """A policy that is paid for its actions moves to them."""
    torch = pytest.importorskip("torch", reason="torch (extra `train`) is not installed")
    parts = runpy.run_path(str(FOLDER / "ppo_single_file.py"))
    torch.manual_seed(0)
    torch.set_num_threads(1)
    rows, length = parts["ROWS"], parts["LENGTH"]
    actor = parts["Actor"](3, 2)
    optimiser = torch.optim.Adam(actor.parameters(), lr=3e-3)
    observations, wanted = torch.randn(length, rows, 3), torch.tensor([0.5, -0.3])
    for _ in range(3):
        with torch.no_grad():
            actions = actor.distribution(observations).sample()
        rewards = -(actions - wanted).square().sum(-1)
        dones = torch.ones(length, rows)  # each decision is an episode
        parts["learn"](actor, optimiser, (observations, actions, rewards, dones), observations[-1])
    error = (actor.mean(observations[0]).detach() - wanted).abs().mean(0)
    assert (error < 0.7 * wanted.abs()).all()  # it began near zero


def test_the_single_file_discounts_to_the_end_of_an_episode_only():
    torch = pytest.importorskip("torch", reason="torch (extra `train`) is not installed")
    parts = runpy.run_path(str(FOLDER / "ppo_single_file.py"))
    length, rows = 5, 2
    rewards = torch.ones(length, rows)
    dones = torch.zeros(length, rows)
    dones[1, 0] = 1.0
    values, last = torch.full((length, rows), 2.0), torch.full((rows,), 3.0)
    found = parts["advantages"](rewards, dones, values, last)
    discount, factor = parts["DISCOUNT"], parts["DISCOUNT"] * parts["LAMBDA"]
    for row in range(rows):
        for t in range(length):
            total, weight = 0.0, 1.0
            for k in range(t, length):
                ended = bool(dones[k, row])
                following = 0.0 if ended else float(last[row] if k == length - 1 else values[k + 1, row])
                total += weight * (1.0 + discount * following - 2.0)
                if ended:
                    break
                weight *= factor
            assert float(found[t, row]) == pytest.approx(total, rel=1e-4, abs=1e-5)
