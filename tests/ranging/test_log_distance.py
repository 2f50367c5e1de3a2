"""The filter in ln d: equal to filterpy's linear filter, and consistent on data of its own model."""

import math

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from rss_gym.params import Channel, load_channel
from rss_gym.ranging import log_distance
from rss_gym.ranging.track import Tuning, track

TUNING = Tuning(relative_noise_ps=0.02, relative_noise_rate_ps=0.002, prior_range_m=60.0, prior_std_m=30.0)


def model(seed, records, samples, channel, lost=0.1):
    """NumPy's own run of the model: ln d a random walk, AR(1) and white noise, at irregular times."""
    rng = np.random.default_rng(seed)
    steps = rng.uniform(0.05, 0.4, samples)
    x = math.log(TUNING.prior_range_m) + TUNING.prior_std_m / TUNING.prior_range_m * rng.standard_normal(records)
    phi = math.sqrt(channel.coloured_variance_db2) * rng.standard_normal(records)
    columns = []
    for n in range(samples):
        if n > 0:
            a = math.exp(-steps[n] / channel.coloured_tc_s)
            x = x + math.sqrt(TUNING.relative_noise_ps * steps[n]) * rng.standard_normal(records)
            phi = a * phi + math.sqrt(channel.coloured_variance_db2 * (1.0 - a * a)) * rng.standard_normal(records)
        rss = channel.offset_dbm - 10.0 * channel.path_loss_factor / math.log(10.0) * x + phi
        rss = rss + math.sqrt(channel.white_variance_db2) * rng.standard_normal(records)
        rss[rng.random(records) < lost] = np.nan
        columns.append((x, phi, rss))
    x, phi, rss = (np.stack(column, axis=1) for column in zip(*columns, strict=True))
    return np.cumsum(steps), np.exp(x), phi, rss


