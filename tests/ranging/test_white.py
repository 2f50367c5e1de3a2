"""The EKF that takes all noise as white, against filterpy with one state."""

import math

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.ranging import coloured, white

FLOOR_M = 0.3
OFFSET_DBM = -35.0


def h(d, gamma):
    return OFFSET_DBM - 10.0 * gamma * np.log10(d)


@pytest.mark.parametrize("seed", range(5))
def test_sequences_equal_filterpy(seed):
    rng = np.random.default_rng(seed)
    gamma, noise = rng.uniform(1.5, 4.0), rng.uniform(0.5, 30.0)
    d, p_dd = 160.0, 3600.0
    ekf = ExtendedKalmanFilter(dim_x=1, dim_z=1)
    ekf.x, ekf.P, ekf.R, ekf.B = np.array([d]), np.array([[p_dd]]), np.array([[noise]]), np.array([1.0])
    true_d = 150.0
    for _ in range(500):
        psi, process = rng.uniform(-0.8, 0.8), 10.0 ** rng.uniform(-2, 1.5)
        true_d = max(abs(true_d - 0.4), 1.0)
        rss = h(true_d, gamma) + math.sqrt(noise) * rng.standard_normal()
        d, p_dd = white.predict(d, p_dd, psi, process)
        d = max(d, FLOOR_M)
        d, p_dd = white.update(d, p_dd, rss, OFFSET_DBM, gamma, noise, FLOOR_M)
        ekf.Q = np.array([[process]])
        ekf.predict(u=psi)
        ekf.x[0] = max(ekf.x[0], FLOOR_M)
        ekf.update(
            np.array([rss]),
            lambda x: np.array([[-10.0 * gamma / (x[0] * np.log(10.0))]]),
            lambda x: np.array([h(x[0], gamma)]),
        )
        ekf.x[0] = max(ekf.x[0], FLOOR_M)
        assert d == pytest.approx(ekf.x[0], rel=1e-9)
        assert p_dd == pytest.approx(ekf.P[0, 0], rel=1e-9)


@given(
    st.floats(FLOOR_M, 1e4), st.floats(1e-6, 1e6), st.floats(1.0, 8.0), st.floats(1e-6, 800.0), st.floats(-60.0, 60.0)
)
def test_update_shrinks_the_variance_and_keeps_the_floor(d, p_dd, gamma, noise, surprise):
    out, variance = white.update(d, p_dd, h(d, gamma) + surprise, OFFSET_DBM, gamma, noise, FLOOR_M)
    assert out >= FLOOR_M
    assert 0.0 < variance <= p_dd * (1.0 + 1e-9)
    slope = -10.0 * gamma / (d * math.log(10.0))
    assert variance == pytest.approx(1.0 / (1.0 / p_dd + slope * slope / noise), rel=1e-6)  # information form


@given(st.floats(1.0, 500.0), st.floats(0.1, 1e4), st.floats(-20.0, 20.0))
def test_it_is_the_coloured_filter_without_coloured_noise(d, p_dd, surprise):
    rss = h(d, 2.7) + surprise
    both = coloured.update(d, 0.0, p_dd, 0.0, 0.0, rss, OFFSET_DBM, 2.7, 4.0, FLOOR_M)
    alone = white.update(d, p_dd, rss, OFFSET_DBM, 2.7, 4.0, FLOOR_M)
    assert alone == pytest.approx((both[0], both[2]), rel=1e-12)
    assert both[1] == both[3] == both[4] == 0.0
