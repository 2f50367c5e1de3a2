"""Range from a record of RSS, or from a batch of records: `track` runs any of `ESTIMATORS`.

>>> from rss_gym.params import load_channel
>>> tracked = track("ekf-coloured", [0.0, 0.1, 0.2], [-80.0, float("nan"), -81.0], load_channel("paper"))
>>> tracked.range_m.shape
(3,)
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rss_gym.checks import instance
from rss_gym.params import Channel, Clock, Group, ParamsError, Ranging, number
from rss_gym.ranging import ESTIMATORS, Estimator
from rss_gym.ranging.batch import Output, Setting

WORLD = Ranging()
TICK_S = Clock().tick_s
RSS_MAX_DBM = 1000.0  # far beyond any receiver; ranges overflow at some thousands
WHITE_VARIANCE_MIN_DB2 = 1e-6  # keeps R positive, as in the world


@dataclass(frozen=True, slots=True, kw_only=True)
class Tuning(Group):
    """What an estimator assumes beside the channel; the defaults are the world's at its tick.

    Process noise is Var(w) per second and grows with each interval; `_rate` is that of samples whose range rate is
    given. The fields `relative_` are those of ln d in "ekf-log": the world's at its range prior.
    """

    process_noise_m2_ps: float = number(WORLD.process_noise_m2 / TICK_S, 1e-9, 1e9)
    process_noise_rate_m2_ps: float = number(WORLD.process_noise_psi_m2 / TICK_S, 1e-9, 1e9)
    relative_noise_ps: float = number(WORLD.process_noise_m2 / TICK_S / WORLD.prior_range_m**2, 1e-12, 1e6)
    relative_noise_rate_ps: float = number(WORLD.process_noise_psi_m2 / TICK_S / WORLD.prior_range_m**2, 1e-12, 1e6)
    prior_range_m: float = number(WORLD.prior_range_m, 0.1, 1e5)
    prior_std_m: float = number(WORLD.prior_std_m, 1e-3, 1e5)
    range_floor_m: float = number(WORLD.range_floor_m, 0.01, 10.0)
    range_ceiling_m: float = number(1000.0, 10.0, 1e6)  # least squares inverts a deep fade to any distance
    window_s: float = number(5.0, 0.01, 3600.0)


@dataclass(frozen=True)
class RangeTrack:
    """What an estimator says at each sample, after using it. Shapes are (n,) for one record, (k, n) for a batch.

    Attributes
    ----------
    range_m, coloured_db : numpy.ndarray
        Range (m) and coloured noise (dB; NaN with "ls" and "ls-window", 0 with the white filters).
    covariance : numpy.ndarray
        (..., 3): p_xx, p_xp, p_pp of [x, coloured noise], x the range (m^2, m dB, dB^2) or, if `logarithmic`, its
        natural logarithm (1, dB, dB^2).
    innovation_db, innovation_variance_db2 : numpy.ndarray
        Sample minus its prediction and the variance stated for it; NaN at a missing sample and where nothing is
        predicted: least squares, and the first sample of a literal start.
    logarithmic : bool
        Whether the state is ln d.
    """

    range_m: np.ndarray
    coloured_db: np.ndarray
    covariance: np.ndarray
    innovation_db: np.ndarray
    innovation_variance_db2: np.ndarray
    logarithmic: bool = False

    @property
    def range_std_m(self) -> np.ndarray:
        """Standard deviation of the range, m; of first order if the state is ln d."""
        std = np.sqrt(self.covariance[..., 0])
        return self.range_m * std if self.logarithmic else std

    @property
    def nis(self) -> np.ndarray:
        """Normalised innovation squared: mean 1 for a consistent filter (chi-square, 1 degree of freedom)."""
        return self.innovation_db**2 / self.innovation_variance_db2

    def nees(self, range_true_m: ArrayLike, coloured_true_db: ArrayLike | None = None) -> np.ndarray:
        """Normalised estimation error squared, of ln d if `logarithmic`.

        Parameters
        ----------
        range_true_m : array_like
            True ranges, m, > 0; of the shape of `range_m` or one that broadcasts to it.
        coloured_true_db : array_like, optional
            True coloured noise, dB; then the error of both states is taken.

        Returns
        -------
        numpy.ndarray
            Mean 1 for a consistent filter, or 2 with `coloured_true_db`.

        Raises
        ------
        ParamsError
            For a shape that does not fit, ranges not above 0, or coloured noise of an estimator that has none.
        """
        truth = _like(self.range_m, "range_true_m", range_true_m)
        if np.any(truth <= 0.0):
            raise ParamsError(f"range_true_m must be above 0 m, got {truth.min()!r}")
        error = np.log(self.range_m / truth) if self.logarithmic else self.range_m - truth
        p_xx, p_xp, p_pp = np.moveaxis(self.covariance, -1, 0)
        if coloured_true_db is None:
            return error**2 / p_xx
        if not np.any(p_pp > 0.0):
            raise ParamsError("coloured_true_db is given but this estimator has no coloured noise in its state")
        other = self.coloured_db - _like(self.range_m, "coloured_true_db", coloured_true_db)
        return (p_pp * error**2 - 2.0 * p_xp * error * other + p_xx * other**2) / (p_xx * p_pp - p_xp**2)


def track(
    estimator: str,
    time_s: ArrayLike,
    rss_dbm: ArrayLike,
    channel: Channel,
    tuning: Tuning | None = None,
    range_rate_mps: ArrayLike | None = None,
) -> RangeTrack:
    """Run an estimator of range over one record or a batch of records.

    A prior start holds the prior until the first sample and is then updated in ln d, as in the world; a literal start
    has d(0) from that sample by inversion of (2), phi(0) = 0 and P(0) = I, and says nothing (NaN) before it.
    A row of a batch gets the same numbers, bit for bit, as the record alone.

    Parameters
    ----------
    estimator : str
        A name of `ESTIMATORS`.
    time_s : array_like
        Times of the samples, s, strictly increasing, regular or not. Shape (n,), or (k, n).
    rss_dbm : array_like
        RSS, dBm, NaN where a sample is missing. Shape (n,), or (k, n) for k records.
    channel : Channel
        Path loss, R, S and Tc; the rounding error of its `quantisation_db`, step^2 / 12, is added to R.
    tuning : Tuning, optional
        Default: the world's numbers.
    range_rate_mps : array_like, optional
        Range rate over the interval that ends at the sample, m/s, positive when the range grows, NaN where unknown:
        psi of (12) is this times the interval. Shape (n,), or (k, n). Least squares makes no use of it.

    Returns
    -------
    RangeTrack
        A track in the shape of `rss_dbm`.

    Raises
    ------
    ParamsError
        For an unknown estimator, a wrong type or shape, times that do not increase, infinite values, or RSS beyond
        1000 dBm on either side of 0.
    """
    chosen = ESTIMATORS.find(estimator)
    tuning = Tuning() if tuning is None else tuning
    instance("channel", channel, Channel)
    instance("tuning", tuning, Tuning)
    rss = _numbers("rss_dbm", rss_dbm)
    beyond = rss[np.abs(rss) > RSS_MAX_DBM]
    if beyond.size:
        raise ParamsError(f"rss_dbm must lie within {RSS_MAX_DBM:g} dBm of 0, got {beyond[0]:g}")
    if rss.ndim not in (1, 2) or rss.size == 0:
        raise ParamsError(f"rss_dbm must have the shape (n,) or (k, n) with at least one sample, got {rss.shape}")
    time = _rows("time_s", time_s, rss.shape)
    if np.isnan(time).any():
        raise ParamsError("time_s must be finite, got NaN")
    steps = np.diff(time)
    if not np.all(steps > 0.0):
        row, n = np.argwhere(~(steps > 0.0))[0]
        raise ParamsError(
            f"time_s must increase strictly, got {time[row, n + 1]:.9g} s after {time[row, n]:.9g} s at sample {n + 1}"
        )
    rate = np.full((1, rss.shape[-1]), np.nan)
    if range_rate_mps is not None:
        rate = _rows("range_rate_mps", range_rate_mps, rss.shape)
    shape = np.atleast_2d(rss).shape
    out = Output(*(np.full(size, np.nan) for size in (shape, shape, (*shape, 3), shape, shape)))
    chosen.run_records(time, np.atleast_2d(rss), rate, _setting(chosen, channel, tuning), out)
    if rss.ndim == 1:
        out = Output(*(array[0] for array in out))
    return RangeTrack(*out, chosen.logarithmic)


def _setting(chosen: Estimator, channel: Channel, tuning: Tuning) -> Setting:
    white = max(channel.white_variance_db2 + channel.quantisation_db**2 / 12.0, WHITE_VARIANCE_MIN_DB2)
    noise = (tuning.process_noise_m2_ps, tuning.process_noise_rate_m2_ps)
    if chosen.logarithmic:
        noise = (tuning.relative_noise_ps, tuning.relative_noise_rate_ps)
    return Setting(
        offset_dbm=channel.offset_dbm,
        path_loss_factor=channel.path_loss_factor,
        white_variance_db2=white + (channel.coloured_variance_db2 if chosen.white_is_total else 0.0),
        coloured_variance_db2=channel.coloured_variance_db2,
        coloured_tc_s=channel.coloured_tc_s,
        process_noise_ps=noise[0],
        process_noise_rate_ps=noise[1],
        prior_range_m=tuning.prior_range_m,
        prior_std_m=tuning.prior_std_m,
        range_floor_m=tuning.range_floor_m,
        range_ceiling_m=tuning.range_ceiling_m,
        window_s=tuning.window_s,
        literal=chosen.literal,
    )


def _numbers(name: str, values: Any) -> np.ndarray:
    """A copy as float64 in C order: one type of array, so that a kernel is compiled once."""
    try:
        array = np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise ParamsError(f"{name} must be an array of numbers, got {type(values).__name__}: {error}") from error
    if np.isinf(array).any():
        raise ParamsError(f"{name} must be finite or NaN, got an infinite value")
    return array


def _rows(name: str, values: Any, shape: tuple[int, ...]) -> np.ndarray:
    """As (1, n), which holds for every record, or (k, n)."""
    array = _numbers(name, values)
    if array.shape not in (shape, shape[-1:]):
        raise ParamsError(f"{name} must have the shape {shape[-1:]} or {shape} as rss_dbm has, got {array.shape}")
    return np.atleast_2d(array)


def _like(model: np.ndarray, name: str, values: Any) -> np.ndarray:
    array = _numbers(name, values)
    try:
        return np.broadcast_to(array, model.shape)
    except ValueError as error:
        raise ParamsError(f"{name} must have the shape {model.shape}, got {array.shape}") from error
