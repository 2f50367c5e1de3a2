"""A residual at uneven times, as logs have it, put on a constant period."""

from __future__ import annotations

from typing import Any

import numpy as np

from rss_gym.checks import Floats, finite
from rss_gym.params import ParamsError

GAP = 3.0  # median intervals without a sample that end a record


def regular(time_s: Any, values: Any) -> tuple[list[Floats], float]:
    """Records at a constant period, the median interval, by the nearest sample; a gap starts a new record.

    The nearest sample keeps the variance of the white noise, which interpolation would lower; its time is wrong by up
    to half a period, or by more where a sample is missing.

    Parameters
    ----------
    time_s : array, shape (n,)
        Rising times, s.
    values : array, shape (n,)
        Samples, dB.

    Returns
    -------
    records : list of ndarray
        At least 3 samples each; shorter pieces between two gaps of more than 3 periods are left out.
    period_s : float
        The median interval, s.

    Raises
    ------
    ParamsError
        For unequal lengths, times that do not rise, values that are not finite, or no piece of 3 samples.
    """
    t, x = finite("time_s", time_s, dimensions=(1,)), finite("values", values, dimensions=(1,))
    if len(t) != len(x):
        raise ParamsError(f"time_s and values must be of one length, got {len(t)} and {len(x)}")
    steps = np.diff(t)
    if len(t) < 3 or (steps <= 0.0).any():
        raise ParamsError("time_s must rise from sample to sample over at least 3 samples")
    period_s = float(np.median(steps))
    cuts = np.flatnonzero(steps > GAP * period_s) + 1
    records = []
    for piece in np.split(np.arange(len(t)), cuts):
        times = t[piece]
        grid = times[0] + period_s * np.arange(int((times[-1] - times[0]) / period_s + 0.5) + 1)
        if len(piece) >= 3:
            records.append(x[piece[np.searchsorted(0.5 * (times[1:] + times[:-1]), grid)]])
    if not records:
        raise ParamsError(f"time_s has a gap after every second sample: no 3 within {GAP:g} median intervals")
    return records, period_s
