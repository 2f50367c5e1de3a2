"""Runs: what they write, how they go on after an end by force, and who wins."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("sb3_contrib", reason="sb3-contrib (extra `train`) is not installed")

from rss_gym.baselines.agent import load as load_agent
from rss_gym.cli import main
from rss_gym.eval.costs import Costs, cost_m
from rss_gym.eval.ranking import Candidate
from rss_gym.params import ParamsError
from rss_gym.train import recipe, run
from rss_gym.train.learner import Learner
from rss_gym.train.lock import locked
from rss_gym.train.validation import BestTracker, ValidationScore, Validator

STEPS = "time/total_timesteps"
PATIENCE_S = 900.0  # until something counts as hanging: kernels may have to be compiled first, on a loaded machine


def rows(path, column):
    with open(path, newline="") as file:
        return [int(row[column]) for row in csv.DictReader(file)]


def whole(folder):
    """Every file of a run can be read, and none is left over."""
    for path in folder.rglob("*"):
        assert not path.name.startswith("."), path
        if path.suffix == ".json":
            json.loads(path.read_text())
    for policy in folder.rglob("policy.json"):
        load_agent(policy.parent)


@pytest.fixture(scope="module")
def finished(small, tmp_path_factory):
    """Two seeds, one after the other."""
    folder = tmp_path_factory.mktemp("runs") / "run"
    agent = run.start(recipe.load("ppo", small), folder, seeds=2, command=["train", "ppo"], show=False)
    assert agent == folder / "agent"
    return folder


def test_a_run_holds_what_it_was_made_with(finished, small):
    document = json.loads((finished / "run.json").read_text())
    assert document["recipe"] == recipe.load("ppo", small).to_dict()
    assert document["world"] == recipe.load("ppo", small).params.to_dict()
    assert document["seeds"] == [0, 2**20] and document["command"] == ["train", "ppo"]
    assert {"rss-gym", "torch", "stable-baselines3", "numpy"} <= set(document["versions"])
    assert document["revision"] is None or len(document["revision"]) >= 40
    whole(finished)


@pytest.mark.parametrize("seed", ["seed-0", "seed-1"])
def test_a_seed_holds_its_curves_checkpoint_and_best(finished, seed):
    folder = finished / seed
    assert rows(folder / "progress.csv", STEPS) == [1024, 2048, 3072, 4096]
    assert rows(folder / "validation.csv", "steps") == [2048, 4096]
    state = json.loads((folder / "checkpoint" / "state.json").read_text())
    assert state["steps"] == 4096 and len(state["episodes"]) == 64 and min(state["episodes"]) >= 1
    assert set(state["statistics"]) == {"ret_rms"}
    agent = load_agent(folder / "best")
    training = agent.document["training"]
    assert training["seed"] == (0 if seed == "seed-0" else 2**20) and training["difference"] <= 1e-5
    with open(folder / "validation.csv", newline="") as file:
        kept = [row for row in csv.DictReader(file) if row["best"] == "1"][-1]
    assert int(kept["steps"]) == training["validation"]["steps"]
    assert float(kept["collision_rate"]) == training["validation"]["collision_rate"]


@pytest.mark.slow
def test_seeds_in_processes_of_their_own_are_the_same(finished, small, tmp_path):
    run.start(recipe.load("ppo", small), tmp_path / "run", seeds=2, workers=2, show=False)
    for seed in ("seed-0", "seed-1"):
        weights = [
            (folder / seed / "best" / "policy.safetensors").read_bytes() for folder in (finished, tmp_path / "run")
        ]
        assert weights[0] == weights[1]


def test_seeds_differ(finished):
    weights = [(finished / seed / "best" / "policy.safetensors").read_bytes() for seed in ("seed-0", "seed-1")]
    assert weights[0] != weights[1]


def test_the_agent_is_the_best_seeds(finished, capsys):
    best, table = run.best_seed(finished)
    for file in ("policy.json", "policy.safetensors"):
        assert (finished / "agent" / file).read_bytes() == (best / file).read_bytes()
    chosen, _ = run.read(finished)
    validator = Validator(chosen.params, chosen.validation.episodes)
    scores = {name: validator.score(load_agent(finished / name / "best"), name) for name in ("seed-0", "seed-1")}
    other = next(name for name in scores if name != best.parent.name)
    assert not BestTracker(scores[best.parent.name]).takes(scores[other])
    assert table.splitlines()[1].startswith(f"  1. {best.parent.name}, ")


def test_a_finished_run_goes_on_without_a_step(finished, capsys):
    before = (finished / "seed-0" / "progress.csv").read_bytes()
    assert main(["train", "--resume", str(finished)]) == 0
    assert "nothing was left to train" in capsys.readouterr().out
    assert (finished / "seed-0" / "progress.csv").read_bytes() == before


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGKILL on Windows")
def test_killed_and_resumed(small, tmp_path):
    folder = tmp_path / "run"
    long = {**small, "recipe.steps": 1_000_000, "validation.every_steps": 4096}
    changes = [f"{key}={json.dumps(value)}" for key, value in long.items()]
    command = [sys.executable, "-c", "from rss_gym.cli import main; raise SystemExit(main())", "train", "ppo"]
    command += ["--seeds", "2", "--workers", "2", "--out", str(folder), "--set", *changes]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    seeds = [folder / f"seed-{index}" for index in range(2)]
    try:
        deadline = time.monotonic() + PATIENCE_S
        while not all((seed / "best" / "policy.json").exists() for seed in seeds):
            assert time.monotonic() < deadline and process.poll() is None
            time.sleep(0.05)
        with pytest.raises(ParamsError, match="another process"):
            run.resume(folder)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    wait_for_lock(seeds)
    reached = [json.loads((seed / "checkpoint" / "state.json").read_text())["steps"] for seed in seeds]
    # As it would be with the end between two renames, and in the middle of a file.
    (seeds[0] / "best").rename(seeds[0] / ".best.old")
    (seeds[0] / ".progress.csv-abc").write_text("time/to")
    for seed, steps in zip(seeds, reached, strict=True):
        assert 0 <= rows(seed / "progress.csv", STEPS)[-1] - steps <= 1024  # one checkpoint interval
    document = json.loads((folder / "run.json").read_text())
    document["recipe"]["recipe"]["steps"] = max(reached) + 2048
    (folder / "run.json").write_text(json.dumps(document))
    run.resume(folder, show=False)
    whole(folder)
    for seed, steps in zip(seeds, reached, strict=True):
        progress, validations = rows(seed / "progress.csv", STEPS), rows(seed / "validation.csv", "steps")
        assert progress == sorted(set(progress)) and steps in progress
        assert np.diff([step for step in progress if step >= steps]).max() <= 1024
        assert progress[-1] == validations[-1] == max(reached) + 2048
        assert validations == sorted(set(validations))
        assert json.loads((seed / "checkpoint" / "state.json").read_text())["steps"] == progress[-1]
    assert (folder / "agent" / "policy.json").exists()


def wait_for_lock(seeds):
    """The processes of the seeds end by themselves, in a moment."""
    deadline = time.monotonic() + PATIENCE_S
    for seed in seeds:
        while True:
            try:
                with locked(seed / "lock"):
                    break
            except ParamsError:
                assert time.monotonic() < deadline
                time.sleep(0.05)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("ppo", {"vec.stack": 2, "vec.normalise_observation": True}),
        ("ppo", {"vec.normalise_reward": False, "curriculum": [{"start": 0.4, "comfort_m": 20.0}]}),
        (
            "ppo",
            {"recipe.env": "rss_gym/EncounterRangeOnly-v0", "world.planar": False, "world.channel": ["paper", "clean"]},
        ),
        ("recurrent-ppo", {"policy.lstm_hidden_size": 8}),
        ("sac", {}),
    ],
    ids=["wrapped", "bare", "space", "recurrent", "sac"],
)
def test_a_checkpoint_holds_all_that_was_learnt(name, changes, small, tmp_path):
    if name == "sac":
        small = {key: value for key, value in small.items() if key not in ("algorithm.n_steps", "algorithm.n_epochs")}
        small |= {"recipe.steps": 1024, "algorithm.learning_starts": 256, "algorithm.gradient_steps": 1}
        small |= {"algorithm.buffer_size": 4096, "validation.every_steps": 512}
    chosen = recipe.load(name, {**small, **changes})
    run.start(chosen, tmp_path / "run", show=False)
    folder = tmp_path / "run" / "seed-0" / "checkpoint"
    one, other = (Learner.saved(chosen, 0, folder) for _ in range(2))
    one.save(tmp_path)
    assert json.loads((tmp_path / "state.json").read_text()) == json.loads((folder / "state.json").read_text())
    assert one.model.num_timesteps == chosen.steps
    fresh = Learner.new(chosen, 0)
    same, differ = [], []
    for kept, again, new in zip(*(learner.model.policy.parameters() for learner in (one, other, fresh)), strict=True):
        same.append(bool((kept == again).all()))
        differ.append(bool((kept != new).any()))
    assert all(same) and sum(differ) > len(differ) // 2
    states = [learner.model.get_parameters() for learner in (one, fresh)]
    optimizer = "actor.optimizer" if name == "sac" else "policy.optimizer"
    assert states[0][optimizer]["state"] and not states[1][optimizer]["state"]
    if name == "sac":
        assert one.model.log_ent_coef.item() != fresh.model.log_ent_coef.item()
    if chosen.curriculum:
        assert one.training_env.venv.params.reward.comfort_m == 20.0
    # The rows go on with the episodes that come next.
    one.venv.reset()
    np.testing.assert_array_equal(
        one.training_env.numbers, np.array(json.loads((folder / "state.json").read_text())["episodes"]) + 1
    )


@pytest.mark.slow
def test_a_replay_buffer_fills_before_learning_goes_on(small, tmp_path):
    small = {key: value for key, value in small.items() if key not in ("algorithm.n_steps", "algorithm.n_epochs")}
    small |= {"recipe.steps": 1024, "algorithm.learning_starts": 512, "algorithm.buffer_size": 4096}
    small |= {"algorithm.gradient_steps": 1}
    run.start(recipe.load("sac", small), tmp_path / "run", show=False)
    document = json.loads((tmp_path / "run" / "run.json").read_text())
    document["recipe"]["recipe"]["steps"] = 2048
    (tmp_path / "run" / "run.json").write_text(json.dumps(document))
    state = tmp_path / "run" / "seed-0" / "checkpoint" / "state.json"
    before = json.loads(state.read_text())
    run.resume(tmp_path / "run", show=False)
    after = json.loads(state.read_text())
    # One update for each decision of the 64 rows, after the first 512: at the start, and again with the empty buffer.
    assert (before["steps"], before["updates"]) == (1024, (1024 - 512) // 64)
    assert (after["steps"], after["updates"]) == (2048, (1024 - 512) // 64 + (1024 - 512) // 64)


def test_tensorboard_reads_what_the_table_holds(finished):
    accumulator = pytest.importorskip("tensorboard.backend.event_processing.event_accumulator")
    events = accumulator.EventAccumulator(str(finished / "seed-1" / "tensorboard"), {accumulator.SCALARS: 0})
    events.Reload()
    with open(finished / "seed-1" / "progress.csv", newline="") as file:
        table = list(csv.DictReader(file))
    for name in ("train/loss", "validation/collision_rate"):
        expected = {int(row[STEPS]): np.float32(row[name]) for row in table if row[name]}
        assert expected and {event.step: np.float32(event.value) for event in events.Scalars(name)} == expected


@pytest.mark.slow
def test_a_training_without_tensorboard_says_so(small, tmp_path, monkeypatch, capsys):
    from stable_baselines3.common import logger

    monkeypatch.setattr(logger, "SummaryWriter", None)
    run.start(recipe.load("ppo", {**small, "recipe.steps": 1024}), tmp_path / "run", show=False)
    assert "TensorBoard is not installed" in capsys.readouterr().out
    assert not (tmp_path / "run" / "seed-0" / "tensorboard").exists()


def test_a_new_stage_keeps_the_model_and_counts_episodes_on(small):
    chosen = recipe.load("ppo", {**small, "curriculum": [{"start": 0.5, "comfort_m": 20.0}]})
    learner = Learner.new(chosen, 0)
    learner.venv.reset()
    for _ in range(200):
        learner.venv.step(np.zeros((64, 2), np.float32))
    numbers = learner.training_env.numbers
    before = learner.training_env.venv.batch.observations.copy()
    learner.move(1)
    assert learner.training_env.venv.params.reward.comfort_m == 20.0
    np.testing.assert_array_equal(learner.training_env.numbers, numbers + 1)
    assert not np.array_equal(learner.training_env.venv.batch.observations, before)
    assert learner.model._last_episode_starts.all()


def test_episodes_are_recorded(small):
    """Return, length, collision and mean deviation, against a count of one's own."""
    from rss_gym.sb3 import make_vec_env
    from rss_gym.train.training_env import TrainingVecEnv

    chosen = recipe.load("ppo", small)
    training_env, plain = (
        TrainingVecEnv(chosen.params, 8, 5),
        make_vec_env(chosen.env, 8, 5, params=chosen.params, every_info=True),
    )
    np.testing.assert_array_equal(training_env.reset(), plain.reset())
    generator = np.random.default_rng(0)
    kept = [[] for _ in range(8)]
    ended = 0
    for _ in range(250):
        actions = generator.uniform(-1.0, 1.0, (8, 2)).astype(np.float32)
        _, rewards, dones, infos = plain.step(actions)
        again = training_env.step(actions)
        np.testing.assert_array_equal(again[1], rewards)
        for row in range(8):
            kept[row].append(rewards[row])
            assert ("episode" in again[3][row]) == dones[row]
            if dones[row]:
                episode, flown = again[3][row]["episode"], np.array(kept[row], float)
                assert episode["l"] == len(flown) and episode["collision"] == infos[row]["collision"]
                np.testing.assert_allclose(episode["r"], flown.sum())
                # The reward's own count of it, at a price of one.
                assert episode["deviation_m"] == infos[row]["deviation_mean_m"] > 0.0
                kept[row], ended = [], ended + 1
    assert ended >= 8


