"""Tuning of each filter on the fitted part: the process noise."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rss_gym.calibration.fit import Fit
from rss_gym.eval.studies.calibration.methods import WINDOW_S, Method, ranges
from rss_gym.ranging.track import Tuning

SHARE = 0.8
"""The criterion is this quantile of the absolute range error over all samples of the fitted part."""
# Candidates for a process noise, a quarter of a decade apart: m^2/s for the range, 1/s for its logarithm.
GRID = 10.0 ** np.arange(-8.0, 4.01, 0.25)
_CEILING_RATIO = 10.0


def tune(fit: Fit, methods: Mapping[str, Method]) -> dict[str, Tuning]:
    """Every method's process noise per second, each found by itself, the white filters like the others.

    Ranges are held below ten times the longest distance of the fitted part.
    """
    longest_m = max(float(record.distance_m.max()) for record in fit.records)
    untuned = Tuning(range_ceiling_m=min(max(_CEILING_RATIO * longest_m, 10.0), 1e6), window_s=WINDOW_S)
    tunings: dict[str, Tuning] = {}
    for name, method in methods.items():
        tuning = tunings[method.base] if method.base is not None else untuned
        if method.tuned is not None:
            candidates = [tuning.replace(**{method.tuned: float(noise)}) for noise in GRID]
            tuning = min(candidates, key=lambda candidate: _criterion(fit, method, candidate))
        tunings[name] = tuning
    return tunings


def at_the_edge(methods: Mapping[str, Method], tunings: Mapping[str, Tuning]) -> list[str]:
    """A sentence for each end of `GRID` at which a tuning ended: the best process noise may lie beyond it."""
    notes = []
    for noise, end, more in ((GRID[0], "least", "less"), (GRID[-1], "largest", "more")):
        titles = [
            method.title
            for name, method in methods.items()
            if method.tuned is not None and getattr(tunings[name], method.tuned) == float(noise)
        ]
        if titles:
            notes.append(
                f"the process noise of {'; '.join(titles)} was tuned to the {end} of its grid, {noise:.0e} a second: "
                f"{more} may be better"
            )
    return notes


def _criterion(fit: Fit, method: Method, tuning: Tuning) -> float:
    errors = [ranges(method, record, fit, tuning) - record.distance_m for record in fit.records]
    return float(np.quantile(np.abs(np.concatenate(errors)), SHARE))
