"""Contract tests for parts of your own: one call each, with `assert` and no test framework.

The tests of this package call the same functions for the parts that are shipped. Each takes the name of a registered
part and raises `AssertionError` with what is wrong.
"""

from __future__ import annotations

from rss_gym.testing.channel import check_channel
from rss_gym.testing.estimator import check_estimator
from rss_gym.testing.family import check_family
from rss_gym.testing.metric import check_metric
from rss_gym.testing.policy import check_policy
from rss_gym.testing.rule import check_rule
from rss_gym.testing.suite import check_suite
from rss_gym.testing.tracker import check_tracker

__all__ = [
    "check_channel",
    "check_estimator",
    "check_family",
    "check_metric",
    "check_policy",
    "check_rule",
    "check_suite",
    "check_tracker",
]
