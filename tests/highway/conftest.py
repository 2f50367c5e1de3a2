"""Roads need highway-env, which the extra `dev` brings; without it these tests are skipped."""

import warnings
from pathlib import Path

import pytest

try:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of packages that it imports
        import highway_env.envs  # noqa: F401
except ImportError:
    MISSING = True
else:
    MISSING = False


def pytest_collection_modifyitems(items):
    """Skip what is below this folder where highway-env is missing."""
    for item in items:
        if MISSING and Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.skip(reason="highway-env is not installed (extra `highway`)"))
