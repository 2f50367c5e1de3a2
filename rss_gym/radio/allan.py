"""The overlapping Allan variance (4), its interval (5)-(6), and what white plus Gauss-Markov noise should show.

The paper prints (4) without its average over k and takes the sampling frequency for the number of clusters. This is
the standard estimator: Riley, "Handbook of Frequency Stability Analysis", NIST SP 1065 (2008), equation (11).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rss_gym.checks import Floats, finite, positive
from rss_gym.params import ParamsError
from rss_gym.radio.gauss_markov import GaussMarkov

# Series of 2y - 3 + 4 e^-y - e^-2y from y^3 on, highest power first.
_SERIES = [(4.0 - 2.0**k) * (-1.0) ** k / math.factorial(k) for k in range(22, 2, -1)] + [0.0, 0.0, 0.0]


@dataclass(frozen=True)
class AllanCurve:
    """Allan variance over cluster length.

    Parameters
    ----------
    period_s : float
        Sampling period Delta, s.
    clusters : ndarray of int64, shape (m,)
        Samples in a cluster.
    variance_db2 : ndarray, shape (m,)
        Allan variance, dB^2.
    differences : ndarray of int64, shape (m,)
        Overlapping pairs of clusters that were averaged.
    freedom : ndarray, shape (m,)
        Degrees of freedom F of (5); see `allan_curve`.
    lengths : tuple of int
        Samples in each record.
    """

    period_s: float
    clusters: NDArray[np.int64]
    variance_db2: Floats
    differences: NDArray[np.int64]
    freedom: Floats
    lengths: tuple[int, ...]

    @property
    def tau_s(self) -> Floats:
        """Cluster lengths tau = m Delta, s."""
        return self.clusters * self.period_s

    def interval(self, confidence: float = 0.95) -> tuple[Floats, Floats]:
        """(6), two-sided: low and high end of the true Allan variance, dB^2.

        The text below (6) sets one quantile at epsilon and the other at 1 - epsilon; here each side has half of
        1 - `confidence`.
        """
        from scipy.special import chdtri

        if not 0.0 < confidence < 1.0:
            raise ParamsError(f"confidence must lie between 0 and 1, got {confidence!r}")
        side = 0.5 * (1.0 - confidence)
        scaled = self.freedom * self.variance_db2
        return scaled / chdtri(self.freedom, side), scaled / chdtri(self.freedom, 1.0 - side)


def allan_curve(values: Any, period_s: float, clusters: Sequence[int] | None = None) -> AllanCurve:
    """Overlapping Allan variance (4) of one record, or of several pooled.

    Parameters
    ----------
    values : array, shape (n,), or list of such arrays
        Samples at a constant period, dB; no difference reaches from one record into the next.
    period_s : float
        Sampling period, s.
    clusters : sequence of int, optional
        Samples in a cluster, rising; by default 1, 2, 4, ... up to a third of the longest record.

    Returns
    -------
    AllanCurve
        `freedom` is the smaller of the published values for white noise and for a random walk (NIST SP 1065, table 5),
        summed over the records. White plus Gauss-Markov noise lies between the two, so that the interval (6) is not
        too short for it: it is exact for white noise at one sample, and for a random walk at long clusters.

    Raises
    ------
    ParamsError
        For values that are not finite, records or clusters that leave no difference, or a period that is not positive.
    """
    period_s = positive("period_s", period_s)
    several = isinstance(values, (list, tuple)) and len(values) > 0 and np.ndim(values[0]) > 0
    records = [finite("values", record, dimensions=(1,)) for record in (values if several else [values])]
    longest = max(map(len, records))
    if longest < 3:
        raise ParamsError(f"values must hold at least 3 samples in a row, got {longest}")
    m = _clusters(clusters, longest)
    squares, differences, freedom = np.zeros(len(m)), np.zeros(len(m), np.int64), np.zeros(len(m))
    for record in records:
        n = len(record)
        # The sums of clusters are differences of this; the mean goes first, or its size costs digits.
        total = np.concatenate(([0.0], np.cumsum(record - record.mean())))
        for i in np.flatnonzero(2 * m <= n):
            step = total[2 * m[i] :] - 2.0 * total[m[i] : -m[i]] + total[: -2 * m[i]]
            squares[i] += np.sum(step * step)
            differences[i] += len(step)
            freedom[i] += _freedom(n, int(m[i]))
    return AllanCurve(
        period_s, m, squares / (2.0 * m * m * differences), differences, freedom, tuple(map(len, records))
    )


def _clusters(clusters: Sequence[int] | None, longest: int) -> NDArray[np.int64]:
    if clusters is None:
        return 2 ** np.arange(int(math.log2(longest // 3)) + 1, dtype=np.int64)
    m = np.asarray(clusters)
    if m.ndim != 1 or m.dtype.kind not in "iu" or m.size == 0 or m[0] < 1 or (np.diff(m) <= 0).any():
        raise ParamsError(f"clusters must be rising whole numbers from 1 on, got {clusters!r}")
    if 2 * m[-1] > longest:
        raise ParamsError(f"clusters must be at most half of the longest record, {longest // 2}, got {m[-1]}")
    return m.astype(np.int64)


def _freedom(n: int, m: int) -> float:
    """Degrees of freedom of n samples in overlapping clusters of m: NIST SP 1065, table 5, the smaller of two."""
    phases = n + 1
    white = (1.5 * n / m - 2.0 * (phases - 2) / phases) * 4.0 * m * m / (4.0 * m * m + 5.0)
    walk = (phases - 2) * (n * n - 3.0 * m * n + 4.0 * m * m) / (m * (phases - 3.0) ** 2) if n > 2 else 1.0
    return max(min(white, walk), 1.0)


def allan_model(clusters: Any, white_variance_db2: float, noise: GaussMarkov, period_s: float) -> Floats:
    """The exact Allan variance of white plus Gauss-Markov noise sampled at a period.

    With x = Delta / Tc and clusters of m samples it is R / m + S (2 m sinh x - 3 + 4 e^{-m x} - e^{-2 m x}) /
    (2 m sinh(x / 2))^2: half the variance of the difference of two adjacent means, the autocovariance (11) summed.

    Parameters
    ----------
    clusters : array of int, shape (m,)
        Samples in a cluster.
    white_variance_db2 : float
        R, dB^2.
    noise : GaussMarkov
        S and Tc.
    period_s : float
        Delta, s.

    Returns
    -------
    ndarray, shape (m,)
        Allan variance, dB^2.
    """
    m = np.asarray(clusters, dtype=np.float64)
    return white_variance_db2 / m + noise.variance_db2 * unit_allan(m, period_s / noise.tc_s)


def unit_allan(m: Floats, x: float | Floats) -> Floats:
    """Allan variance of (11) with S = 1 at x = Delta / Tc; `m` and `x` broadcast."""
    x = np.minimum(x, 500.0)  # from 40 on it is 1 / m to the last digit
    y = m * x
    # Both terms are of third order in x: series where the closed forms cancel.
    means = np.where(
        y < 0.5, np.polyval(_SERIES, np.minimum(y, 0.5)), 2.0 * y - 3.0 + 4.0 * np.exp(-y) - np.exp(-2 * y)
    )
    square = x * x
    excess = np.where(
        x < 0.5,
        x
        * square
        / 6.0
        * (1.0 + square / 20.0 * (1.0 + square / 42.0 * (1.0 + square / 72.0 * (1.0 + square / 110.0)))),
        np.sinh(x) - x,
    )
    return (2.0 * m * excess + means) / (2.0 * m * np.sinh(0.5 * x)) ** 2


def allan_covariance(curve: AllanCurve, white_variance_db2: float, noise: GaussMarkov) -> Floats:
    """Covariance of the points of a curve, if its records are white plus Gauss-Markov noise, dB^4.

    A difference of cluster means is a linear filter of the samples, so that the covariance r(k) of two of them, k
    samples apart, is known; that of their squares is 2 r(k)^2 (Isserlis), summed here over all pairs of all records.

    Returns
    -------
    ndarray, shape (m, m)
    """
    from scipy.fft import irfft, next_fast_len, rfft

    longest = max(curve.lengths)
    size = next_fast_len(2 * longest, real=True)
    lag = np.minimum(np.arange(size), size - np.arange(size))
    covariance = noise.autocovariance(lag * curve.period_s) + np.where(lag == 0, white_variance_db2, 0.0)
    filters = np.zeros((len(curve.clusters), size))
    for i, m in enumerate(curve.clusters):
        filters[i, :m], filters[i, m : 2 * m] = -math.sqrt(0.5) / m, math.sqrt(0.5) / m
    spectra, power = rfft(filters), rfft(covariance).real
    k = np.arange(size)
    k[k > size // 2] -= size
    records = Counter(curve.lengths)
    result = np.empty((len(curve.clusters),) * 2)
    for i, m in enumerate(curve.clusters):
        r = irfft(spectra[i] * power * spectra[i:].conj(), size)
        for j, other in enumerate(curve.clusters[i:], start=i):
            pairs = sum(count * _pairs(n + 1 - 2 * m, n + 1 - 2 * other, k) for n, count in records.items())
            # Not a dot product: BLAS would start threads for it, which costs more than it saves.
            result[i, j] = result[j, i] = 2.0 * np.sum(pairs * r[j - i] * r[j - i])
    return result / np.outer(curve.differences, curve.differences)


def _pairs(first: int, second: int, k: NDArray[np.int64]) -> NDArray[np.int64]:
    """Number of pairs (i, i + k) with i in [0, first) and i + k in [0, second)."""
    return np.maximum(np.minimum(first, second - k) - np.maximum(0, -k), 0)
