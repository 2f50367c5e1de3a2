"""Scores are the same for any number of workers and any block, and a run that ends badly leaves nothing behind."""

import importlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from rss_gym.eval import evaluate
from rss_gym.eval.episodes import Block, PolicyError, fly_episodes
from rss_gym.eval.policies import entry
from rss_gym.eval.records import save
from rss_gym.eval.suites import find
from rss_gym.files import MARK, new_folder
from rss_gym.params import ParamsError

HERE = Path(__file__).parent
sys.path.append(str(HERE))  # workers are started with the same path
flyers = importlib.import_module("flyers")

EPISODES = 70
PATIENCE_S = 900.0  # until something counts as hanging: kernels may have to be compiled first, on a loaded machine
POLICIES = ["none", "orthogonal", "random", "flyers:Flyer", "flyers:NanOnce"]


def flown(policies=POLICIES, episodes=EPISODES, **keywords):
    return evaluate(policies, episodes=episodes, progress=False, **keywords)


def same(one, other):
    """Whether two results hold the same tables and metrics, bit for bit."""
    assert [scored.entry.name for scored in one.policies] == [scored.entry.name for scored in other.policies]
    return all(
        a.table.tobytes() == b.table.tobytes() and a.metrics == b.metrics
        for a, b in zip(one.policies, other.policies, strict=True)
    )


@pytest.fixture(scope="module")
def alone():
    """The result of one process and one block."""
    return flown(block=2048)


@pytest.mark.parametrize("block", [pytest.param(7, marks=pytest.mark.slow), 64, 2048])
def test_any_block_gives_the_same_scores(alone, block):
    assert same(flown(block=block), alone)


def test_each_encounter_on_its_own_gives_the_same_rows(alone):
    for one, other in zip(flown(episodes=5, block=1).policies, alone.policies, strict=True):
        assert one.table.tobytes() == other.table[:5].tobytes()


@pytest.mark.parametrize("workers", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_any_number_of_workers_gives_the_same_scores(alone, workers, tmp_path):
    result = flown(workers=workers, block=16)
    assert same(result, alone)
    one, other = (save(run, tmp_path / name) for run, name in ((alone, "alone"), (result, "together")))
    assert (one / "scores.json").read_bytes() == (other / "scores.json").read_bytes()


@pytest.mark.slow
def test_objects_are_flown_by_workers_too(alone):
    given = {"none": "none", "mine": flyers.Flyer()}
    result = flown(given, episodes=20, workers=2)
    assert result.policies[1].table.tobytes() == alone.policies[3].table[:20].tobytes()


@pytest.mark.parametrize("numbers", [(5,), (69, 3, 40), range(60, 70)])
def test_any_selection_of_episodes_gives_the_same_rows(alone, numbers):
    suite = find("encounter-v0")
    chosen = list(numbers)
    for index, spec in ((0, "none"), (2, "random"), (3, "flyers:Flyer")):
        item = entry(spec, suite.params)
        table, _ = fly_episodes(item.policy, item.name, item.params, Block(suite.split, 0, numbers))
        expected = alone.policies[index].table[chosen]
        expected["manoeuvre_m"] = 0.0  # for want of the positions of `none`
        assert table.tobytes() == expected.tobytes()


# Policies that misbehave


def test_actions_that_are_not_finite_are_faults_of_their_episode(alone):
    faults = np.flatnonzero(alone.policies[4].table["fault"])
    assert 0 < len(faults) < 20
    assert alone["flyers:NanOnce"]["faults"].value == len(faults)
    # The other encounters are flown as if nothing had been.
    well = ~alone.policies[4].table["fault"]
    assert alone.policies[4].table[well].tobytes() == alone.policies[3].table[well].tobytes()


def test_a_policy_that_changes_its_arguments_changes_nothing(alone):
    result = flown(["flyers:Meddler"], episodes=20)
    assert result.policies[1].table.tobytes() == alone.policies[3].table[:20].tobytes()


def test_a_slow_policy_scores_as_a_fast_one(alone):
    result = flown(["flyers:Sleeper"], episodes=20)
    assert result.policies[1].table.tobytes() == alone.policies[3].table[:20].tobytes()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("Raiser", ["RuntimeError: lost the way", "flyers.py:", "decision 3 of 20 episodes in 0..19 of seed 5"]),
        ("Shape", ["(20, 5)", "(20, 2)", "decision 0"]),
        ("Ragged", ["'flyers:Ragged'"]),
        ("Text", ["real numbers"]),
        ("Alone", ["(actions, state)", "ndarray"]),
        ("Quit", ["SystemExit"]),
    ],
)
def test_a_policy_that_gives_no_actions_ends_the_run(name, words):
    with pytest.raises(PolicyError) as caught:
        flown([f"flyers:{name}"], episodes=20, seed=5)
    sentence = str(caught.value)
    assert f"flyers:{name}" in sentence and "\n" not in sentence
    for word in words:
        assert word in sentence


