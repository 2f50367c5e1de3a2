"""The augmented EKF against filterpy, the literal (21), and a linear Kalman filter in ln d."""

import math

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter, KalmanFilter
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.params import CHANNELS, Channel, load_channel
from rss_gym.physics.noise import decay, driving_std
from rss_gym.ranging import coloured

FLOOR_M = 0.3
OFFSET_DBM = -35.0

# The ranges of params.Channel and params.Ranging, the estimator's process noise up to what a link may be given.
GAMMAS = st.floats(1.0, 8.0)
WHITE_DB2 = st.floats(1e-6, 400.0)  # records.channels keeps R above 1e-6
COLOURED_DB2 = st.floats(1e-6, 400.0)
COLOURED_TC_S = st.floats(0.05, 3600.0)
PROCESS_M2 = st.floats(1e-6, 1e6)
DISTANCES_M = st.floats(FLOOR_M, 1e4)
SURPRISES_DB = st.floats(-60.0, 60.0)


def h(d, phi, gamma):
    return OFFSET_DBM - 10.0 * gamma * np.log10(d) + phi


def jacobian(d, gamma):
    return np.array([[-10.0 * gamma / (d * np.log(10.0)), 1.0]])


def oracle(channel, tick_s, state, covariance):
    """Filterpy's EKF set up as (12)-(21)."""
    a = math.exp(-tick_s / channel.coloured_tc_s)
    ekf = ExtendedKalmanFilter(dim_x=2, dim_z=1)
    ekf.x, ekf.P = np.array(state, float), np.array(covariance, float)
    ekf.F = np.diag([1.0, a])
    ekf.B = np.array([1.0, 0.0])
    ekf.R = np.array([[channel.white_variance_db2]])
    ekf.variance_w2 = channel.coloured_variance_db2 * (1.0 - a * a) / (a * a)
    return ekf


def step(ekf, gamma, psi, process, rss):
    """One tick of filterpy, with the floor where the package has it."""
    w = np.diag([1.0, ekf.F[1, 1]])
    ekf.Q = w @ np.diag([process, ekf.variance_w2]) @ w.T
    ekf.predict(u=psi)
    ekf.x[0] = max(ekf.x[0], FLOOR_M)
    if rss is not None:
        ekf.update(np.array([rss]), lambda x: jacobian(x[0], gamma), lambda x: np.array([h(x[0], x[1], gamma)]))
        ekf.x[0] = max(ekf.x[0], FLOOR_M)


