"""A Gymnasium environment for UAV collision avoidance with ranges from radio signal strength (RSS).

Importing this package registers the environments' names and loads nothing heavy.
"""

from importlib.metadata import PackageNotFoundError, version

from rss_gym.extend import (
    register_channel,
    register_estimator,
    register_family,
    register_metric,
    register_rule,
    register_suite,
    register_tracker,
)
from rss_gym.ids import register_all

try:
    __version__ = version("rss-gym")
except PackageNotFoundError:  # a checkout that was never installed
    __version__ = "0+unknown"

register_all()

__all__ = [
    "__version__",
    "register_channel",
    "register_estimator",
    "register_family",
    "register_metric",
    "register_rule",
    "register_suite",
    "register_tracker",
]
