"""Path loss (2)-(3) against plain NumPy, finite differences and its own inverse."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.physics import path_loss

GAMMAS = st.floats(1.0, 8.0)
OFFSETS_DBM = st.floats(-150.0, 60.0)
DISTANCES_M = st.floats(0.1, 1e4)


def test_received_power_is_2_in_numpy():
    rng = np.random.default_rng(2)
    for offset, gamma, d in zip(
        rng.uniform(-150, 60, 2000), rng.uniform(1, 8, 2000), 10 ** rng.uniform(-1, 4, 2000), strict=True
    ):
        expected = offset - 10.0 * gamma * np.log10(d)
        assert path_loss.received_dbm(offset, gamma, d * d) == pytest.approx(expected, rel=1e-13, abs=1e-11)


def test_known_values():
    assert path_loss.received_dbm(-35.0, 2.7, 1.0) == -35.0  # d_0 = 1 m
    assert path_loss.received_dbm(-35.0, 2.7, 100.0**2) == pytest.approx(-89.0, abs=1e-12)
    # Half the power is 3.01 dB, which free space loses over a factor sqrt 2.
    assert path_loss.received_dbm(0.0, 2.0, 2.0) == pytest.approx(-10.0 * math.log10(2.0), abs=1e-14)
    assert math.log(10.0) == path_loss.LN10


@given(OFFSETS_DBM, GAMMAS, DISTANCES_M)
def test_distance_inverts_received_power(offset, gamma, d):
    assert path_loss.distance_m(offset, gamma, path_loss.received_dbm(offset, gamma, d * d)) == pytest.approx(
        d, rel=1e-11
    )


@given(OFFSETS_DBM, GAMMAS, st.floats(-40.0, 100.0))
def test_received_power_inverts_distance(offset, gamma, loss_db):
    d = path_loss.distance_m(offset, gamma, offset - loss_db)
    assert path_loss.received_dbm(offset, gamma, d * d) == pytest.approx(offset - loss_db, abs=1e-10)


@given(GAMMAS, DISTANCES_M)
def test_slope_is_the_derivative(gamma, d):
    step = 1e-5 * d
    difference = path_loss.received_dbm(0.0, gamma, (d + step) ** 2) - path_loss.received_dbm(
        0.0, gamma, (d - step) ** 2
    )
    slope = path_loss.slope_db_pm(gamma, d)
    assert slope == pytest.approx(difference / (2.0 * step), rel=1e-6)
    assert slope == pytest.approx(-10.0 * gamma / (d * np.log(10.0)), rel=1e-14)
    assert slope < 0.0


@given(OFFSETS_DBM, GAMMAS, DISTANCES_M, st.floats(1.001, 10.0))
def test_power_falls_with_distance(offset, gamma, d, factor):
    near = path_loss.received_dbm(offset, gamma, d * d)
    assert path_loss.received_dbm(offset, gamma, (factor * d) ** 2) < near


@given(st.floats(-200.0, 50.0), st.floats(0.01, 20.0))
def test_quantise_rounds_to_the_nearest_multiple(rss, step):
    value = path_loss.quantise(rss, step)
    assert abs(value - rss) <= 0.5 * step * (1.0 + 1e-9) + 1e-12
    assert value / step == pytest.approx(round(value / step), abs=1e-9)
    assert path_loss.quantise(value, step) == pytest.approx(value, abs=1e-9)


def test_quantise_zero_step_and_ties():
    assert path_loss.quantise(-71.234, 0.0) == -71.234
    assert [path_loss.quantise(x, 1.0) for x in (-70.5, -70.51, -70.49, 0.5)] == [-70.0, -71.0, -70.0, 1.0]
