"""The value table of one intruder: its first slab against SciPy, symmetry, and one sweep against the equation."""

import numpy as np
import pytest
from scipy.stats import norm

from rss_gym.avoidance.qmdp import ACTIONS, SPREADS, solve, value

PRICES_M, LIMITS_M = np.array([100.0, 10_000.0]), np.array([15.24, 4.5])
SPEED_MPS, DRIFT_MPS, FLIGHT_S, STEP_S, STEPS, HALF_M, CELL_M = 3.0, 0.3, 60.0, 0.5, 12, 30.0, 1.0
AXIS = np.arange(-HALF_M, HALF_M + CELL_M, CELL_M)


@pytest.fixture(scope="module")
def table():
    return solve(PRICES_M, LIMITS_M, SPEED_MPS, DRIFT_MPS, FLIGHT_S, STEP_S, STEPS, HALF_M, CELL_M)


@pytest.mark.parametrize("level", range(SPREADS))
def test_at_the_closest_approach_the_price_is_that_of_a_normal_miss_and_of_the_way_back(table, level):
    miss, std = AXIS[None, :] - AXIS[:, None], 2.0**level
    expected = AXIS[:, None] ** 2 / (2.0 * SPEED_MPS * FLIGHT_S)
    for price, limit in zip(PRICES_M, LIMITS_M, strict=True):
        expected = expected + price * (norm.cdf(limit, miss, std) - norm.cdf(-limit, miss, std))
    np.testing.assert_allclose(table[level, 0], expected, rtol=1e-9, atol=1e-8)


def test_a_sweep_is_the_equation_where_the_actions_fall_on_the_grid():
    """A cell of u dt / 4, so that every candidate is a node; without drift the mean is V itself."""
    cell = SPEED_MPS * STEP_S / (ACTIONS // 2)
    found = solve(PRICES_M, LIMITS_M, SPEED_MPS, 0.0, FLIGHT_S, STEP_S, 1, 12.0, cell)
    w = np.arange(found.shape[2]) * cell - 12.0
    for i in range(ACTIONS, len(w) - ACTIONS):
        reached = np.arange(i - ACTIONS // 2, i + ACTIONS // 2 + 1)
        expected = np.min(np.abs(w[reached])[:, None] * STEP_S / FLIGHT_S + found[0, 0, reached], axis=0)
        np.testing.assert_allclose(found[0, 1, i], expected, rtol=1e-9, atol=1e-9)


def test_the_mirror_image_has_the_same_value_and_more_time_costs_no_more(table):
    np.testing.assert_allclose(table, table[:, :, ::-1, ::-1], rtol=1e-9, atol=1e-9)
    on_path = table[:, :, len(AXIS) // 2]
    assert np.all(table >= 0.0) and np.all(on_path[1, 1:, 30] <= on_path[1, :-1, 30])


def test_a_value_is_read_at_the_nodes_and_held_beyond_the_edges(table):
    read = value(table, 4.0, 3 * STEP_S, 5.0, -7.0, STEP_S, HALF_M, CELL_M)
    assert read == pytest.approx(table[2, 3, 35, 23], rel=1e-12)
    far = value(table, 100.0, 1e3, 1e3, -1e3, STEP_S, HALF_M, CELL_M)
    assert far == pytest.approx(table[-1, -1, -1, 0], rel=1e-12)
    between = value(table, 2.0, 0.25, 0.5, 0.0, STEP_S, HALF_M, CELL_M)
    assert between == pytest.approx(np.mean(table[1, :2, 30:32, 30]), rel=1e-12)
