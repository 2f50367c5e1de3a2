"""Settings and fixtures for all tests."""

import os
import warnings

import pytest
from hypothesis import settings

# Windows of pygame and figures of matplotlib go nowhere; both read these before they are imported.
os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
os.environ.setdefault("MPLBACKEND", "Agg")

# The first example may compile a kernel, so there is no deadline; in CI every run draws the same examples.
settings.register_profile("dev", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "dev")

IDS = ("rss_gym/Encounter-v0", "rss_gym/Encounter3D-v0", "rss_gym/EncounterRangeOnly-v0")
TRACKS = ("oracle", "paper", "range")
ACTIONS = ("displacement", "velocity", "discrete")


@pytest.fixture(params=IDS, ids=lambda name: name.partition("/")[2])
def env_id(request):
    """Every registered id (test_ids_are_all guards the list)."""
    return request.param


@pytest.fixture(params=TRACKS)
def track(request):
    """Every track."""
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
