"""The Allan variance against allantools, a quadratic form, long simulations, and the coverage of its interval."""

import allantools
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, chi2

from rss_gym.params import ParamsError, load_channel
from rss_gym.radio import GaussMarkov, allan_curve, allan_model, simulate
from rss_gym.radio.allan import allan_covariance

PERIOD_S = 0.1


def noises(white, variance, tc_s, records, n, seed):
    """Records of white plus Gauss-Markov noise: a simulated link at one metre, less its offset."""
    channel = load_channel("clean").replace(
        offset_dbm=0.0, white_variance_db2=white, coloured_variance_db2=variance, coloured_tc_s=tc_s,
        path_loss_wander=0.0, quantisation_db=0.0, packet_loss=0.0,
    )  # fmt: skip
    return simulate(np.ones((records, n)), PERIOD_S, channel, seed).rss_dbm


def filters(n, m):
    """Rows: the differences of two adjacent means of m samples, over the root of two."""
    rows = np.zeros((n + 1 - 2 * m, n))
    for j, row in enumerate(rows):
        row[j : j + m], row[j + m : j + 2 * m] = -1.0 / m, 1.0 / m
    return rows / np.sqrt(2.0)


def matrix(n, white, variance, tc_s):
    """Covariance of the samples."""
    k = np.arange(n)
    return white * np.eye(n) + variance * np.exp(-PERIOD_S * np.abs(k[:, None] - k) / tc_s)


# -- (4) --------------------------------------------------------------------------------------------------------------


@given(st.integers(0, 2**32 - 1), st.integers(6, 400), st.floats(-90.0, 90.0), st.floats(0.01, 10.0))
def test_equals_allantools(seed, n, mean, period_s):
    x = mean + np.random.default_rng(seed).normal(0.0, 3.0, n).cumsum()
    curve = allan_curve(x, period_s)
    # allantools leaves out clusters that allow a single difference.
    taus, deviation, _, _ = allantools.oadev(x, rate=1.0 / period_s, data_type="freq", taus=curve.tau_s)
    np.testing.assert_allclose(curve.tau_s, taus, rtol=1e-12)
    np.testing.assert_allclose(curve.variance_db2, deviation**2, rtol=1e-12)
    np.testing.assert_array_equal(curve.differences, n + 1 - 2 * curve.clusters)


def test_equals_the_definition_and_pools_records():
    rng = np.random.default_rng(4)
    records = [rng.normal(size=n) for n in (40, 9, 25)]
    curve = allan_curve(records, PERIOD_S, [1, 3, 5, 12])
    for m, value, count in zip(curve.clusters, curve.variance_db2, curve.differences, strict=True):
        squares = np.concatenate([(filters(len(x), m) @ x) ** 2 for x in records if len(x) >= 2 * m])
        assert len(squares) == count
        assert value == pytest.approx(squares.mean(), rel=1e-12)
    assert curve.lengths == (40, 9, 25)


def test_mean_does_not_matter():
    x = np.random.default_rng(5).normal(size=300)
    np.testing.assert_allclose(
        allan_curve(x + 1e6, PERIOD_S).variance_db2, allan_curve(x, PERIOD_S).variance_db2, rtol=1e-8
    )


@pytest.mark.parametrize(("n", "last"), [(3, 1), (5, 1), (6, 2), (600, 128), (6000, 1024)])
def test_default_clusters_are_octaves_to_a_third(n, last):
    clusters = allan_curve(np.arange(float(n)), PERIOD_S).clusters
    np.testing.assert_array_equal(clusters, 2 ** np.arange(len(clusters)))
    assert clusters[-1] == last


# -- the model --------------------------------------------------------------------------------------------------------


@given(st.integers(1, 12), st.floats(0.0, 400.0), st.floats(1e-3, 400.0), st.floats(0.01, 1000.0))
def test_model_is_the_quadratic_form(m, white, variance, tc_s):
    a = filters(2 * m, m)[0]
    # Terms that add up to nothing are left out before they are summed: e^-x - 1 in place of e^-x.
    k = np.arange(2 * m)
    less = variance * np.expm1(-PERIOD_S * np.abs(k[:, None] - k) / tc_s)
    expected = white * (a @ a) + a @ less @ a
    found = allan_model([m], white, GaussMarkov(variance, tc_s), PERIOD_S)
    assert found == pytest.approx([expected], rel=1e-11)


def test_model_in_the_limits():
    m = 2 ** np.arange(12)
    # White at periods far beyond Tc; S x (2 m^2 + 1) / (3 m), a random walk, far below it.
    np.testing.assert_allclose(allan_model(m, 0.0, GaussMarkov(3.0, 1e-6), 10.0), 3.0 / m, rtol=1e-14)
    walk = allan_model(m, 0.0, GaussMarkov(3.0, 1e9), 1e-3)
    np.testing.assert_allclose(walk, 3.0 * 1e-12 * (2.0 * m * m + 1.0) / (3.0 * m), rtol=1e-8)


@pytest.mark.parametrize(("white", "variance", "tc_s"), [(4.0, 4.0, 2.0), (17.6, 7.5, 3.5), (0.0, 9.0, 0.3)])
def test_long_simulation_shows_the_model(white, variance, tc_s):
    """400,000 samples in 4 records: every point within 4.5 of its exact standard errors."""
    curve = allan_curve(list(noises(white, variance, tc_s, 4, 100_000, 11)), PERIOD_S, 2 ** np.arange(12))
    noise = GaussMarkov(variance, tc_s)
    errors = np.sqrt(2.0 / curve.freedom)  # of a chi-square variable; too large rather than too small
    ratio = curve.variance_db2 / allan_model(curve.clusters, white, noise, PERIOD_S)
    assert (np.abs(ratio - 1.0) < 4.5 * errors).all()
    assert errors[0] < 0.004 and errors[-1] < 0.2


