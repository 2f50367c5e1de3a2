"""Every part of the registries keeps the contract that parts of a user's own are held to."""

import pytest

from rss_gym.domain import ROAD
from rss_gym.encounters import FAMILIES
from rss_gym.eval.suites import SUITES
from rss_gym.params import CHANNELS
from rss_gym.ranging import ESTIMATORS
from rss_gym.testing import check_channel, check_estimator, check_family, check_suite, check_tracker
from rss_gym.tracking import TRACKERS


@pytest.mark.parametrize("name", CHANNELS)
def test_every_channel(name):
    check_channel(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", ESTIMATORS)
def test_every_estimator(name):
    check_estimator(name)


@pytest.mark.parametrize("name", TRACKERS)
def test_every_tracker(name):
    check_tracker(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILIES)
def test_every_family(name):
    check_family(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", SUITES)
def test_every_suite(name):
    if SUITES[name].domain is ROAD:
        pytest.importorskip("highway_env", reason="highway-env is not installed (extra `highway`)")
    check_suite(name)
