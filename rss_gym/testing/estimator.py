"""What every estimator of range must keep."""

from __future__ import annotations

from typing import Any

import numpy as np

from rss_gym.params import Params, load_channel
from rss_gym.radio import simulate
from rss_gym.ranging import ESTIMATORS
from rss_gym.ranging.track import RangeTrack, track
from rss_gym.testing.flights import check_rows_alone, ended, fly_on, fresh

COUNT, PERIOD_S = 4, 0.1


def check_estimator(name: str) -> None:
    """Over records and, if it flies, in the world: ranges finite and positive, each record or row as alone.

    A sample that is missing leaves a range; a variance is not negative; and on a long record of the preset `paper` the
    range is nearer to the truth than the prior, as a median.
    """
    estimator = ESTIMATORS[name]
    assert estimator.title.strip(), f"estimator {name!r} has no title"
    check_records(name)
    if estimator.flies:
        check_flights(name)


def check_records(name: str) -> None:
    """The part of `check_estimator` that runs over records."""
    channel = load_channel("paper")
    distance_m = np.broadcast_to(np.linspace(90.0, 12.0, 1200), (COUNT, 1200))
    log = simulate(distance_m, PERIOD_S, channel, seed=0)
    rss_dbm = log.rss_dbm.copy()
    rss_dbm[:, 300:320] = np.nan
    found = track(name, log.time_s, rss_dbm, channel)
    _check_track(name, found)
    alone = track(name, log.time_s, rss_dbm[2], channel)
    for part in ("range_m", "coloured_db", "covariance", "innovation_db", "innovation_variance_db2"):
        same = np.array_equal(getattr(alone, part), getattr(found, part)[2], equal_nan=True)
        assert same, f"estimator {name!r}: {part} of a record depends on the other records of the batch"
    errors = np.abs(found.range_m - distance_m)[:, 100:]
    prior = np.abs(Params().ranging.prior_range_m - distance_m)[:, 100:]
    assert np.median(errors) < np.median(prior), f"estimator {name!r}: farther from the truth than the prior"


def _check_track(name: str, found: RangeTrack) -> None:
    heard = slice(1, None)  # a literal start says nothing before the first sample
    assert np.isfinite(found.range_m[:, heard]).all(), f"estimator {name!r}: a range is not finite"
    assert (found.range_m[:, heard] > 0.0).all(), f"estimator {name!r}: a range is not positive"
    variance = found.covariance[:, heard, 0]
    assert np.isfinite(variance).all() and (variance >= 0.0).all(), f"estimator {name!r}: a variance is negative"


def check_flights(name: str) -> None:
    """The part of `check_estimator` that flies in the world."""
    worlds: tuple[dict[str, Any], ...] = (
        {},
        {"channel": {"packet_loss": 0.3}, "planar": False},
        {"information": "ranges"},
    )
    for keywords in worlds:
        batch = fresh(Params.of(estimator=name, **keywords), 50)
        fly_on(batch)
        assert ended(batch).all(), f"estimator {name!r}: a flight does not end"
        range_m, variance_m2 = batch.state.links["range_m"][:, 0], batch.state.links["p_dd"][:, 0]
        assert np.isfinite(range_m).all() and (range_m > 0.0).all(), f"estimator {name!r}: a range is not positive"
        sound = np.isfinite(variance_m2) & (variance_m2 >= 0.0)
        assert sound.all(), f"estimator {name!r}: a variance is negative or not finite"
    check_rows_alone(Params.of(estimator=name))