@pytest.mark.parametrize("preset", sorted(CHANNELS))
@pytest.mark.parametrize("seed", range(5))
def test_sequences_equal_filterpy(preset, seed):
    """500 ticks of a random flight with psi at some ticks and no reception at others: state and covariance to 1e-9."""
    channel, tick_s = load_channel(preset), 0.1
    gamma, offset = channel.path_loss_factor, OFFSET_DBM
    rng = np.random.default_rng([seed, len(preset)])
    a = decay(tick_s, channel.coloured_tc_s)
    drive = driving_std(channel.coloured_variance_db2, a)
    d, phi, p_dd, p_dp, p_pp = 160.0, 0.0, 3600.0, 0.0, channel.coloured_variance_db2
    ekf = oracle(channel, tick_s, [d, phi], np.diag([p_dd, p_pp]))
    true_d, true_phi, rate = 150.0, 0.0, -3.0
    for _ in range(500):
        rate = float(np.clip(rate + 0.3 * rng.standard_normal(), -8.0, 8.0))
        psi = rate * tick_s if rng.random() < 0.5 else 0.0
        process = 10.0 ** rng.uniform(-2, 1.5)
        true_d = max(abs(true_d + rate * tick_s), 1.0)
        true_phi = a * (true_phi + drive * rng.standard_normal())
        rss = h(true_d, true_phi, gamma) + math.sqrt(channel.white_variance_db2) * rng.standard_normal()
        heard = rng.random() < 0.9
        d, phi, p_dd, p_dp, p_pp = coloured.predict(d, phi, p_dd, p_dp, p_pp, psi, process, a, drive)
        d = max(d, FLOOR_M)
        if heard:
            d, phi, p_dd, p_dp, p_pp = coloured.update(
                d, phi, p_dd, p_dp, p_pp, rss, offset, gamma, channel.white_variance_db2, FLOOR_M
            )
        step(ekf, gamma, psi, process, rss if heard else None)
        np.testing.assert_allclose([d, phi], ekf.x, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose([[p_dd, p_dp], [p_dp, p_pp]], ekf.P, rtol=1e-9, atol=1e-9)


@given(DISTANCES_M, st.floats(-30.0, 30.0), GAMMAS, WHITE_DB2, st.floats(0.1, 1e4), st.floats(1e-3, 400.0),
       st.floats(-0.99, 0.99), SURPRISES_DB)  # fmt: skip
def test_joseph_form_equals_literal_21(d, phi, gamma, white, p_dd, p_pp, correlation, surprise):
    p_dp = correlation * math.sqrt(p_dd * p_pp)
    p = np.array([[p_dd, p_dp], [p_dp, p_pp]])
    rss = h(d, phi, gamma) + surprise
    out = coloured.update(d, phi, p_dd, p_dp, p_pp, rss, OFFSET_DBM, gamma, white, FLOOR_M)
    # (18)-(21) as printed.
    hat = p @ jacobian(d, gamma).T
    gain = hat / (jacobian(d, gamma) @ hat + white)
    literal = (np.eye(2) - gain @ jacobian(d, gamma)) @ p
    state = np.array([d, phi]) + gain[:, 0] * surprise
    # The literal form loses digits where the update removes nearly all variance: 1e-9 of what was there before.
    scale = math.sqrt(p_dd), math.sqrt(p_pp)
    for value, (i, j) in zip(out[2:], ((0, 0), (0, 1), (1, 1)), strict=True):
        assert abs(value - literal[i, j]) <= 1e-9 * scale[i] * scale[j]
    assert out[1] == pytest.approx(state[1], rel=1e-9, abs=1e-9)
    assert out[0] == pytest.approx(max(state[0], FLOOR_M), rel=1e-9, abs=1e-9 * scale[0])


def test_joseph_form_equals_literal_21_over_a_flight():
    """The two forms, each fed its own covariance for 1,000 ticks at the paper's numbers, agree to 1e-9."""
    channel = Channel()
    a = decay(0.1, channel.coloured_tc_s)
    drive = driving_std(channel.coloured_variance_db2, a)
    rng = np.random.default_rng(21)
    mine = (160.0, 0.0, 3600.0, 0.0, 4.0)
    x, p = np.array([160.0, 0.0]), np.diag([3600.0, 4.0])
    for n in range(1000):
        true_d = abs(150.0 - 0.4 * n) + 5.0
        rss = h(true_d, 0.0, 2.7) + 2.8 * rng.standard_normal()
        mine = coloured.predict(*mine, -0.4, 1.0, a, drive)
        mine = coloured.update(*mine, rss, OFFSET_DBM, 2.7, channel.white_variance_db2, FLOOR_M)
        x = np.array([x[0] - 0.4, a * x[1]])
        p = np.diag([1.0, a]) @ p @ np.diag([1.0, a]) + np.diag([1.0, a * a * drive * drive])
        row = jacobian(x[0], 2.7)
        gain = (p @ row.T) / (row @ p @ row.T + channel.white_variance_db2)
        x = x + gain[:, 0] * (rss - h(x[0], x[1], 2.7))
        x[0] = max(x[0], FLOOR_M)
        p = (np.eye(2) - gain @ row) @ p
        np.testing.assert_allclose(mine, [x[0], x[1], p[0, 0], p[0, 1], p[1, 1]], rtol=1e-9, atol=1e-9)


@given(
    st.tuples(DISTANCES_M, GAMMAS, WHITE_DB2, COLOURED_DB2, COLOURED_TC_S, st.sampled_from([0.01, 0.1, 1.0])),
    st.lists(st.tuples(st.floats(-10.0, 10.0), PROCESS_M2, SURPRISES_DB, st.booleans()), min_size=1, max_size=30),
)
def test_covariance_stays_symmetric_and_positive(setting, ticks):
    """Over the ranges of params.py: the range stays above its floor, P positive semidefinite, no variance grows."""
    d, gamma, white, variance, time_s, tick_s = setting
    a = decay(tick_s, time_s)
    drive = driving_std(variance, a)
    state = coloured.start(160.0, 60.0, variance, h(d, 0.0, gamma), OFFSET_DBM, gamma, white)
    for psi, process, surprise, heard in ticks:
        _positive(*state[2:])
        state = coloured.predict(*state, psi, process, a, drive)
        state = max(state[0], FLOOR_M), *state[1:]
        _positive(*state[2:])
        if heard:
            before = state
            state = coloured.update(*state, h(state[0], state[1], gamma) + surprise, OFFSET_DBM, gamma, white, FLOOR_M)
            assert state[2] <= before[2] * (1.0 + 1e-9)
            assert state[4] <= before[4] * (1.0 + 1e-9)
        assert state[0] >= FLOOR_M
        assert np.isfinite(state).all()
    if time_s < 50.0 * tick_s:  # unheard for long, the coloured state goes back to its stationary variance
        for _ in range(10 + int(10.0 * time_s / tick_s)):
            state = coloured.predict(*state, 0.0, 1.0, a, drive)
        assert state[4] == pytest.approx(variance, rel=1e-6)


def _positive(p_dd, p_dp, p_pp):
    """One off-diagonal number is kept, so P is symmetric; its determinant may be zero to rounding."""
    assert p_dd > 0.0
    assert p_pp >= 0.0
    assert p_dp * p_dp <= p_dd * p_pp * (1.0 + 1e-9)


@given(st.floats(1.0, 1e4), st.floats(0.01, 1.0), COLOURED_DB2, WHITE_DB2, GAMMAS, SURPRISES_DB)
def test_start_is_a_linear_update_in_log_distance(prior, relative_std, variance, white, gamma, surprise):
    """Filterpy's linear Kalman filter on the state [ln d, phi], taken back to d by its derivative."""
    rss = h(prior, 0.0, gamma) + surprise
    d, phi, p_dd, p_dp, p_pp = coloured.start(prior, relative_std * prior, variance, rss, OFFSET_DBM, gamma, white)
    kf = KalmanFilter(dim_x=2, dim_z=1)
    kf.x, kf.P = np.array([math.log(prior), 0.0]), np.diag([relative_std**2, variance])
    kf.H, kf.R = np.array([[-10.0 * gamma / math.log(10.0), 1.0]]), np.array([[white]])
    kf.update(np.array([rss - OFFSET_DBM]))
    assert d == pytest.approx(math.exp(kf.x[0]), rel=1e-9)
    assert phi == pytest.approx(kf.x[1], rel=1e-9, abs=1e-9)
    to_d = np.diag([d, 1.0])
    p = to_d @ kf.P @ to_d
    # The standard form of the package loses digits where the first sample says nearly everything.
    assert p_dd == pytest.approx(p[0, 0], rel=1e-9, abs=1e-12 * (d * relative_std) ** 2)
    assert p_dp == pytest.approx(p[0, 1], rel=1e-9, abs=1e-12 * d * relative_std * math.sqrt(variance))
    assert p_pp == pytest.approx(p[1, 1], rel=1e-9, abs=1e-12 * variance)


def test_start_with_a_perfect_prior_keeps_it():
    d, phi, p_dd, *_ = coloured.start(100.0, 1e-6, 4.0, -200.0, OFFSET_DBM, 2.7, 4.0)
    assert d == pytest.approx(100.0, rel=1e-9)
    assert p_dd == pytest.approx(1e-12, rel=1e-6)
    # Then the surprise is split between coloured and white noise by their variances.
    assert phi == pytest.approx(0.5 * (-200.0 - h(100.0, 0.0, 2.7)), rel=1e-9)


def test_known_step_by_hand():
    """One predict and update at round numbers: gamma 2, d 10, P = diag(100, 4), R = 4."""
    state = coloured.predict(10.0, 1.0, 100.0, 0.0, 4.0, -1.0, 21.0, 0.5, 2.0)
    assert state == (9.0, 0.5, 121.0, 0.0, 0.25 * 8.0)
    slope = -20.0 / (9.0 * math.log(10.0))
    s = slope * slope * 121.0 + 2.0 + 4.0
    out = coloured.update(*state, h(9.0, 0.5, 2.0) - 6.0, OFFSET_DBM, 2.0, 4.0, FLOOR_M)
    assert out[0] == pytest.approx(9.0 - 6.0 * 121.0 * slope / s, rel=1e-13)  # weaker than expected: farther
    assert out[0] > 9.0
    assert out[1] == pytest.approx(0.5 - 6.0 * 2.0 / s, rel=1e-13)
    assert out[2] == pytest.approx(121.0 - (121.0 * slope) ** 2 / s, rel=1e-12)
