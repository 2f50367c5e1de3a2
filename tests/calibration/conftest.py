"""Logs of a known channel, as records and as files."""

import numpy as np
import pytest

from rss_gym.calibration.logs import LogRecord
from rss_gym.eval.studies.calibration.calibrate import calibrate
from rss_gym.params import Channel
from rss_gym.radio import simulate

TRUTH = Channel(
    path_loss_factor=2.7,
    offset_dbm=-35.0,
    white_variance_db2=4.0,
    coloured_variance_db2=6.0,
    coloured_tc_s=2.0,
    path_loss_wander=0.0,
    quantisation_db=1.0,
)
PERIOD_S = 0.2


def _flown(samples, seed=0, link="a", source="a.csv", channel=TRUTH, rated=False):
    """A record along smooth distances of 8 to 72 m."""
    time_s = PERIOD_S * np.arange(samples)
    rng = np.random.default_rng(seed)
    phase, period_s = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(35.0, 70.0)
    angle = 2.0 * np.pi * time_s / period_s + phase
    distance_m = 40.0 + 32.0 * np.sin(angle)
    rate_mps = 32.0 * 2.0 * np.pi / period_s * np.cos(angle)
    log = simulate(distance_m, PERIOD_S, channel, seed=seed)
    return LogRecord(link, source, time_s, log.rss_dbm, distance_m, rate_mps if rated else None, 0)


def _write(path, *records):
    """Records as one table, links interleaved."""
    rows = [(t, r.link, rss, d) for r in records for t, rss, d in zip(r.time_s, r.rss_dbm, r.distance_m, strict=True)]
    lines = [f"{t:.3f},{link},{rss:.1f},{d:.6f}" for t, link, rss, d in sorted(rows, key=lambda row: row[0])]
    path.write_text("\n".join(["t,link,rss,dist", *lines]) + "\n")
    return path


@pytest.fixture(scope="session")
def truth():
    """The channel of the logs."""
    return TRUTH


@pytest.fixture(scope="session")
def flown():
    """Makes a record: `flown(samples, seed, link, source, channel, rated)`."""
    return _flown


@pytest.fixture(scope="session")
def write():
    """Writes records as one table: `write(path, *records)`."""
    return _write


@pytest.fixture(scope="session")
def result():
    """Two links on three logs to fit, on three to test."""
    steeper = TRUTH.replace(path_loss_factor=3.1, offset_dbm=-40.0)
    records = [
        _flown(500, seed, link, f"{part}{log}.csv", channel)
        for part in ("fit", "test")
        for log in range(3)
        for link, channel, seed in (("a", TRUTH, 10 * log + (part == "test")), ("b", steeper, 100 + 10 * log))
    ]
    fitted = [record for record in records if record.source.startswith("fit")]
    return calibrate(fitted, [record for record in records if record.source.startswith("test")], ["a note"])