@pytest.mark.parametrize("preset", ["paper", "quadcopter"])
def test_equals_filterpys_linear_filter(preset):
    """200 irregular samples, some missing, with psi at half of them: state and covariance to 1e-9."""
    channel = load_channel(preset)
    time, distance, _, rss = model(1, 1, 200, channel)
    rng = np.random.default_rng(2)
    rate = np.where(rng.random(200) < 0.5, np.gradient(distance[0], time), np.nan)
    out = track("ekf-log", time, rss[0], channel, TUNING, rate)
    kf = KalmanFilter(dim_x=2, dim_z=1)
    kf.x = np.array([math.log(TUNING.prior_range_m), 0.0])
    kf.P = np.diag([(TUNING.prior_std_m / TUNING.prior_range_m) ** 2, channel.coloured_variance_db2])
    kf.H = np.array([[-10.0 * channel.path_loss_factor / math.log(10.0), 1.0]])
    kf.R, kf.B = np.array([[channel.white_variance_db2]]), np.array([1.0, 0.0])
    heard = False
    for n in range(200):
        if heard:
            interval, known = time[n] - time[n - 1], not np.isnan(rate[n])
            a = math.exp(-interval / channel.coloured_tc_s)
            ratio = 1.0 + rate[n] * interval / math.exp(kf.x[0]) if known else 1.0
            noise = TUNING.relative_noise_rate_ps if known else TUNING.relative_noise_ps
            q = np.diag([noise * interval, channel.coloured_variance_db2 * (1.0 - a * a)])
            kf.predict(u=math.log(ratio), F=np.diag([1.0, a]), Q=np.zeros((2, 2)))
            kf.P = np.diag([1.0 / ratio, 1.0]) @ kf.P @ np.diag([1.0 / ratio, 1.0]) + q
        if not np.isnan(rss[0, n]):
            kf.update(np.array([rss[0, n] - channel.offset_dbm]))
            heard = True
        p = out.covariance[n]
        np.testing.assert_allclose([math.log(out.range_m[n]), out.coloured_db[n]], kf.x, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose([[p[0], p[1]], [p[1], p[2]]], kf.P, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("channel", [load_channel("paper"), load_channel("quadcopter")], ids=["paper", "quadcopter"])
def test_consistent_on_its_own_model(channel):
    """300 records: NEES after 1, 20 and 60 samples and all of NIS inside their 99.99 % chi-square intervals."""
    time, distance, phi, rss = model(3, 300, 60, channel)
    out = track("ekf-log", time, rss, channel, TUNING)
    both, alone = out.nees(distance, phi), out.nees(distance)
    for n in (0, 19, 59):
        for values, freedom in ((both, 2), (alone, 1)):
            low, high = chi2.interval(0.9999, 300 * freedom)
            assert low < values[:, n].sum() < high
    heard = ~np.isnan(rss)
    low, high = chi2.interval(0.9999, heard.sum())
    assert low < out.nis[heard].sum() < high


def test_consistent_on_quantised_samples():
    """2 dB steps, R + step^2 / 12: the mean of NIS over 18,000 samples is within 5 % of 1; without it, it is not."""
    channel = Channel(white_variance_db2=1.0, quantisation_db=2.0)
    time, _, _, rss = model(4, 300, 60, channel, lost=0.0)
    rss = 2.0 * np.round(rss / 2.0)
    assert track("ekf-log", time, rss, channel, TUNING).nis.mean() == pytest.approx(1.0, abs=0.05)
    assert track("ekf-log", time, rss, channel.replace(quantisation_db=0.0), TUNING).nis.mean() > 1.1


@given(st.floats(1.0, 1e4), st.floats(-0.5, 0.5), st.floats(1e-6, 1.0), st.floats(-0.9, 0.9), st.floats(1e-3, 100.0))
def test_psi_moves_the_range_and_keeps_its_standard_deviation(d, share, p_xx, correlation, p_pp):
    """Prediction by psi is the range filter's: d + psi, and a standard deviation in metres that does not change."""
    p_xp = correlation * math.sqrt(p_xx * p_pp)
    x, phi, q_xx, q_xp, q_pp = log_distance.predict(math.log(d), 1.0, p_xx, p_xp, p_pp, share * d, 0.0, 1.0, 0.0, 0.3)
    assert math.exp(x) == pytest.approx(d * (1.0 + share), rel=1e-12)
    assert math.exp(x) * math.sqrt(q_xx) == pytest.approx(d * math.sqrt(p_xx), rel=1e-12)
    assert (phi, q_pp) == (1.0, p_pp)
    assert q_xp / math.sqrt(q_xx * q_pp) == pytest.approx(correlation, rel=1e-9, abs=1e-12)
    first_order = log_distance.predict(math.log(d), 0.0, p_xx, 0.0, p_pp, 1e-6 * d, 0.0, 1.0, 0.0, 0.3)[0] - math.log(d)
    assert first_order == pytest.approx(1e-6, rel=1e-5, abs=1e-14)  # psi / d


def test_psi_beyond_the_receiver_stops_at_the_floor():
    x, *_ = log_distance.predict(math.log(2.0), 0.0, 0.1, 0.0, 1.0, -5.0, 0.0, 0.9, 1.0, 0.3)
    assert math.exp(x) == pytest.approx(0.3, rel=1e-12)


@given(
    st.floats(-1.0, 9.0), st.floats(-20.0, 20.0), st.floats(1e-6, 10.0), st.floats(-0.99, 0.99), st.floats(1e-4, 400.0),
    st.floats(1.0, 8.0), st.floats(1e-3, 400.0), st.floats(-40.0, 40.0),
)  # fmt: skip
def test_update_equals_the_information_form(x, phi, p_xx, correlation, p_pp, gamma, white, surprise):
    """P^-1 + h^T h / R and its mean, by NumPy; 1e-6 as inverting a nearly singular P costs digits."""
    p_xp = correlation * math.sqrt(p_xx * p_pp)
    h = np.array([-10.0 * gamma / math.log(10.0), 1.0])
    rss = -35.0 + h @ [x, phi] + surprise
    out = log_distance.update(x, phi, p_xx, p_xp, p_pp, rss, -35.0, gamma, white, 1e-300)
    p = np.linalg.inv(np.linalg.inv([[p_xx, p_xp], [p_xp, p_pp]]) + np.outer(h, h) / white)
    scale = math.sqrt(p[0, 0]), math.sqrt(p[1, 1])
    for value, (i, j) in zip(out[2:], ((0, 0), (0, 1), (1, 1)), strict=True):
        assert value == pytest.approx(p[i, j], rel=1e-6, abs=1e-6 * scale[i] * scale[j])
    gain = p @ h / white
    np.testing.assert_allclose(out[:2], [x + gain[0] * surprise, phi + gain[1] * surprise], rtol=1e-5, atol=1e-5)
