"""What every metric of the registry must keep."""

import time

import pytest

from rss_gym.eval.metrics import METRICS, defined_in
from rss_gym.testing import check_metric
from rss_gym.testing.metric import random_flights


@pytest.mark.parametrize("name", METRICS)
def test_every_metric_keeps_the_contract(name):
    check_metric(name)


def test_nine_policies_in_time():
    flights = [random_flights(10_000, seed) for seed in range(9)]
    start = time.process_time()  # of this process, whatever else the machine does
    for one in flights:
        for metric in defined_in("air").values():
            metric(one)
    assert time.process_time() - start < 5.0