def test_a_policy_is_kept_only_if_the_ranking_puts_it_first(small):
    from rss_gym.baselines import make

    chosen = recipe.load("ppo", small)
    validator = Validator(chosen.params, 60)
    none, rule = (validator.score(make(spec, chosen.params), "agent") for spec in ("none", "orthogonal:radius_m=60"))
    tracker = BestTracker()
    assert tracker.takes(none) and tracker.takes(rule) and tracker.best is rule
    assert not tracker.takes(none) and tracker.best is rule
    assert not tracker.takes(rule)  # equal: the one there is stays
    assert "of 60" in str(none) and none.to_dict()["collisions"] == none.collisions > 0


def test_the_cheapest_is_kept_whatever_comes_before_and_after():
    n = 2000

    def score(collisions, deviation_m, faults=0):
        collision = np.arange(n) < collisions
        costs = Costs(cost_m(np.full(n, deviation_m), collision, collision), collision, collision)
        return ValidationScore(Candidate("agent", faults, costs, np.arange(n, dtype=np.uint64)), {})

    # 10,100 m over 2,000 encounters are 5.05 m a collision.
    scores = [score(3, 10.0), score(2, 20.0), score(1, 16.0), score(0, 21.0), score(0, 21.5), score(0, 1.0, faults=1)]
    tracker = BestTracker()
    assert [tracker.takes(one) for one in scores] == [True, False, True, True, False, False]
    broken = BestTracker()
    assert [broken.takes(one) for one in scores[::-1]] == [True, True, True, False, False, False]


