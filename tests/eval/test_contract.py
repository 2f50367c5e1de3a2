"""What every metric of the registry must keep."""

import json
import time
from dataclasses import asdict
from math import isfinite

import numpy as np
import pytest

from rss_gym.eval.metrics import METRICS, Metric

SIZES = (0, 1, 2, 3, 10, 400)


@pytest.fixture(params=METRICS)
def metric(request):
    """Every metric."""
    return METRICS[request.param]


def degenerate(flights):
    """Flights with every event and number at an extreme."""
    for value in (0, 1):
        table = flights.table.copy()
        for name in table.dtype.names:
            if name not in ("episode", "duration_s", "flown_s"):
                table[name] = value
        for none in (table, flights.none):
            yield type(flights)(table, none, table, 120.0, 8, 0.8, 1.0)


def check(estimate):
    """Numbers are Python's own, finite, and in order."""
    assert type(estimate.n) is int and estimate.n >= 0
    assert estimate.unit
    for number in (estimate.value, estimate.low, estimate.high):
        assert number is None or (type(number) is float and isfinite(number))
    if estimate.value is None:
        assert estimate.low is None and estimate.high is None
    if estimate.low is not None:
        assert estimate.low <= estimate.value
    if estimate.high is not None:
        assert estimate.value <= estimate.high
    assert json.loads(json.dumps(asdict(estimate), allow_nan=False)) == asdict(estimate)


def test_declares_itself(metric):
    assert isinstance(metric, Metric)
    assert metric.summary and metric.unit in ("1", "m", "s", "1/h", "count")
    assert metric.function.__doc__ or metric.function.func.__doc__


def test_name_ends_in_the_unit(metric):
    name = next(name for name, other in METRICS.items() if other is metric)
    suffix = {"m": "_m", "s": "_s", "1/h": "_ph"}.get(metric.unit, "")
    assert name.endswith(suffix)
    assert suffix or not name.endswith(("_m", "_s", "_ph"))


@pytest.mark.parametrize("n", SIZES)
def test_estimates_are_sound(metric, n, random_flights):
    for seed in range(20 if n < 100 else 3):
        check(metric(random_flights(n, seed)))


@pytest.mark.parametrize("n", SIZES)
def test_estimates_of_degenerate_flights_are_sound(metric, n, random_flights):
    for flights in degenerate(random_flights(n)):
        check(metric(flights))


def test_without_reference(metric, random_flights):
    flights = random_flights(50)
    check(metric(type(flights)(flights.table, flights.none, None, 120.0, 8, 0.8, 1.0)))


def test_order_of_rows_changes_no_bit(metric, random_flights):
    flights = random_flights(400)
    expected = metric(flights)
    for seed in range(5):
        assert metric(flights.rows(np.random.default_rng(seed).permutation(400))) == expected


def test_tables_are_not_changed(metric, random_flights):
    flights = random_flights(50)
    before = [table.tobytes() for table in (flights.table, flights.none, flights.reference)]
    metric(flights)
    assert [table.tobytes() for table in (flights.table, flights.none, flights.reference)] == before


def test_sensor_metrics_are_those_that_the_policy_cannot_change(metric, random_flights):
    flights = random_flights(400)
    table = flights.none.copy()
    table["fault"] = True
    other = type(flights)(table, flights.none, flights.reference, 120.0, 8, 0.8, 1.0)
    assert (metric(other) == metric(flights)) == metric.sensor


def test_nine_policies_in_time(random_flights):
    flights = [random_flights(10_000, seed) for seed in range(9)]
    start = time.process_time()  # of this process, whatever else the machine does
    for one in flights:
        for metric in METRICS.values():
            metric(one)
    assert time.process_time() - start < 5.0