# -- covariance, degrees of freedom, interval -------------------------------------------------------------------------


@pytest.mark.parametrize("lengths", [(60,), (60, 41, 41, 9)])
def test_covariance_of_the_points_is_isserlis(lengths):
    """2 sum (A C B^T)^2 over all pairs, with the full matrices."""
    curve = allan_curve([np.sin(np.arange(float(n))) for n in lengths], PERIOD_S, [1, 2, 5, 16, 30])
    expected = np.zeros((5, 5))
    for n in lengths:
        rows = [filters(n, m) if 2 * m <= n else np.zeros((0, n)) for m in curve.clusters]
        c = matrix(n, 1.5, 4.0, 0.7)
        expected += np.array([[2.0 * np.sum((a @ c @ b.T) ** 2) for b in rows] for a in rows])
    expected /= np.outer(curve.differences, curve.differences)
    np.testing.assert_allclose(allan_covariance(curve, 1.5, GaussMarkov(4.0, 0.7)), expected, rtol=1e-9)


@pytest.mark.parametrize("n", [100, 600])
@pytest.mark.parametrize(
    "noise", [(4.0, 1e-6, 1.0), (4.0, 4.0, 2.0), (1e-6, 4.0, 2.0), (0.1, 4.0, 20.0), (0, 4.0, 1e4)]
)
def test_degrees_of_freedom_are_not_too_many(n, noise):
    """Below the exact 2 mean^2 / variance of the estimator (plus 6 %, the error of the published formulas)."""
    curve = allan_curve(np.sin(np.arange(float(n))), PERIOD_S)
    white, variance, tc_s = noise
    coloured = GaussMarkov(variance, tc_s)
    mean = allan_model(curve.clusters, white, coloured, PERIOD_S)
    exact = 2.0 * mean**2 / np.diag(allan_covariance(curve, white, coloured))
    assert (curve.freedom <= 1.06 * exact).all()
    assert (curve.freedom >= 0.45 * exact).all()  # half as many at worst, for white noise in the longest clusters
    if variance == 1e-6:
        assert curve.freedom[0] == pytest.approx(exact[0], rel=0.01)


def test_freedom_is_that_of_allantools():
    curve = allan_curve(np.zeros(600) + np.arange(600.0), PERIOD_S)
    published = [[allantools.edf_simple(601, m, alpha) for alpha in (0, -2)] for m in curve.clusters]
    np.testing.assert_allclose(curve.freedom, np.min(published, axis=1), rtol=1e-12)


def test_interval_is_6():
    curve = allan_curve(np.random.default_rng(1).normal(size=100), PERIOD_S)
    low, high = curve.interval(0.9)
    scaled = curve.freedom * curve.variance_db2
    np.testing.assert_allclose(low, scaled / chi2.ppf(0.95, curve.freedom), rtol=1e-10)
    np.testing.assert_allclose(high, scaled / chi2.ppf(0.05, curve.freedom), rtol=1e-10)


@pytest.mark.parametrize(("white", "variance", "tc_s"), [(4.0, 1e-6, 1.0), (4.0, 4.0, 2.0), (0.01, 4.0, 20.0)])
def test_coverage_of_the_interval(white, variance, tc_s):
    """2000 records of 200 samples, 95 %: never short (binomial, 0.1 %); at one white sample neither too long."""
    records = noises(white, variance, tc_s, 2000, 200, 3)
    truth = allan_model(2 ** np.arange(7), white, GaussMarkov(variance, tc_s), PERIOD_S)
    hits = np.zeros(7, int)
    for x in records:
        low, high = allan_curve(x, PERIOD_S).interval(0.95)
        hits += (low <= truth) & (truth <= high)
    # At the longest clusters a chi-square variable stands for a sum of few unequal ones: a percent is given to that.
    assert (hits >= binom.ppf(0.001, 2000, 0.94)).all(), hits / 2000
    if variance == 1e-6:
        assert hits[0] <= binom.ppf(0.999, 2000, 0.95), hits / 2000


# -- bad input --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (([1.0, 2.0], 0.1), "at least 3"),
        (([], 0.1), "values"),
        ((np.zeros((3, 4)), 0.1), "values"),
        (([1.0, np.nan, 2.0], 0.1), "nan at element 1"),
        ((["a", "b", "c"], 0.1), "numbers"),
        (([[1.0, 2.0, 3.0], [np.inf]], 0.1), "inf"),
        ((np.arange(9.0), 0.0), "period_s"),
        ((np.arange(9.0), "0.1"), "period_s"),
        ((np.arange(9.0), 0.1, [1, 5]), "at most half .* 4, got 5"),
        ((np.arange(9.0), 0.1, [2, 1]), "rising"),
        ((np.arange(9.0), 0.1, [0, 1]), "from 1"),
        ((np.arange(9.0), 0.1, [1.5]), "whole"),
    ],
)
def test_bad_input(arguments, says):
    with pytest.raises(ParamsError, match=says):
        allan_curve(*arguments)


def test_bad_confidence():
    with pytest.raises(ParamsError, match="confidence"):
        allan_curve(np.arange(9.0), 0.1).interval(1.0)
