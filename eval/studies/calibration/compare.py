"""Range errors of every method on the samples that were held out, with intervals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rss_gym.calibration.fit import Fit
from rss_gym.calibration.logs import LogRecord
from rss_gym.checks import Floats
from rss_gym.eval.studies.calibration.methods import Method, ranges
from rss_gym.ranging.track import Tuning

CONFIDENCE = 0.95
RECORDS_MIN = 5
"""With fewer records there is no interval: their resamples would be too much alike."""
SHARES = (0.5, 0.8)
_RESAMPLES, _SEED = 2000, 0


@dataclass(frozen=True)
class Figure:
    """A number with its 95 % interval, which may be missing."""

    value: float
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True, eq=False)
class EstimatorScore:
    """What one method reached: ranges record by record, and figures of the absolute error over all samples."""

    ranges_m: tuple[Floats, ...]
    p50_m: Figure
    p80_m: Figure
    rmse_m: Figure


FIGURES = {"p50_m": "median", "p80_m": "80 %", "rmse_m": "RMSE"}


def compare(
    fit: Fit, records: Sequence[LogRecord], methods: Mapping[str, Method], tunings: Mapping[str, Tuning]
) -> dict[str, EstimatorScore]:
    """Every method on the same records.

    The path loss of a link is the one fitted for it, or the channel's if the link is new. Intervals are percentiles of
    2,000 bootstrap samples of whole records (a link on a flight), as errors within one are correlated; every method has
    the same samples.
    """
    counts = _resamples(len(records))
    scores = {}
    for name, method in methods.items():
        found = tuple(ranges(method, record, fit, tunings[name]) for record in records)
        errors = [np.abs(range_m - record.distance_m) for range_m, record in zip(found, records, strict=True)]
        scores[name] = EstimatorScore(found, *_figures(errors, counts))
    return scores


def _resamples(records: int) -> Floats:
    """How often each record stands in each bootstrap sample, (samples, records)."""
    size = _RESAMPLES if records >= RECORDS_MIN else 0
    drawn = np.random.default_rng(_SEED).multinomial(records, np.full(records, 1.0 / records), size=size)
    return drawn.astype(np.float64)


def _figures(errors: Sequence[Floats], counts: Floats) -> tuple[Figure, Figure, Figure]:
    """Median, 80 % quantile and root mean square of absolute errors, record by record."""
    pooled = np.concatenate(errors)
    median, p80 = (float(value) for value in np.quantile(pooled, SHARES))
    rms = float(np.sqrt(np.mean(pooled * pooled)))
    if not len(counts):
        return Figure(median), Figure(p80), Figure(rms)
    # The bootstrap needs no samples: how many of a record's errors are below each of 2,001 levels is enough.
    levels = np.quantile(pooled, np.linspace(0.0, 1.0, 2001))
    below = counts @ np.array([np.searchsorted(np.sort(error), levels, side="right") for error in errors])
    squares = counts @ np.array([error @ error for error in errors])
    drawn = [levels[np.sum(below < share * below[:, -1:], axis=1)] for share in SHARES]
    drawn.append(np.sqrt(squares / below[:, -1]))
    sides = np.quantile(drawn, [0.5 * (1.0 - CONFIDENCE), 0.5 * (1.0 + CONFIDENCE)], axis=1)
    low, high = sides.tolist()
    return Figure(median, low[0], high[0]), Figure(p80, low[1], high[1]), Figure(rms, low[2], high[2])
