"""Tables for the tests of the scores: one made by hand, and random ones."""

import numpy as np
import pytest

from rss_gym.eval.table import TABLE
from rss_gym.testing.metric import flights_of, random_flights

T, F = True, False

# Six encounters of 100 s, S = 120 m. The values of every metric on them are worked out in test_metrics.py.
COMMON = {"episode": range(6), "duration_s": 100.0, "planned_m": 300.0}
NONE = {
    "collision": [T, T, F, F, F, F],
    "snmac": [T, T, T, F, F, F],
    "zone": [T, T, T, T, T, F],
    "flown_s": [50, 60, 100, 100, 100, 100],
    "closest_s": [50, 60, 55, 40, 50, 45],
    "warned_s": [20, 59.5, 30, 20, 10, -1],
    "false_alerts": [0, 1, 0, 0, 0, 2],
    "missed_ticks": [0, 8, 3, 9, 0, 0],
    "sample_separation_m": [100, 119, 121, 130, 60, 150],
    "sample_range_m": [104, 125, 110, 131, 150, 140],
}
POLICY = {
    "collision": [T, F, F, F, T, F],
    "snmac": [T, F, T, F, T, F],
    "zone": [T, T, T, T, T, F],
    "min_separation_m": [3, 30, 12, 60, 2, 120],
    "flown_s": [40, 100, 100, 100, 70, 100],
    "closest_s": [40, 20, 21, 22, 70, 23],
    "deviation_mean_m": [10, 5, 2, 1, 20, 0],
    "deviation_max_m": [30, 12, 4, 2, 150, 1],
    "manoeuvre_m": [9, 20, 2, 3, 3.5, 8],
    "flown_m": [100, 330, 300, 303, 200, 300],
    "deviation_end_m": [30, 12, 9.9, 10, 40, 0],
    "zone_severity": [0.3, 0.2, 0.4, 0.1, 0.5, 0],
    "cost_m": [10_110, 5, 102, 1, 10_120, 0],
    "warned_s": [30, -1, 40, 20, 10, -1],
    "fault": [F, F, F, T, F, F],
}
REFERENCE = {"collision": [F, F, T, F, F, F]}


def table_of(columns):
    """A TABLE with these columns, the others zero."""
    out = np.zeros(len(columns["episode"]), TABLE)
    for name, values in columns.items():
        out[name] = values
    return out


@pytest.fixture
def by_hand():
    """The six encounters above."""
    return flights_of(*(table_of(COMMON | columns) for columns in (POLICY, NONE, REFERENCE)))


@pytest.fixture(name="random_flights")
def random_flights_():
    """Function (n, seed=0) -> n random encounters with a policy, `none` and a reference."""
    return random_flights


@pytest.fixture
def make_flights():
    """Function (table, none, reference=None) -> Flights."""
    return flights_of


@pytest.fixture
def make_table():
    """Function (columns) -> TABLE, the columns not given zero."""
    return table_of
