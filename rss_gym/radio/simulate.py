"""Logs of a simulated link: the world's kernels and counter-based noise, along any distances."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Any, Final

import numpy as np

from rss_gym.checks import Floats, distances, positive, whole
from rss_gym.jit import kernel
from rss_gym.params import load_channel
from rss_gym.physics.noise import gauss_markov
from rss_gym.physics.path_loss import quantise, received_dbm
from rss_gym.physics.random import episode_key, normal, uniform
from rss_gym.radio.gauss_markov import GaussMarkov
from rss_gym.radio.path_loss import AnyChannel

SPLIT: Final = 3  # of the episode keys; the world's splits are 0 to 2, so no log shares noise with a flight
COLOURED, WHITE, LOSS, WANDER, START = 0, 1, 2, 3, 4  # streams


@dataclass(frozen=True)
class RadioLog:
    """A record of one link, or k records at the same times.

    Parameters
    ----------
    time_s : ndarray, shape (n,)
        Rising, s.
    rss_dbm : ndarray, shape (n,) or (k, n)
        RSS, dBm; NaN where the packet was lost or too weak.
    distance_m : ndarray, shape as `rss_dbm`
        True distance, m.
    coloured_db : ndarray, shape as `rss_dbm`
        True coloured noise, dB; NaN where it is not known.
    link : str
        Name of the link.
    """

    time_s: Floats
    rss_dbm: Floats
    distance_m: Floats
    coloured_db: Floats
    link: str


def simulate(
    distance_m: Any, period_s: float, channel: AnyChannel, seed: int = 0, record: int = 0, link: str = "simulated"
) -> RadioLog:
    """What a receiver logs along given distances: (2) with coloured noise (8), white noise, and the receiver's limits.

    The path loss factor wanders about the channel's, the RSS is quantised, samples below the sensitivity or in lost
    packets are NaN. Coloured noise and wander start stationary. Distances below 0.1 m count as 0.1 m, as in the world.

    Parameters
    ----------
    distance_m : array, shape (n,) or (k, n)
        True distances, m.
    period_s : float
        Sampling period, s.
    channel : Channel, str, path or dict
        As `rss_gym.params.load_channel` takes it.
    seed, record : int
        Key of the noise, in [0, 2**63). Row i of a batch is record `record` + i, the same bit for bit alone.
    link : str
        Name in the log.

    Raises
    ------
    ParamsError
        For distances that are not positive, a period, seed or record out of range, or what is not a channel.
    """
    d, channel = distances(distance_m), load_channel(channel)
    period_s = positive("period_s", period_s, high=3600.0)
    rows = np.atleast_2d(d)
    seed, record = whole("seed", seed, 2**63), whole("record", record, 2**63 - len(rows))
    coloured = GaussMarkov(channel.coloured_variance_db2, channel.coloured_tc_s)
    wander_std, wander = channel.path_loss_wander, GaussMarkov(1.0, channel.path_loss_wander_tc_s)
    rss, noise = np.empty(rows.shape), np.empty(rows.shape)
    for i, row in enumerate(rows):
        _link(
            np.uint64(episode_key(SPLIT, np.uint64(seed), np.uint64(record + i))), row,
            channel.offset_dbm, channel.path_loss_factor, sqrt(channel.white_variance_db2),
            sqrt(coloured.variance_db2), coloured.decay(period_s), coloured.driving_std_db(period_s),
            wander_std, wander.decay(period_s), wander_std * wander.driving_std_db(period_s),
            channel.quantisation_db, channel.sensitivity_dbm, channel.packet_loss, rss[i], noise[i],
        )  # fmt: skip
    shape = d.shape
    return RadioLog(np.arange(shape[-1]) * period_s, rss.reshape(shape), d, noise.reshape(shape), link)


@kernel
def _link(  # type: ignore[no-untyped-def]
    key, distance_m, offset_dbm, path_loss_factor, white_std_db, coloured_std_db, coloured_decay, coloured_drive_db,
    wander_std, wander_decay, wander_drive, quantisation_db, sensitivity_dbm, packet_loss, rss_dbm, coloured_db,
):  # fmt: skip
    """Every sample of one record: the order of `links.transmit` and `links.receive`."""
    phi, wander = coloured_std_db * normal(key, START, 0), wander_std * normal(key, START, 1)
    for n in range(len(distance_m)):
        if n > 0:
            phi = gauss_markov(phi, coloured_decay, coloured_drive_db, normal(key, COLOURED, n))
            wander = gauss_markov(wander, wander_decay, wander_drive, normal(key, WANDER, n))
        rss = received_dbm(offset_dbm, path_loss_factor + wander, max(distance_m[n] * distance_m[n], 0.01))
        rss = quantise(rss + (phi + white_std_db * normal(key, WHITE, n)), quantisation_db)
        lost = rss < sensitivity_dbm or (packet_loss > 0.0 and uniform(key, LOSS, n) < packet_loss)
        rss_dbm[n], coloured_db[n] = np.nan if lost else rss, phi
