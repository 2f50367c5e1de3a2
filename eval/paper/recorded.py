"""The paper's comparison on a recorded radio: 802.11 carried past six access points, where the logs are at hand."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rss_gym.calibration.fit import Fit, fit
from rss_gym.calibration.logs import LogRecord, read
from rss_gym.eval.paper.study import NOISE_GRID_M2_PS
from rss_gym.params import ParamsError
from rss_gym.ranging.track import Tuning, track

Floats = NDArray[np.float64]

FOLDER = "wifi_walk"
FITTED, TESTED = ("Library_213.csv", "Library_413.csv"), ("Library_513.csv", "Library_613.csv")
CEILING_RATIO = 10.0  # of the longest fitted distance
RESAMPLES = 500


@dataclass(frozen=True)
class Recorded:
    """By method (resamples,) 80 % errors of bootstrap samples of whole records, m; the first is that of all of them."""

    p80_m: dict[str, Floats]
    samples: int


def recorded(seed: int) -> Recorded | None:
    """Fit two circuits, test on two others; None where the folder of `RSS_GYM_DATA` does not hold them."""
    root = os.environ.get("RSS_GYM_DATA")
    folder = Path(root or "", FOLDER)
    if not root or not all((folder / name).is_file() for name in (*FITTED, *TESTED)):
        return None
    try:
        found = fit(read([folder / name for name in FITTED]))
        tested = [record for record in read([folder / name for name in TESTED]) if record.link in found.links]
    except ParamsError:
        return None
    coloured, white = (_tuned(found, name) for name in ("ekf-coloured", "ekf-white"))
    methods = {
        "ls": ("ls", coloured),
        "white-same": ("ekf-white-r", coloured),
        "white": ("ekf-white", white),
        "coloured": ("ekf-coloured", coloured),
    }
    errors = {
        key: [np.abs(_ranges_m(found, record, name, tuning) - record.distance_m) for record in tested]
        for key, (name, tuning) in methods.items()
    }
    random = np.random.default_rng(seed)
    draws = [np.arange(len(tested)), *random.integers(len(tested), size=(RESAMPLES, len(tested)))]
    p80_m = {
        key: np.array([np.quantile(np.concatenate([own[k] for k in draw]), 0.8) for draw in draws])
        for key, own in errors.items()
    }
    return Recorded(p80_m, sum(len(record.time_s) for record in tested))


def _tuned(found: Fit, estimator: str) -> Tuning:
    """The process noise that errs least at 80 % on the fitted circuits."""
    longest_m = max(float(record.distance_m.max()) for record in found.records)
    tunings = [
        Tuning(process_noise_m2_ps=float(noise), range_ceiling_m=CEILING_RATIO * longest_m)
        for noise in NOISE_GRID_M2_PS
    ]

    def p80_m(tuning: Tuning) -> float:
        errors = [np.abs(_ranges_m(found, one, estimator, tuning) - one.distance_m) for one in found.records]
        return float(np.quantile(np.concatenate(errors), 0.8))

    return min(tunings, key=p80_m)


def _ranges_m(found: Fit, record: LogRecord, estimator: str, tuning: Tuning) -> Floats:
    median_m, std_m = found.range_prior_of(record.link)
    own = tuning.replace(prior_range_m=median_m, prior_std_m=std_m)
    ranges: Floats = track(estimator, record.time_s, record.rss_dbm, found.channel_of(record.link), own).range_m
    return ranges