def refused(capsys, *arguments):
    status = main(["train", *arguments])
    captured = capsys.readouterr()
    assert status == 2 and not captured.out and len(captured.err.strip().splitlines()) == 1
    return captured.err


def test_bad_arguments_are_one_sentence(capsys, tmp_path, finished):
    out = str(tmp_path / "run")
    assert "ppo-short" in refused(capsys)
    assert "--out" in refused(capsys, "ppo")
    assert "did you mean 'ppo'" in refused(capsys, "pppo", "--out", out)
    assert "seeds" in refused(capsys, "ppo", "--seeds", "0", "--out", out)
    assert "workers" in refused(capsys, "ppo", "--workers", "0", "--out", out)
    assert "steps" in refused(capsys, "ppo", "--steps", "-1", "--out", out)
    assert "did you mean" in refused(capsys, "ppo", "--env", "rss_gym/Encounter-v1", "--out", out)
    assert "information" in refused(capsys, "ppo", "--information", "blind", "--out", out)
    assert "'papr'" in refused(capsys, "ppo", "--channel", "papr", "--out", out)
    assert "key=value" in refused(capsys, "ppo", "--set", "steps", "--out", out)
    assert "nothing but --workers" in refused(capsys, "ppo", "--resume", str(finished))
    assert "nothing but --workers" in refused(capsys, "--steps", "5", "--resume", str(finished))
    assert "not the folder of a run" in refused(capsys, "--resume", str(tmp_path))
    assert "exists and is not empty" in refused(capsys, "ppo", "--out", str(finished))
    assert list(tmp_path.iterdir()) == []


