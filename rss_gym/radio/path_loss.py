"""The path loss (2)-(3) on arrays, and its factor and offset fitted together to a log with known distances."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rss_gym.checks import Floats, distances, finite
from rss_gym.jit import kernel
from rss_gym.params import Channel, ParamsError, load_channel
from rss_gym.physics.path_loss import distance_m as solved_m
from rss_gym.physics.path_loss import received_dbm
from rss_gym.radio.identify import NoiseFit

AnyChannel = str | os.PathLike[str] | Mapping[str, Any] | Channel

SPREAD_DB = 0.01  # the least standard deviation of 10 log10 d that counts as flown at several distances


@dataclass(frozen=True)
class PathLossFit:
    """Path loss factor and offset (the RSS at 1 m) with their standard errors, and the residual, shape (n,)."""

    path_loss_factor: float
    path_loss_factor_std: float
    offset_dbm: float
    offset_std_dbm: float
    residual_db: Floats


def received(distance_m: Any, channel: AnyChannel) -> Floats:
    """RSS (dBm) without noise at distances (m, > 0, array of one or two dimensions), (2)."""
    distance_m, channel = distances(distance_m), load_channel(channel)
    out = np.empty(distance_m.shape)
    _received(channel.offset_dbm, channel.path_loss_factor, distance_m.ravel(), out.ravel())
    return out


def distance(rss_dbm: Any, channel: AnyChannel) -> Floats:
    """Distances (m) that (2) without noise gives for RSS (dBm, array of one or two dimensions)."""
    rss_dbm, channel = finite("rss_dbm", rss_dbm, dimensions=(1, 2)), load_channel(channel)
    out = np.empty(rss_dbm.shape)
    _distance(channel.offset_dbm, channel.path_loss_factor, rss_dbm.ravel(), out.ravel())
    return out


def fit_path_loss(
    distance_m: Any, rss_dbm: Any, time_s: Any | None = None, noise: NoiseFit | None = None
) -> PathLossFit:
    """Least squares of RSS on 10 log10 d: path loss factor and offset together, from one link.

    A kept offset is no substitute: an error of it goes into the factor and from there into every distance.

    Parameters
    ----------
    distance_m, rss_dbm : array, shape (n,)
        True distances, m, and what was received at them, dBm; n >= 3.
    time_s : array, shape (n,), optional
        Rising times of the samples, s; needed with `noise`.
    noise : NoiseFit, optional
        What `identify` found in the residual of a first fit. Without it the standard errors take the residual as white,
        and on a real link they are several times too small; with it they are those of this estimate in white plus
        Gauss-Markov noise.

    Raises
    ------
    ParamsError
        For arrays of unequal length, values that are not finite, distances that are not positive or all (nearly) equal,
        or noise without times.
    """
    d, rss = distances(distance_m, (1,)), finite("rss_dbm", rss_dbm, dimensions=(1,))
    if len(d) != len(rss) or len(d) < 3:
        raise ParamsError(f"distance_m and rss_dbm must hold one length of at least 3, got {len(d)} and {len(rss)}")
    level_db = -10.0 * np.log10(d)
    centred = level_db - level_db.mean()
    if np.sqrt(np.mean(centred * centred)) < SPREAD_DB:
        raise ParamsError(
            f"distance_m must vary, or path loss factor and offset cannot be told apart; it lies within "
            f"[{d.min():g}, {d.max():g}] m"
        )
    # Rows of the pseudo-inverse of (level, 1): the estimates are these times the RSS.
    slope_row = centred / (centred @ centred)
    offset_row = 1.0 / len(d) - level_db.mean() * slope_row
    rows = np.stack([slope_row, offset_row])
    gamma, offset = float(slope_row @ rss), float(offset_row @ rss)
    residual = rss - offset - gamma * level_db
    if noise is None:
        variance = float(residual @ residual) / (len(d) - 2) * np.sum(rows * rows, axis=1)
    elif time_s is None:
        raise ParamsError("time_s must be given with noise, or how far the samples are correlated is unknown")
    else:
        variance = _coloured(rows, finite("time_s", time_s, dimensions=(1,)), noise)
    stds = np.sqrt(variance)
    return PathLossFit(gamma, float(stds[0]), offset, float(stds[1]), residual)


def _coloured(rows: Floats, time_s: Floats, noise: NoiseFit) -> Floats:
    """Variance of rows @ e for white plus Gauss-Markov noise e at these times: diag(rows C rows^T), in one pass."""
    if len(time_s) != rows.shape[1] or (np.diff(time_s) <= 0.0).any():
        raise ParamsError(f"time_s must be {rows.shape[1]} rising times, got {len(time_s)}")
    decays = np.exp(-np.diff(time_s, prepend=time_s[0]) / noise.coloured_tc_s)
    past, crossed = np.zeros(2), np.zeros(2)
    for row, decay in zip(rows.T, decays, strict=True):
        past *= decay
        crossed += row * past
        past += row
    squares = np.sum(rows * rows, axis=1)
    return noise.white_variance_db2 * squares + noise.coloured_variance_db2 * (squares + 2.0 * crossed)


@kernel
def _received(offset_dbm, path_loss_factor, d, out):  # type: ignore[no-untyped-def]
    """(2) at every distance."""
    for i in range(d.size):
        out[i] = received_dbm(offset_dbm, path_loss_factor, d[i] * d[i])


@kernel
def _distance(offset_dbm, path_loss_factor, rss, out):  # type: ignore[no-untyped-def]
    """(2) solved at every RSS."""
    for i in range(rss.size):
        out[i] = solved_m(offset_dbm, path_loss_factor, rss[i])
