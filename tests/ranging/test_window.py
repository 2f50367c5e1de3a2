"""Least squares on a window, against NumPy over every window."""

import numpy as np
import pytest

from rss_gym.params import Channel
from rss_gym.ranging.track import Tuning, track

CHANNEL = Channel(white_variance_db2=2.0, coloured_variance_db2=5.0, coloured_tc_s=1.5)


def test_mean_and_variance_of_every_window():
    """80 irregular samples, a third missing: mean of the window inverted, variance from the full correlation matrix."""
    rng = np.random.default_rng(0)
    time, rss = np.cumsum(rng.uniform(0.05, 0.8, 80)), -70.0 + 4.0 * rng.standard_normal(80)
    rss[rng.random(80) < 0.33] = np.nan
    rss[0], rss[40:55] = -70.0, np.nan  # the gap is longer than the window
    out = track("ls-window", time, rss, CHANNEL, Tuning(window_s=2.0))
    held = None
    for n in range(80):
        inside = (time <= time[n]) & (time > time[n] - 2.0) & ~np.isnan(rss)
        if inside.any():
            times = time[inside]
            noise = 2.0 * np.eye(len(times)) + 5.0 * np.exp(-np.abs(times[:, None] - times) / 1.5)
            d = 10.0 ** ((-35.0 - rss[inside].mean()) / 27.0)
            held = d, d * np.log(10.0) / 27.0 * np.sqrt(noise.mean())
        assert (out.range_m[n], out.range_std_m[n]) == pytest.approx(held, rel=1e-10)
    assert np.isnan(out.coloured_db).all()
    assert np.isnan(out.innovation_db).all()


def test_a_short_window_is_each_sample_alone():
    time, rss = np.arange(5.0), np.array([-60.0, -65.0, np.nan, -70.0, -75.0])
    short, alone = track("ls-window", time, rss, CHANNEL, Tuning(window_s=0.5)), track("ls", time, rss, CHANNEL)
    np.testing.assert_allclose(short.range_m, alone.range_m, rtol=1e-14)
    np.testing.assert_allclose(short.range_std_m, alone.range_std_m, rtol=1e-14)


def test_stated_deviation_is_the_scatter():
    """4,000 windows of 21 samples of small noise: the standard deviation of the range within 5 %."""
    rng, small = np.random.default_rng(1), Channel(white_variance_db2=0.02, coloured_variance_db2=0.05)
    a, samples = np.exp(-0.1 / 2.0), 21
    phi = np.sqrt(0.05) * rng.standard_normal(4000)
    rss = np.empty((4000, samples))
    for n in range(samples):
        phi = a * phi + np.sqrt(0.05 * (1.0 - a * a)) * rng.standard_normal(4000) if n else phi
        rss[:, n] = -35.0 - 54.0 + phi + np.sqrt(0.02) * rng.standard_normal(4000)
    out = track("ls-window", np.arange(samples) / 10.0, rss, small)
    assert out.range_m[:, -1].std() == pytest.approx(out.range_std_m[:, -1].mean(), rel=0.05)