def test_a_run_of_other_numbers_is_refused(finished, tmp_path):
    document = json.loads((finished / "run.json").read_text())
    document["world"]["aircraft"]["gust_mps"] = 0.3
    (tmp_path / "run.json").write_text(json.dumps(document))
    with pytest.raises(ParamsError, match="other numbers"):
        run.resume(tmp_path)
    document["format"] = 7
    (tmp_path / "run.json").write_text(json.dumps(document))
    with pytest.raises(ParamsError, match="format = 7 must be 1"):
        run.resume(tmp_path)


@pytest.mark.parametrize("damage", ["state", "model"])
def test_a_spoilt_checkpoint_is_refused_in_one_sentence(finished, tmp_path, damage):
    source = finished / "seed-0" / "checkpoint"
    for file in ("state.json", "model.zip"):
        content = (source / file).read_bytes()
        (tmp_path / file).write_bytes(content[: len(content) // 2] if file.startswith(damage) else content)
    with pytest.raises(ParamsError, match="cannot be read") as caught:
        Learner.saved(run.read(finished)[0], 0, tmp_path)
    assert "\n" not in str(caught.value)


def test_training_without_its_packages_is_one_sentence(monkeypatch, small, tmp_path):
    monkeypatch.setitem(sys.modules, "sb3_contrib", None)
    with pytest.raises(ParamsError, match=r"sb3_contrib.*-e '\.\[train\]"):
        run.start(recipe.load("recurrent-ppo", {"recipe.steps": 1}), tmp_path / "run")
    assert list(tmp_path.iterdir()) == []


def test_importing_the_package_needs_no_learner():
    code = "import rss_gym.train.run, rss_gym.train.convert, sys; print(*sys.modules)"
    shown = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert not {"torch", "stable_baselines3"} & set(shown.stdout.split())


def test_an_interrupt_says_how_to_go_on(monkeypatch, capsys, tmp_path, small):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(run, "start", interrupted)
    assert main(["train", "ppo", "--out", str(tmp_path / "run")]) == 130
    assert f"--resume {tmp_path / 'run'}" in capsys.readouterr().err


def test_progress_bars_count_on(small, tmp_path, capsys):
    run.start(recipe.load("ppo", {**small, "recipe.steps": 2048}), tmp_path / "run", show=True)
    captured = capsys.readouterr()
    assert "seed 0: 100%" in captured.err
    assert "decisions a second" in captured.out and "environment" in captured.out
    assert Path(tmp_path / "run" / "agent").is_dir() and os.listdir(tmp_path) == ["run"]
