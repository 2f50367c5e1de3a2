"""One run in parts and on executors: whatever flies the episodes, the scores are those of one process, bit for bit."""

import importlib
import multiprocessing
import os
import pickle
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from rss_gym.eval import evaluate, fly, merge
from rss_gym.eval.episodes import PolicyError
from rss_gym.eval.reading import load
from rss_gym.eval.records import save
from rss_gym.eval.verify import verify
from rss_gym.params import ParamsError

HERE = Path(__file__).parent
sys.path.append(str(HERE))
flyers = importlib.import_module("flyers")

POLICIES = ["orthogonal", "flyers:Flyer"]
EPISODES = 30
PATIENCE_S = 900.0  # until something counts as hanging: kernels may have to be compiled first, on a loaded machine


def scored(**keywords):
    return evaluate(POLICIES, episodes=EPISODES, progress=False, **keywords)


def same(one, other):
    """Whether two results are of the same run and hold the same tables and metrics, bit for bit."""
    runs = [(r.suite, r.seed, r.episodes, r.first_episode, r.official, r.reference) for r in (one, other)]
    return runs[0] == runs[1] and all(
        a.entry.hash == b.entry.hash and a.table.tobytes() == b.table.tobytes() and a.metrics == b.metrics
        for a, b in zip(one.policies, other.policies, strict=True)
    )


@pytest.fixture(scope="module")
def alone():
    return scored()


def part(first, last, policy=POLICIES, **keywords):
    return fly(policy, episodes=range(first, last), **keywords)


@pytest.fixture(scope="module")
def parts():
    return [part(first, last) for first, last in ((0, 7), (7, 20), (20, EPISODES))]


def test_parts_in_any_order_give_the_result_of_one_run(alone, parts):
    sent = [pickle.loads(pickle.dumps(parts[index])) for index in (2, 0, 1)]
    assert same(merge(sent), alone)
    assert merge(parts)["orthogonal"] == alone["orthogonal"]


def test_the_parts_of_an_official_run_are_an_official_run():
    halves = [fly("orthogonal", "smoke-v0", range(first, first + 50)) for first in (0, 50)]
    assert merge(halves).official and not merge(halves[:1]).official and not merge(halves[1:]).official


def test_a_range_is_a_run_of_its_own_that_is_saved_and_verified(alone, parts, tmp_path):
    middle = merge(parts[1:2])
    assert same(middle, evaluate(POLICIES, episodes=range(7, 20), progress=False))
    assert middle.policies[1].table.tobytes() == alone.policies[1].table[7:20].tobytes()
    folder = save(middle, tmp_path / "run")
    assert load(folder).first_episode == 7
    verdict = verify(folder, every=True, trust=True)
    assert verdict.verified and verdict.flown["orthogonal"] == 13


def test_an_object_travels_with_its_part(alone):
    halves = [part(first, first + 10, {"mine": flyers.Flyer()}) for first in (0, 10)]
    merged = merge(halves)
    assert merged.policies[1].table.tobytes() == alone.policies[2].table[:20].tobytes()


@pytest.mark.parametrize(
    ("chosen", "words"),
    [
        ([], "at least one part"),
        ([0, 2], "episode 7 is missing"),
        ([0, 1, 1], "episode 7 is given twice"),
    ],
)
def test_episodes_that_are_missing_or_given_twice(parts, chosen, words):
    with pytest.raises(ParamsError, match=words):
        merge(parts[index] for index in chosen)


@pytest.mark.parametrize(
    "keywords", [{"policy": ["orthogonal"]}, {"seed": 1}, {"channel": "clean"}, {"reference": "none"}]
)
def test_parts_of_different_runs(parts, keywords):
    with pytest.raises(ParamsError, match="different runs"):
        merge([parts[0], part(7, 9, **keywords)])


@pytest.mark.parametrize("episodes", [range(0), range(0, 10, 2), range(-1, 3), range(2**63, 2**63 + 1), 0, True, 1.5])
def test_episodes_that_are_no_run(episodes):
    with pytest.raises(ParamsError, match="episodes"):
        evaluate("none", episodes=episodes, progress=False)


# Executors


def test_threads(alone):
    with ThreadPoolExecutor(2) as executor:
        assert same(scored(executor=executor, block=8), alone)
        executor.submit(int).result()  # it is left open


@pytest.mark.slow
def test_loky(alone):
    loky = pytest.importorskip("loky", reason="loky is not installed: pip install -e '.[cluster]' in the clone")
    executor = loky.get_reusable_executor(max_workers=2)
    try:
        assert same(scored(executor=executor, block=8), alone)
        with pytest.raises(PolicyError, match="a worker process died"):
            evaluate("flyers:Exit", episodes=8, block=4, executor=executor, progress=False)
    finally:
        executor.shutdown(wait=True, kill_workers=True)


@pytest.mark.slow
def test_joblib(alone):
    joblib = pytest.importorskip("joblib", reason="joblib is not installed: pip install -e '.[cluster]' in the clone")
    tasks = [joblib.delayed(part)(first, first + 10) for first in range(0, EPISODES, 10)]
    assert same(merge(joblib.Parallel(n_jobs=2)(tasks)), alone)


@pytest.mark.slow
def test_nothing_is_lost_with_a_worker_of_dask_that_is_killed(alone, tmp_path, monkeypatch):
    distributed = pytest.importorskip(
        "distributed", reason="dask is not installed: pip install -e '.[cluster]' in the clone"
    )
    monkeypatch.setenv(flyers.MARKS, str(tmp_path))
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
        ThreadPoolExecutor(1) as thread,
    ):
        flying = thread.submit(
            evaluate, "flyers:Sleeper", episodes=EPISODES, block=3, progress=False, executor=client.get_executor()
        )
        end = time.monotonic() + PATIENCE_S
        while not (begun := list(tmp_path.iterdir())):
            assert time.monotonic() < end and not flying.done(), "no worker has begun"
            time.sleep(0.05)
        os.kill(int(begun[0].name), 9)
        found = flying.result(timeout=PATIENCE_S)
        assert len(list(tmp_path.iterdir())) > 1
    assert found.policies[1].table.tobytes() == alone.policies[2].table.tobytes()


@pytest.mark.slow
def test_ray(alone):
    ray = pytest.importorskip("ray", reason="Ray is not installed: pip install ray")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, runtime_env={"env_vars": {"PYTHONPATH": path()}})
    try:
        remote = ray.remote(fly)
        tasks = [remote.remote(POLICIES, episodes=range(k, k + 10)) for k in range(0, EPISODES, 10)]
        assert same(merge(ray.get(tasks)), alone)
    finally:
        ray.shutdown()


def path():
    """Where a worker finds what this process has imported."""
    return os.pathsep.join(filter(None, sys.path))


def in_a_daemon(_):
    assert multiprocessing.current_process().daemon
    return scored(workers=2)


@pytest.mark.slow
def test_a_daemon_process_flies_everything_itself(alone):
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert same(pool.map(in_a_daemon, [0])[0], alone)


@pytest.mark.parametrize("keywords", [{"executor": 2}, {"executor": ThreadPoolExecutor, "workers": 2}])
def test_what_is_no_executor(keywords):
    with pytest.raises(ParamsError, match=r"concurrent\.futures\.Executor"):
        scored(**keywords)
