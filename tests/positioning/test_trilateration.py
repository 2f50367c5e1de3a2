"""Trilateration (1): exact without noise, and with noise against Monte Carlo and SciPy's least squares."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares

from rss_gym.params import Params
from rss_gym.positioning.trilateration import trilaterate
from rss_gym.state import config

NODES = config(Params())[0]["nodes_m"]
TRIPLES = [tuple(j for j in range(4) if j != left_out) for left_out in range(4)]
STEPS = 3  # as in the world
COORDINATES_M = st.floats(-250.0, 250.0)


def _nodes(triple):
    return tuple(np.ascontiguousarray(NODES[j]) for j in triple)


def _ranges(triple, position):
    return np.linalg.norm(NODES[list(triple)] - position, axis=1)


@given(st.sampled_from(TRIPLES), COORDINATES_M, COORDINATES_M, st.floats(0.0, 120.0), st.floats(0.01, 1e4))
def test_exact_without_noise(triple, x, y, altitude, variance):
    ranges = _ranges(triple, np.array([x, y, altitude]))
    for steps in (0, STEPS):
        out_x, out_y, std = trilaterate(_nodes(triple), tuple(ranges), (variance,) * 3, altitude, steps)
        assert (out_x, out_y) == pytest.approx((x, y), abs=1e-7)
        assert np.isfinite(std)
        assert std > 0.0


@given(
    st.sampled_from(TRIPLES),
    st.tuples(*[st.floats(0.3, 1000.0)] * 3),
    st.tuples(*[st.floats(1e-3, 1e6)] * 3),
    st.floats(-20.0, 120.0),
)
def test_inconsistent_ranges_give_finite_numbers(triple, ranges, variances, altitude):
    assert np.isfinite(trilaterate(_nodes(triple), ranges, variances, altitude, STEPS)).all()


def test_over_a_node():
    """Straight above a node its range says nothing about x and y; the other two still place the aircraft."""
    for triple in TRIPLES:
        for altitude in (NODES[triple[0], 2], NODES[triple[0], 2] + 30.0):
            position = np.array([NODES[triple[0], 0], NODES[triple[0], 1], altitude])
            x, y, std = trilaterate(_nodes(triple), tuple(_ranges(triple, position)), (1.0,) * 3, altitude, STEPS)
            assert (x, y) == pytest.approx(tuple(position[:2]), abs=1e-6)
            assert np.isfinite(std)


@pytest.mark.parametrize("position", [(0.0, 0.0, 20.0), (30.0, -20.0, 20.0), (-50.0, 50.0, 35.0), (90.0, 40.0, 20.0)])
@pytest.mark.parametrize("triple", TRIPLES)
def test_std_is_the_scatter_of_the_solution(position, triple):
    """2,000 noisy fixes at 0.5-1.5 m range error: rms error per axis equals the stated std within 8 %."""
    rng = np.random.default_rng(1)
    position, nodes = np.array(position), _nodes(triple)
    stds = np.array([0.5, 1.0, 1.5])
    exact = _ranges(triple, position)
    noisy = exact + stds * rng.standard_normal((2000, 3))
    fixes = np.array([trilaterate(nodes, tuple(row), tuple(stds**2), position[2], STEPS) for row in noisy])
    rms = np.sqrt(np.mean((fixes[:, :2] - position[:2]) ** 2))
    # The standard error of an rms over 2 x 2,000 correlated errors is 1.6 %.
    assert fixes[:, 2].mean() == pytest.approx(rms, rel=0.08)
    # Cramer-Rao: sqrt of half the trace of (H^T W H)^-1.
    h = (position - NODES[list(triple)])[:, :2] / exact[:, None]
    bound = np.sqrt(0.5 * np.trace(np.linalg.inv(h.T @ np.diag(1.0 / stds**2) @ h)))
    assert fixes[:, 2].mean() == pytest.approx(bound, rel=0.03)


def test_weighted_least_squares_of_scipy():
    """The world's choice of nodes, ranges 2 % wrong: three steps from the closed form land on SciPy's minimum."""
    rng = np.random.default_rng(3)
    gaps = []
    for _ in range(300):
        position = np.array([*rng.uniform(-120.0, 120.0, 2), 20.0])
        ranges = np.linalg.norm(NODES - position, axis=1) * (1.0 + 0.02 * rng.standard_normal(4))
        triple = [j for j in range(4) if j != np.argmax(ranges)]
        ranges, stds = ranges[triple], 0.02 * ranges[triple]

        def residuals(xy, triple=triple, ranges=ranges, stds=stds):
            return (_ranges(triple, np.array([*xy, 20.0])) - ranges) / stds

        best = least_squares(residuals, position[:2], xtol=1e-12, ftol=1e-12, gtol=1e-12)
        x, y, std = trilaterate(_nodes(triple), tuple(ranges), tuple(stds**2), 20.0, STEPS)
        gaps.append(np.hypot(x - best.x[0], y - best.x[1]) / std)
        assert np.sum(residuals((x, y)) ** 2) <= 2.0 * best.cost + 0.02
    assert np.median(gaps) < 1e-4
    assert np.max(gaps) < 0.15


def test_more_steps_converge_to_the_minimum():
    """Damping slows Gauss-Newton but does not move its fixed point: after 30 steps it is SciPy's to 1e-5 m."""
    rng = np.random.default_rng(4)
    triple, position = TRIPLES[1], np.array([20.0, 35.0, 20.0])
    for _ in range(20):
        ranges = _ranges(triple, position) + 5.0 * rng.standard_normal(3)

        def residuals(xy, ranges=ranges):
            return _ranges(triple, np.array([*xy, 20.0])) - ranges

        best = least_squares(residuals, position[:2], xtol=1e-14, ftol=1e-14, gtol=1e-14)
        x, y, _ = trilaterate(_nodes(triple), tuple(ranges), (1.0,) * 3, 20.0, 30)
        assert (x, y) == pytest.approx(tuple(best.x), abs=1e-5)


