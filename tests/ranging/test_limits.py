"""Every estimator over all that its parameters allow: ranges within their ceiling, positive definite covariances."""

import numpy as np
import pytest

from rss_gym.params import Channel
from rss_gym.ranging.track import ESTIMATORS, Tuning, track

SAMPLES, CASES = 120, 400


def drawn(low, high, random):
    return float(10.0 ** random.uniform(np.log10(low), np.log10(high)))


def case(number):
    """A channel, a tuning, times, RSS and range rates from anywhere in the ranges of the parameters."""
    random = np.random.default_rng(number)
    channel = Channel(
        path_loss_factor=random.uniform(1.0, 8.0),
        offset_dbm=random.uniform(-150.0, 60.0),
        white_variance_db2=0.0 if number % 3 else drawn(1e-6, 400.0, random),
        coloured_variance_db2=drawn(1e-6, 400.0, random),
        coloured_tc_s=drawn(0.01, 3600.0, random),
    )
    tuning = Tuning(
        process_noise_m2_ps=drawn(1e-9, 1e9, random),
        process_noise_rate_m2_ps=drawn(1e-9, 1e9, random),
        relative_noise_ps=drawn(1e-12, 1e6, random),
        relative_noise_rate_ps=drawn(1e-12, 1e6, random),
        prior_range_m=drawn(0.1, 1e5, random),
        prior_std_m=drawn(1e-3, 1e5, random),
        range_floor_m=drawn(0.01, 10.0, random),
        range_ceiling_m=drawn(10.0, 1e6, random),
    )
    time_s = drawn(1e-3, 100.0, random) * np.arange(SAMPLES)
    rss = random.uniform(-1000.0, 1000.0, SAMPLES)
    if number % 2:
        distance_m = np.exp(np.cumsum(random.normal(0.0, 0.2, SAMPLES)) + random.uniform(-1.0, 8.0))
        mean = channel.offset_dbm - 10.0 * channel.path_loss_factor * np.log10(distance_m)
        std = np.sqrt(channel.white_variance_db2 + channel.coloured_variance_db2)
        rss = np.clip(mean + std * random.normal(size=SAMPLES), -999.0, 999.0)
    rate = random.normal(0.0, drawn(0.01, 1e3, random), SAMPLES) if number % 5 else None
    return channel, tuning, time_s, rss, rate


@pytest.mark.parametrize("name", ESTIMATORS)
def test_every_number_is_one_and_every_covariance_positive_definite(name):
    for number in range(CASES):
        channel, tuning, time_s, rss, rate = case(number)
        found = track(name, time_s, rss, channel, tuning, rate)
        assert (found.range_m > 0.0).all(), number
        # The state before the first sample is the prior as given.
        assert found.range_m.max() <= 1.000001 * max(tuning.range_ceiling_m, tuning.range_floor_m), number
        if not name.startswith("ekf"):
            continue
        p_xx, p_xp, p_pp = found.covariance.T
        assert np.isfinite(found.covariance).all() and (p_xx > 0.0).all(), number
        if "white" not in name:
            assert (p_pp > 0.0).all() and (p_xx * p_pp > p_xp**2).all(), number
        variance = found.innovation_variance_db2[np.isfinite(found.innovation_db)]
        assert np.isfinite(variance).all() and (variance > 0.0).all(), number


@pytest.mark.parametrize("name", ["ekf-coloured", "ekf-log"])
def test_no_white_noise_and_a_prior_that_says_nothing(name):
    """The case that was found: R = 0 and 2.1 m with a standard deviation of 100 km."""
    channel = Channel(white_variance_db2=0.0, path_loss_wander=0.0)
    tuning = Tuning(prior_range_m=2.1, prior_std_m=1e5)
    rss = -70.0 - 10.0 * np.sin(np.arange(300) / 20.0)
    found = track(name, 0.1 * np.arange(300), rss, channel, tuning)
    p_xx, p_xp, p_pp = found.covariance.T
    assert np.isfinite(found.range_m).all() and (p_xx * p_pp > p_xp**2).all() and (p_xx > 0.0).all()
