"""Least squares on one sample: the inverse of the path loss and its first-order variance."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.ranging.inverse import invert

FLOOR_M, CEILING_M = 0.3, 1000.0


@given(st.floats(FLOOR_M, CEILING_M), st.floats(1.0, 8.0), st.floats(-150.0, 60.0), st.floats(1e-6, 800.0))
def test_inverse_of_the_path_loss(d, gamma, offset, noise):
    out, variance = invert(offset - 10.0 * gamma * math.log10(d), offset, gamma, noise, FLOOR_M, CEILING_M)
    assert out == pytest.approx(d, rel=1e-11)
    assert variance == pytest.approx(noise * (d * math.log(10.0) / (10.0 * gamma)) ** 2, rel=1e-9)


@given(st.floats(-1e4, 1e4))
def test_limits(rss):
    out, variance = invert(rss, -35.0, 2.7, 8.0, FLOOR_M, CEILING_M)
    assert FLOOR_M <= out <= CEILING_M
    assert 0.0 < variance < math.inf


def test_it_minimises_the_squared_error_of_one_sample():
    grid = np.linspace(1.0, 300.0, 299_001)
    for rss in (-60.0, -77.7, -95.0):
        best = grid[np.argmin((rss - (-35.0 - 27.0 * np.log10(grid))) ** 2)]
        assert invert(rss, -35.0, 2.7, 8.0, FLOOR_M, CEILING_M)[0] == pytest.approx(best, abs=0.001)


def test_variance_is_the_scatter_for_small_noise():
    """20,000 samples with 0.1 dB of noise: standard deviation within 2 % (its standard error is 0.5 %)."""
    rng = np.random.default_rng(0)
    rss = -35.0 - 27.0 * 2.0 + 0.1 * rng.standard_normal(20_000)
    ranges = np.array([invert(x, -35.0, 2.7, 0.01, FLOOR_M, CEILING_M)[0] for x in rss])
    stated = math.sqrt(invert(-89.0, -35.0, 2.7, 0.01, FLOOR_M, CEILING_M)[1])
    assert ranges.std() == pytest.approx(stated, rel=0.02)
    # Independent of the error's size: 10 dB of path loss per factor 10^(1 / gamma).
    assert invert(-99.0, -35.0, 2.7, 0.01, FLOOR_M, CEILING_M)[0] == pytest.approx(
        100.0 * 10.0 ** (1.0 / 2.7), rel=1e-12
    )
