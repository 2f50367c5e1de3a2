"""What is compared: each estimator of range that is registered for it, and its tuning."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rss_gym.calibration.fit import Fit
from rss_gym.calibration.logs import LogRecord
from rss_gym.checks import Floats
from rss_gym.ranging import ESTIMATORS
from rss_gym.ranging.track import Tuning, track

WINDOW_S = 5.0
RATE = "-rate"  # end of the name of a method with the range rate
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
        Of `rss_gym.ranging.ESTIMATORS`; none for the constant guess.
    tuned : str, optional
        The field of `Tuning` that is tuned on the fitted part.
    base : str, optional
        The method whose tuning it starts from and to which it adds the logged range rate, psi of (12).
    """

    title: str
    estimator: str | None = None
    tuned: str | None = None
    base: str | None = None


def methods() -> dict[str, Method]:
    """The constant guess, and every estimator that is compared, then those that use the range rate with it."""
    compared = {name: part for name, part in ESTIMATORS.items() if part.compared}
    found = {"constant": Method("constant guess")}
    for name, part in compared.items():
        tuned = (_LOG if part.logarithmic else _RANGE) if part.tuned else None
        found[name] = Method(part.title, name, tuned)
    for name, part in compared.items():
        if part.tuned and not part.literal:
            tuned = _LOG_RATE if part.logarithmic else _RANGE_RATE
            found[f"{name}{RATE}"] = Method(f"{part.title}, with range rate", name, tuned, name)
    return found


def available(records: list[LogRecord]) -> dict[str, Method]:
    """The methods that these records allow: those with psi need a range rate in each of them."""
    rated = all(record.range_rate_mps is not None for record in records)
    return {name: method for name, method in methods().items() if rated or method.base is None}


def ranges(method: Method, record: LogRecord, fit: Fit, tuning: Tuning) -> Floats:
    """Range at each sample, m, shape (n,), with the path loss and the range prior of the record's link."""
    median_m, std_m = fit.range_prior_of(record.link)
    if method.estimator is None:
        return np.full(len(record.time_s), median_m)
    rate = record.range_rate_mps if method.base is not None else None
    tuning = tuning.replace(prior_range_m=median_m, prior_std_m=std_m)
    return track(method.estimator, record.time_s, record.rss_dbm, fit.channel_of(record.link), tuning, rate).range_m
