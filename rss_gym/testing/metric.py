"""What every metric must keep."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from math import isfinite

import numpy as np

from rss_gym.eval.costs import cost_m
from rss_gym.eval.metrics import METRICS, Estimate, Flights, Metric
from rss_gym.eval.table import TABLE, TABLES

SIZES = (0, 1, 2, 3, 10, 400)
UNITS = {"1": "", "m": "_m", "s": "_s", "m/s": "_mps", "1/h": "_ph", "count": ""}  # unit -> end of the name


def check_metric(name: str) -> None:
    """It says what it is; on any flights its estimate is sound and JSON; no order of the rows changes a bit."""
    metric = METRICS[name]
    check_declaration(name)
    columns = columns_of(metric)
    for size in SIZES:
        for seed in range(20 if size < 100 else 3):
            check_estimate(metric(random_flights(size, seed, columns)), metric)
        for flights in degenerate(random_flights(size, columns=columns)):
            check_estimate(metric(flights), metric)
    flights = random_flights(50, columns=columns)
    check_estimate(metric(flights_of(flights.table, flights.none, None)), metric)
    check_order(metric)
    check_arguments(metric)


def check_declaration(name: str) -> None:
    """Summary, unit, docstring; the name ends in the unit."""
    metric = METRICS[name]
    function = getattr(metric.function, "func", metric.function)
    assert metric.summary.strip(), f"metric {name!r} has no summary"
    assert metric.unit in UNITS, f"metric {name!r}: unit {metric.unit!r} must be one of {', '.join(UNITS)}"
    assert function.__doc__, f"metric {name!r}: its function has no docstring"
    end = UNITS[metric.unit]
    others = tuple(filter(None, {*UNITS.values()} - {end}))
    assert name.endswith(end) and (end or not name.endswith(others)), f"metric {name!r}: its name must end in its unit"


def check_estimate(estimate: Estimate, metric: Metric) -> None:
    """Numbers are Python's own, finite and in order."""
    assert estimate.unit == metric.unit
    assert type(estimate.n) is int and estimate.n >= 0, f"n = {estimate.n!r} must be a whole number >= 0"
    for number in (estimate.value, estimate.low, estimate.high):
        assert number is None or (type(number) is float and isfinite(number)), f"{number!r} is no finite float"
    if estimate.value is None:
        assert estimate.low is None and estimate.high is None, "without a value there is no interval"
    else:
        assert estimate.low is None or estimate.low <= estimate.value, "the interval must hold the value"
        assert estimate.high is None or estimate.value <= estimate.high, "the interval must hold the value"
    assert json.loads(json.dumps(asdict(estimate), allow_nan=False)) == asdict(estimate)


def check_order(metric: Metric) -> None:
    """Not a bit depends on the order of the encounters."""
    flights = random_flights(400, columns=columns_of(metric))
    for seed in range(5):
        shuffled = flights.rows(np.random.default_rng(seed).permutation(400))
        assert metric(shuffled) == metric(flights), "the value depends on the order of the rows"


def check_arguments(metric: Metric) -> None:
    """The tables are left alone, and `sensor` metrics are those that no policy can change."""
    flights = random_flights(400, columns=columns_of(metric))
    tables = [table for table in (flights.table, flights.none, flights.reference) if table is not None]
    before = [table.copy() for table in tables]
    found = metric(flights)
    assert all(map(np.array_equal, tables, before)), "the tables are changed"
    other = flights.none.copy()
    other["fault"] = True
    unchanged = metric(flights_of(other, flights.none, flights.reference)) == found
    assert unchanged == metric.sensor, "`sensor` must say whether the flights of `none` alone give the value"


def flights_of(table: np.ndarray, none: np.ndarray, reference: np.ndarray | None = None) -> Flights:
    """Flights in the zone of the paper."""
    return Flights(table, none, reference, suite_radius_m=120.0, trials=8, range_error_probability=0.8, reaction_s=1.0)


def columns_of(metric: Metric) -> np.dtype:
    """Those of the first domain that the metric is defined in."""
    return TABLES[metric.domains[0]]


def random_flights(n: int, seed: int = 0, columns: np.dtype = TABLE) -> Flights:
    """`n` random encounters with a policy, `none` and a reference."""
    generator = np.random.default_rng([seed, n])
    return flights_of(*(random_table(generator, n, risk, columns) for risk in (0.02, 0.5, 0.05)))


def random_table(generator: np.random.Generator, n: int, risk: float, columns: np.dtype = TABLE) -> np.ndarray:
    """Flights that could be: events nested, ends after collisions."""
    out = np.zeros(n, columns)
    out["episode"] = np.arange(n)
    out["duration_s"] = generator.uniform(60, 105, n)
    out["min_separation_m"] = generator.exponential(4.5 / risk, n)
    for event, limit_m in (("collision", 4.5), ("snmac", 15.0), ("zone", 120.0)):
        out[event] = out["min_separation_m"] < limit_m
    out["flown_s"] = np.where(out["collision"], generator.uniform(20, 60, n), out["duration_s"])
    out["closest_s"] = generator.uniform(0, out["flown_s"])
    for name in ("deviation_mean_m", "deviation_max_m", "deviation_end_m", "manoeuvre_m"):
        out[name] = generator.exponential(5.0, n)
    out["zone_severity"] = generator.random(n) * out["zone"]
    out["cost_m"] = cost_m(out["deviation_mean_m"], out["snmac"], out["collision"])
    out["flown_m"], out["planned_m"] = generator.uniform(200, 400, (2, n))
    out["warned_s"] = np.where(generator.random(n) < 0.1, -1.0, generator.uniform(0, 40, n))
    out["false_alerts"], out["missed_ticks"] = generator.poisson(0.3, n), generator.poisson(4.0, n)
    out["sample_separation_m"] = generator.uniform(2, 190, n)
    out["sample_range_m"] = out["sample_separation_m"] + generator.normal(0, 20, n)
    for name in (columns.names or ())[len(TABLE.names or ()) :]:
        out[name] = generator.exponential(2.0, n)
    return out


def degenerate(flights: Flights) -> Iterator[Flights]:
    """Flights with every event and number at an extreme."""
    for value in (0, 1):
        table = flights.table.copy()
        for name in table.dtype.names or ():
            if name not in ("episode", "duration_s", "flown_s"):
                table[name] = value
        for none in (table, flights.none):
            yield flights_of(table, none, table)
