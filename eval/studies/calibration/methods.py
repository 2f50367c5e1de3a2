"""What is compared: each estimator of range, its start and its tuning, one line each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rss_gym.calibration.fit import Fit
from rss_gym.calibration.logs import LogRecord
from rss_gym.checks import Floats
from rss_gym.ranging.track import Tuning, track

WINDOW_S = 5.0
_RANGE, _LOG = "process_noise_m2_ps", "relative_noise_ps"
_RANGE_RATE, _LOG_RATE = "process_noise_rate_m2_ps", "relative_noise_rate_ps"


@dataclass(frozen=True)
class Method:
    """One way to a range.

    Parameters
    ----------
    title : str
        For readers.
    estimator : str, optional
        Of `rss_gym.ranging.track.ESTIMATORS`; none for the constant guess.
    tuned : str, optional
        The field of `Tuning` that is tuned on the fitted part.
    base : str, optional
        The method whose tuning it starts from and to which it adds the logged range rate, psi of (12).
    """

    title: str
    estimator: str | None = None
    tuned: str | None = None
    base: str | None = None


METHODS: dict[str, Method] = {
    "constant": Method("constant guess"),
    "ls": Method("least squares, each sample", "ls"),
    "ls-window": Method(f"least squares, mean of {WINDOW_S:g} s", "ls-window"),
    "ekf-white-r": Method("white EKF, R alone", "ekf-white-r", _RANGE),
    "ekf-white": Method("white EKF, R + S", "ekf-white", _RANGE),
    "ekf-coloured-literal": Method("coloured EKF, literal start", "ekf-coloured-literal", _RANGE),
    "ekf-coloured": Method("coloured EKF", "ekf-coloured", _RANGE),
    "ekf-log": Method("coloured EKF, state ln d", "ekf-log", _LOG),
    "ekf-white-r-rate": Method("white EKF, R alone, with range rate", "ekf-white-r", _RANGE_RATE, "ekf-white-r"),
    "ekf-white-rate": Method("white EKF, R + S, with range rate", "ekf-white", _RANGE_RATE, "ekf-white"),
    "ekf-coloured-rate": Method("coloured EKF, with range rate", "ekf-coloured", _RANGE_RATE, "ekf-coloured"),
    "ekf-log-rate": Method("coloured EKF, state ln d, with range rate", "ekf-log", _LOG_RATE, "ekf-log"),
}


def available(records: list[LogRecord]) -> dict[str, Method]:
    """The methods that these records allow: those with psi need a range rate in each of them."""
    rated = all(record.range_rate_mps is not None for record in records)
    return {name: method for name, method in METHODS.items() if rated or method.base is None}


def ranges(method: Method, record: LogRecord, fit: Fit, tuning: Tuning) -> Floats:
    """Range at each sample, m, shape (n,), with the path loss and the range prior of the record's link."""
    median_m, std_m = fit.range_prior_of(record.link)
    if method.estimator is None:
        return np.full(len(record.time_s), median_m)
    rate = record.range_rate_mps if method.base is not None else None
    tuning = tuning.replace(prior_range_m=median_m, prior_std_m=std_m)
    return track(method.estimator, record.time_s, record.rss_dbm, fit.channel_of(record.link), tuning, rate).range_m