@pytest.mark.slow
def test_a_policy_that_raises_in_a_worker_is_named():
    with pytest.raises(PolicyError, match=r"flyers:Raiser.*lost the way"):
        flown(["flyers:Raiser"], episodes=20, workers=2)


def test_a_policy_that_cannot_be_made_is_one_sentence():
    with pytest.raises(ParamsError, match=r"flyers:unmade.*no weights at model\.zip"):
        flown(["flyers:unmade"], episodes=5)


def test_an_object_that_cannot_be_sent_is_one_sentence():
    with pytest.raises(
        ParamsError, match=r"'mine' is an object that cannot be sent.*module:attribute, or use workers=1"
    ):
        flown({"mine": flyers.Locked()}, episodes=20, workers=2)
    flown({"mine": flyers.Locked()}, episodes=5)


@pytest.mark.slow
def test_an_object_that_cannot_be_loaded_by_a_worker_is_one_sentence():
    with pytest.raises(PolicyError, match=r"cannot be loaded in a worker.*no module named 'private'"):
        flown({"mine": flyers.Elsewhere()}, episodes=20, workers=2)


@pytest.mark.parametrize("name", ["  ", "a\nb", "\x1b[31mred", "x" * 201, 7, "\ud800"])
def test_names_that_no_table_could_show_are_refused(name):
    with pytest.raises(ParamsError, match="printable"):
        flown({name: "orthogonal"}, episodes=5)


def test_nobody_else_is_named_none():
    with pytest.raises(ParamsError, match="'none' belongs to doing nothing"):
        flown({"none": "orthogonal"}, episodes=5)


# Runs that end badly

COMMAND = [sys.executable, "-c", "import sys; from rss_gym.cli import main; sys.exit(main())", "eval"]


@pytest.fixture
def started(tmp_path):
    """Function (policy, workers) -> the running command and the processes that fly, once these do."""
    marks = tmp_path / "marks"
    marks.mkdir()
    commands = []

    def start(policy, workers=1):
        options = ["--policy", policy, "--episodes", "20", "--workers", str(workers)]
        command = subprocess.Popen(
            [*COMMAND, *options, "--out", str(tmp_path / "new" / "run")],
            cwd=HERE,
            env=os.environ | {flyers.MARKS: str(marks)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            # A test run in the background inherits an ignored SIGINT.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )
        commands.append(command)
        wait_for(lambda: command.poll() is not None or len(list(marks.iterdir())) == workers)
        return command, [int(file.name) for file in marks.iterdir()]

    yield start
    for command in commands:
        if command.poll() is None:
            command.kill()
        command.communicate()


def wait_for(condition):
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)


def runs(process):
    """Whether there is a process of that number that has not ended."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


linux = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks for processes in /proc")


def left(tmp_path):
    return [path.name for path in tmp_path.iterdir() if path.name != "marks"]


@linux
@pytest.mark.parametrize(
    ("workers", "to_all"),
    [(1, False), pytest.param(2, False, marks=pytest.mark.slow), pytest.param(2, True, marks=pytest.mark.slow)],
    ids=["alone", "workers", "terminal"],
)
def test_ctrl_c_leaves_nothing_behind(started, tmp_path, workers, to_all):
    command, flying = started("flyers:Hang", workers)
    if to_all:  # as a terminal does
        os.killpg(command.pid, signal.SIGINT)
    else:
        command.send_signal(signal.SIGINT)
    out, err = command.communicate(timeout=PATIENCE_S)
    assert command.returncode == 130 and not out
    assert [line for line in err.splitlines() if "compiling" not in line] == [
        "rss-gym: interrupted; nothing was written"
    ]
    assert len(flying) == workers and not any(map(runs, flying))
    assert left(tmp_path) == []


@linux
def test_a_killed_run_leaves_neither_scores_nor_workers(started, tmp_path):
    command, flying = started("flyers:Hang", 2)
    command.kill()
    command.communicate(timeout=PATIENCE_S)  # workers that live on would hold its output open
    wait_for(lambda: not any(map(runs, flying)))
    assert os.listdir(tmp_path / "new" / "run") == [MARK]
    with new_folder(tmp_path / "new" / "run") as folder:  # the next run finds the place free
        (folder / "scores.json").write_text("{}")
    assert os.listdir(tmp_path / "new" / "run") == ["scores.json"]


@pytest.mark.slow
@linux
def test_a_worker_that_dies_ends_the_run(started, tmp_path):
    command, flying = started("flyers:Exit", 2)
    out, err = command.communicate(timeout=PATIENCE_S)
    assert command.returncode == 1 and not out
    lines = [line for line in err.splitlines() if "compiling" not in line]
    assert len(lines) == 1 and "a worker process died" in lines[0]
    assert not any(map(runs, flying)) and left(tmp_path) == []


@pytest.mark.slow
def test_a_script_without_a_guard_is_told_so(tmp_path):
    script = tmp_path / "script.py"
    script.write_text("from rss_gym.eval import evaluate\nevaluate('none', episodes=20, workers=2)\n")
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.returncode != 0
    assert "WorkerError: a worker process died" in done.stderr and "__name__ == '__main__'" in done.stderr
