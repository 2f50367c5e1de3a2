"""Roads need highway-env, which the extra `dev` brings."""

import warnings

import pytest

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # of packages that it imports
    pytest.importorskip("highway_env", reason="highway-env is not installed (extra `highway`)")
    import highway_env.envs  # noqa: F401