@pytest.mark.slow
def test_the_minimum_for_ten_thousand_random_geometries():
    """Nodes anywhere, ranges 2 % or 30 % wrong: no descent of SciPy from several beginnings ends lower."""
    rng = np.random.default_rng(7)
    count, lower = 10_000, 0
    for k in range(count):
        nodes = np.column_stack([rng.uniform(-200.0, 200.0, (3, 2)), rng.uniform(0.0, 15.0, 3)])
        position = np.array([*rng.uniform(-250.0, 250.0, 2), rng.uniform(5.0, 60.0)])
        exact = np.linalg.norm(nodes - position, axis=1)
        ranges = np.maximum(exact * (1.0 + rng.choice([0.02, 0.3]) * rng.standard_normal(3)), 0.3)
        stds = (0.1 + 0.02 * ranges) * rng.uniform(0.5, 2.0, 3)

        def residuals(xy, nodes=nodes, ranges=ranges, stds=stds, altitude=position[2]):
            return (np.linalg.norm(nodes - [*xy, altitude], axis=1) - ranges) / stds

        x, y, _ = trilaterate(tuple(nodes), tuple(ranges), tuple(stds**2), position[2], STEPS)
        ours = float(np.sum(residuals((x, y)) ** 2))
        if k % 20 == 0:  # SciPy takes its time: from three beginnings in one of twenty
            starts = [position[:2], *(nodes[:, :2].mean(axis=0) + rng.normal(0.0, 200.0, (2, 2)))]
            assert ours <= 2.0 * min(least_squares(residuals, start).cost for start in starts) * (1.0 + 1e-6) + 1e-9
        # A grid over the area, whose best point is refined by nobody, must nowhere lie below.
        grid = rng.uniform(-500.0, 500.0, (40, 2))
        apart = np.linalg.norm(np.column_stack([grid, np.full(40, position[2])])[:, None] - nodes, axis=2)
        lower += bool((np.sum(((apart - ranges) / stds) ** 2, axis=1) < ours * (1.0 - 1e-9)).any())
    assert lower == 0
