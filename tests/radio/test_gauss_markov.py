"""Gauss-Markov noise (7)-(11): the printed double sum of (9), added up term by term."""

import math
import sys

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rss_gym.params import ParamsError
from rss_gym.radio import GaussMarkov

VARIANCES = st.floats(1e-6, 400.0)
TIMES_S = st.floats(0.01, 3600.0)
PERIODS_S = st.floats(0.01, 1.0)


def double_sum_9(a, sigma_w2, m, n, initial):
    """(9): E[w2(m-i+1) w2(n-j+1)] is sigma_w2^2 where the two indices agree, else 0.

    The term a^(i+j) sigma_w2^2 is taken as a^(i+j-2) (a sigma_w2)^2: sigma_w2 grows as 1 / a, and a^(i+j) alone
    would underflow where the term does not.
    """
    driven = sum(
        a ** (i + j - 2) * (a * sigma_w2) ** 2
        for i in range(1, m + 1)
        for j in range(1, n + 1)
        if m - i + 1 == n - j + 1
    )
    return a ** (m + n) * initial + driven


@given(VARIANCES, TIMES_S, PERIODS_S, st.integers(0, 12), st.integers(0, 12), st.floats(0.0, 400.0))
@example(1.0, 0.01, 0.875, 1, 8, 0.0)  # e^-612.5: a^9 is below the least float
def test_covariance_is_the_double_sum_of_9(variance, tc_s, period_s, m, n, initial):
    noise = GaussMarkov(variance, tc_s)
    expected = double_sum_9(noise.decay(period_s), noise.driving_std_db(period_s), m, n, initial)
    found = noise.covariance(m, n, period_s, initial)
    # With x = Delta / Tc, rounding changes a = e^-x by (1 + x) eps, so a^k, k <= m + n, by k times that, and 1 - a^2,
    # which is 2 x for small x, by eps / x. Each happens a few times, hence the factor 4.
    x = period_s / tc_s
    relative = 4.0 * sys.float_info.epsilon * ((m + n + 2) * (1.0 + x) + 1.0 / x)
    # A power below the least normal float has no digits to rely on; at most m + n + 1 of them, times a variance.
    absolute = (m + n + 1) * max(variance, initial) * sys.float_info.min
    assert found == pytest.approx(expected, rel=relative, abs=absolute)
    assert found == noise.covariance(n, m, period_s, initial)


def test_covariance_broadcasts_and_is_11_far_from_the_start():
    noise, step = GaussMarkov(4.0, 2.0), np.arange(1000, 1020)
    matrix = noise.covariance(step[:, None], step, 0.1, 0.0)
    lag_s = 0.1 * np.abs(step[:, None] - step)
    np.testing.assert_allclose(matrix, noise.autocovariance(lag_s), rtol=1e-12)
    # As printed: sigma_w2^2 e^{lambda Delta (n - m + 2)} / (1 - e^{2 lambda Delta}).
    printed = noise.driving_std_db(0.1) ** 2 * np.exp(-0.05 * (lag_s / 0.1 + 2)) / (1.0 - math.exp(-0.1))
    np.testing.assert_allclose(matrix, printed, rtol=1e-12)


@given(VARIANCES, TIMES_S, PERIODS_S)
def test_lambda_and_sigma_give_the_process_back(variance, tc_s, period_s):
    noise = GaussMarkov(variance, tc_s)
    again = GaussMarkov.of_lambda(noise.lambda_ps, noise.driving_std_db(period_s), period_s)
    assert again.variance_db2 == pytest.approx(variance, rel=1e-8)
    assert again.tc_s == pytest.approx(tc_s, rel=1e-15)


@pytest.mark.parametrize("lambda_ps", [0.0, 0.3, math.nan, -math.inf, True, "fast"])
def test_lambda_that_diverges_is_refused(lambda_ps):
    with pytest.raises(ParamsError, match="lambda_ps"):
        GaussMarkov.of_lambda(lambda_ps, 1.0, 0.1)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: GaussMarkov(0.0, 2.0), "variance_db2"),
        (lambda: GaussMarkov(math.nan, 2.0), "variance_db2"),
        (lambda: GaussMarkov(4.0, -1.0), "tc_s"),
        (lambda: GaussMarkov(4.0, math.inf), "tc_s"),
        (lambda: GaussMarkov(4.0, "2"), "tc_s"),
        (lambda: GaussMarkov(4.0, 0.01).driving_std_db(10.0), "period_s"),
        (lambda: GaussMarkov(4.0, 2.0).decay(0.0), "period_s"),
        (lambda: GaussMarkov.of_lambda(-100.0, 1.0, 10.0), "lambda_ps"),
        (lambda: GaussMarkov(4.0, 2.0).covariance(-1, 2, 0.1, 0.0), "m and n"),
        (lambda: GaussMarkov(4.0, 2.0).covariance(1.5, 2, 0.1, 0.0), "m and n"),
        (lambda: GaussMarkov(4.0, 2.0).covariance(1, 2, 0.1, math.nan), "initial_variance_db2"),
        (lambda: GaussMarkov(4.0, 2.0).covariance(1, 2, 0.1, "4"), "initial_variance_db2"),
        (lambda: GaussMarkov(4.0, 2.0).covariance([1, 2], [1, 2, 3], 0.1, 0.0), "broadcast"),
        (lambda: GaussMarkov(4.0, 2.0).autocovariance("1"), "lag_s"),
        (lambda: GaussMarkov(4.0, 2.0).autocovariance([0.0, math.nan]), "lag_s must be finite, got nan at element 1"),
    ],
)
def test_bad_input(call, says):
    with pytest.raises(ParamsError, match=says):
        call()
