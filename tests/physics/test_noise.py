"""Gauss-Markov noise against (8)-(11) of the paper: the exact algebra, and long simulations."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.jit import kernel
from rss_gym.physics.noise import decay, driving_std, gauss_markov

PERIODS_S = st.floats(0.01, 10.0)
TIMES_S = st.floats(0.01, 3600.0)
VARIANCES = st.floats(1e-6, 400.0)


@kernel
def _simulate(x, a, sigma_w2, normals, out):
    """Path of (8) from `x`."""
    for n in range(len(normals)):
        x = gauss_markov(x, a, sigma_w2, normals[n])
        out[n] = x


def _autocorrelation_11(variance_w2, lambda_delta, lag):
    """(11) as printed: R(m, n) = sigma_w2^2 e^{lambda Delta (n - m + 2)} / (1 - e^{2 lambda Delta})."""
    return variance_w2 * math.exp(lambda_delta * (lag + 2)) / (1.0 - math.exp(2.0 * lambda_delta))


@given(PERIODS_S, TIMES_S)
def test_decay_is_the_exponential_of_the_correlation_time(period_s, time_s):
    a = decay(period_s, time_s)
    assert a == pytest.approx(math.exp(-period_s / time_s), rel=1e-15)
    assert 0.0 <= a < 1.0
    # Two periods decay as one of twice the length.
    assert a * a == pytest.approx(decay(2.0 * period_s, time_s), rel=1e-13, abs=1e-300)


@given(VARIANCES, st.floats(0.01, 1.0), st.floats(0.05, 3600.0), st.integers(0, 50))
def test_driving_std_gives_the_stationary_variance_of_11(variance, period_s, time_s, lag):
    a = decay(period_s, time_s)
    drive = driving_std(variance, a)
    # The stationary variance of (8) is the fixed point of S = a^2 (S + sigma_w2^2).
    assert a * a * (variance + drive * drive) == pytest.approx(variance, rel=1e-12)
    # (11) at any lag is S a^lag. Its own 1 - a^2 loses digits as a approaches 1.
    expected = variance * math.exp(-lag * period_s / time_s)
    assert _autocorrelation_11(drive * drive, -period_s / time_s, lag) == pytest.approx(expected, rel=1e-9)


@given(st.floats(-50.0, 50.0), st.floats(0.01, 1.0), st.floats(0.0, 20.0), st.floats(-6.0, 6.0))
def test_one_step_is_8(x, a, sigma_w2, normal):
    assert gauss_markov(x, a, sigma_w2, normal) == pytest.approx(a * x + a * sigma_w2 * normal, rel=1e-15, abs=1e-14)


@given(st.floats(-50.0, 50.0), st.floats(0.01, 1.0))
def test_without_noise_it_decays(x, a):
    assert abs(gauss_markov(x, a, 3.0, 0.0)) <= abs(x)


def test_sums_of_9_and_10_agree_with_the_recursion():
    """The weights of w2(1..m) in phi(m) are e^{lambda Delta i}: propagate unit impulses through the recursion."""
    a, m = decay(0.1, 2.0), 40
    weights = []
    for impulse in range(1, m + 1):
        x = 0.0
        for n in range(1, m + 1):
            x = gauss_markov(x, a, 1.0, 1.0 if n == impulse else 0.0)
        weights.append(x)
    expected = [a ** (m - impulse + 1) for impulse in range(1, m + 1)]
    np.testing.assert_allclose(weights, expected, rtol=1e-12)
    # (10) without the initial term, and its limit (11).
    drive = driving_std(4.0, a)
    ten = drive * drive * sum(w * w for w in weights)
    assert ten == pytest.approx(4.0 * (1.0 - a ** (2 * m)), rel=1e-12)


@pytest.mark.parametrize(("variance", "period_s", "time_s"), [(4.0, 0.1, 2.0), (20.9, 0.1, 6.7), (0.04, 0.5, 3.0)])
def test_simulated_moments_match_11(variance, period_s, time_s):
    """Sample autocovariances of 400,000 steps lie within 4.5 standard errors (Bartlett's formula)."""
    steps, a = 400_000, decay(period_s, time_s)
    drive = driving_std(variance, a)
    rng = np.random.default_rng(11)
    x = np.empty(steps)
    _simulate(math.sqrt(variance) * rng.standard_normal(), a, drive, rng.standard_normal(steps), x)
    assert abs(x.mean()) < 4.5 * math.sqrt(variance * (1.0 + a) / (1.0 - a) / steps)
    one_time = round(time_s / period_s)
    for lag in (0, 1, 5, one_time, 2 * one_time):
        estimate = float(np.mean(x[: steps - lag] * x[lag:]))
        # Var of the sample autocovariance of an AR(1): S^2 / n times sum of r_k^2 + r_{k+lag} r_{k-lag} over k.
        square, power = a * a, a ** (2 * lag)
        spread = (1.0 + square) / (1.0 - square) * (1.0 + power) + 2.0 * lag * power
        error = variance * math.sqrt(spread / (steps - lag))
        assert abs(estimate - _autocorrelation_11(drive * drive, -period_s / time_s, lag)) < 4.5 * error, lag


def test_an_ensemble_stays_stationary():
    """20,000 paths started from the stationary law keep variance S and correlation a^lag at every tick (5 errors)."""
    paths, ticks, variance = 20_000, 60, 4.0
    a = decay(0.1, 2.0)
    drive = driving_std(variance, a)
    rng = np.random.default_rng(8)
    first = math.sqrt(variance) * rng.standard_normal(paths)
    x = first
    for tick in range(1, ticks + 1):
        x = a * x + a * drive * rng.standard_normal(paths)
        assert abs(np.var(x) - variance) < 5.0 * variance * math.sqrt(2.0 / paths)
        r = a**tick
        assert abs(np.mean(x * first) - variance * r) < 5.0 * variance * math.sqrt((1.0 + r * r) / paths)
