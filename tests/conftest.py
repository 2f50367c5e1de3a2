"""Settings and fixtures for all tests."""

import os
import warnings

import pytest
from hypothesis import settings

# Tests run beside each other: the threads of one's matrix products would wait for those of another's.
for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
# Windows of pygame and figures of matplotlib go nowhere; both read these before they are imported.
os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
os.environ.setdefault("MPLBACKEND", "Agg")

# Every run draws the same examples; `make explore` draws fresh ones. The first may compile a kernel: no deadline.
settings.register_profile("same", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None, max_examples=1000, print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))

IDS = ("rss_gym/Encounter-v0", "rss_gym/Encounter3D-v0", "rss_gym/EncounterRangeOnly-v0")
INFORMATION = ("oracle", "positions", "ranges")
ACTIONS = ("velocity", "discrete")


@pytest.fixture(params=IDS, ids=lambda name: name.partition("/")[2])
def env_id(request):
    """Every registered id (test_ids_are_all guards the list)."""
    return request.param


@pytest.fixture(params=INFORMATION)
def information(request):
    """Every level of information."""
    return request.param


@pytest.fixture(params=ACTIONS)
def action(request):
    """Every kind of action."""
    return request.param


@pytest.fixture
def no_warnings():
    """Turn every warning of the test's body into an error, Gymnasium's logger's too."""
    from gymnasium import logger

    assert logger.min_level <= logger.WARN
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


@pytest.fixture(scope="session")
def tiny_run(tmp_path_factory):
    """A finished training of two seeds, a matter of a second, whose agent is no good."""
    pytest.importorskip("stable_baselines3", reason="stable-baselines3 (extra `train`) is not installed")
    from rss_gym.train import recipe, run

    changes = {"recipe.steps": 2048, "vec.n_envs": 64, "algorithm.n_steps": 16, "algorithm.batch_size": 256}
    changes |= {"algorithm.n_epochs": 1, "policy.net_arch": [8], "imitation.episodes": 0}
    changes |= {"validation.every_steps": 1024, "validation.episodes": 40, "checkpoint.every_steps": 1024}
    folder = tmp_path_factory.mktemp("runs") / "tiny"
    run.start(recipe.load("ppo", changes), folder, seeds=2, show=False)
    return folder


@pytest.fixture(scope="session")
def tiny_agent(tiny_run, tmp_path_factory):
    """The policy folder that `rss_gym.train.ship` makes of it."""
    from rss_gym.train.ship import ship

    return ship(tiny_run, "tiny", "- It has hardly been trained.", tmp_path_factory.mktemp("agents"))
