"""Simulated logs: every sample from the world's kernels, the receiver's limits, and the statistics of the channel."""

import math

import numpy as np
import pytest

from rss_gym.params import Channel, ParamsError, load_channel
from rss_gym.physics import noise, path_loss, random
from rss_gym.radio import received, simulate
from rss_gym.radio.simulate import COLOURED, SPLIT, START, WANDER, WHITE

QUIET = {"white_variance_db2": 0.0, "coloured_variance_db2": 1e-6, "path_loss_wander": 0.0}


def test_every_sample_is_the_kernels():
    """The recursion written in Python, from `physics` alone."""
    channel = load_channel("outdoor")
    d = np.linspace(3.0, 60.0, 25)
    log = simulate(d, 0.5, channel, seed=3, record=9)
    key = np.uint64(random.episode_key(SPLIT, np.uint64(3), np.uint64(9)))
    a, b = noise.decay(0.5, channel.coloured_tc_s), noise.decay(0.5, channel.path_loss_wander_tc_s)
    phi = math.sqrt(channel.coloured_variance_db2) * random.normal(key, START, 0)
    wander = channel.path_loss_wander * random.normal(key, START, 1)
    for n in range(25):
        if n:
            drive = noise.driving_std(channel.coloured_variance_db2, a)
            phi = noise.gauss_markov(phi, a, drive, random.normal(key, COLOURED, n))
            drive = noise.driving_std(channel.path_loss_wander**2, b)
            wander = noise.gauss_markov(wander, b, drive, random.normal(key, WANDER, n))
        rss = path_loss.received_dbm(channel.offset_dbm, channel.path_loss_factor + wander, d[n] ** 2)
        rss += phi + math.sqrt(channel.white_variance_db2) * random.normal(key, WHITE, n)
        assert log.coloured_db[n] == pytest.approx(phi, rel=1e-12)
        assert log.rss_dbm[n] == pytest.approx(rss, rel=1e-12)
    np.testing.assert_allclose(log.time_s, 0.5 * np.arange(25))


def test_a_batch_is_its_records():
    d = np.random.default_rng(0).uniform(1.0, 90.0, (4, 300))
    batch = simulate(d, 0.1, "quadcopter", seed=5, record=7, link="a")
    assert batch.rss_dbm.shape == batch.coloured_db.shape == (4, 300)
    assert batch.link == "a"
    for i, row in enumerate(d):
        alone = simulate(row, 0.1, "quadcopter", seed=5, record=7 + i)
        np.testing.assert_array_equal(alone.rss_dbm, batch.rss_dbm[i])
        np.testing.assert_array_equal(alone.coloured_db, batch.coloured_db[i])
        assert not np.array_equal(alone.rss_dbm, simulate(row, 0.1, "quadcopter", seed=6, record=7 + i).rss_dbm)


def test_moments_over_an_ensemble():
    """4000 records: stationary variances at the first and last sample, correlation a^lag; 4.5 standard errors."""
    channel = load_channel("outdoor").replace(path_loss_wander=0.3, path_loss_wander_tc_s=1.0)
    log = simulate(np.full((4000, 40), 10.0), 0.1, channel, seed=2)
    rest = log.rss_dbm - received([10.0], channel)
    for n in (0, 39):
        assert abs(np.var(log.coloured_db[:, n]) / 4.0 - 1.0) < 4.5 * math.sqrt(2.0 / 4000)
        # 10 log10 d = 10 dB, so that a wander of 0.3 is 3 dB.
        assert abs(np.var(rest[:, n]) / (4.0 + 4.0 + 9.0) - 1.0) < 4.5 * math.sqrt(2.0 / 4000)
        assert abs(rest[:, n].mean()) < 4.5 * math.sqrt(17.0 / 4000)
    wander = (rest - log.coloured_db)[:, [0, 20]]
    assert abs(np.mean(wander[:, 0] * wander[:, 1]) - 9.0 * math.exp(-2.0)) < 4.5 * 13.1 / math.sqrt(4000)
    r = math.exp(-39 * 0.1 / 2.0)
    assert abs(np.mean(log.coloured_db[:, 0] * log.coloured_db[:, 39]) / 4.0 - r) < 4.5 * math.sqrt((1 + r * r) / 4000)


def test_receiver():
    """Multiples of the step, nothing below the sensitivity, the share of packets that is lost."""
    d = np.linspace(1.0, 100.0, 20_000)
    steps = simulate(d, 0.1, Channel(quantisation_db=0.5, sensitivity_dbm=-80.0)).rss_dbm
    heard = steps[~np.isnan(steps)]
    np.testing.assert_array_equal(heard, np.round(heard / 0.5) * 0.5)
    assert heard.min() == -80.0
    free = simulate(d, 0.1, Channel()).rss_dbm
    np.testing.assert_array_equal(np.isnan(steps), np.floor(free / 0.5 + 0.5) * 0.5 < -80.0)
    lossy = simulate(d, 0.1, Channel(packet_loss=0.2)).rss_dbm
    lost = np.isnan(lossy)
    assert abs(lost.mean() - 0.2) < 4.5 * math.sqrt(0.16 / 20_000)
    np.testing.assert_array_equal(lossy[~lost], free[~lost])


def test_near_distances_count_as_a_tenth_of_a_metre():
    rss = simulate([1e-3, 0.1], 0.1, Channel(**QUIET)).rss_dbm
    assert rss[0] == pytest.approx(rss[1], abs=0.02)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (([], 0.1, "paper"), "distance_m"),
        (([1.0, -2.0], 0.1, "paper"), "above 0, got -2 at element 1"),
        (([1.0, np.nan], 0.1, "paper"), "distance_m must be finite"),
        (([1.0], 0.0, "paper"), "period_s"),
        (([1.0], 1e5, "paper"), "period_s"),
        (([1.0], 3600.0, "paper"), "period_s"),
        (([1.0], 0.1, "papr"), "did you mean 'paper'"),
        (([1.0], 0.1, "paper", -1), "seed"),
        (([1.0], 0.1, "paper", 1.0), "seed"),
        (([1.0], 0.1, "paper", 0, 2**63), "record"),
        (([1.0], 0.1, "paper", 0, True), "record"),
    ],
)
def test_bad_input(arguments, says):
    with pytest.raises(ParamsError, match=says):
        simulate(*arguments)
