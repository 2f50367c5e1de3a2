"""Gauss-Markov noise (7)-(11), by its stationary variance S and correlation time Tc = -1 / lambda."""

from __future__ import annotations

import math
import numbers
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from rss_gym.checks import Floats, positive
from rss_gym.params import ParamsError
from rss_gym.physics import noise

# Beyond this many correlation times in one period a^2 = e^{2 lambda Delta} leaves the range of floating point.
_PERIODS_MAX = 300.0


@dataclass(frozen=True)
class GaussMarkov:
    """A stationary Gauss-Markov process.

    Parameters
    ----------
    variance_db2 : float
        Stationary variance S, dB^2.
    tc_s : float
        Correlation time Tc = -1 / lambda, s.

    Raises
    ------
    ParamsError
        Unless both are finite and above 0.
    """

    variance_db2: float
    tc_s: float

    def __post_init__(self) -> None:
        """Check both numbers."""
        object.__setattr__(self, "variance_db2", positive("variance_db2", self.variance_db2))
        object.__setattr__(self, "tc_s", positive("tc_s", self.tc_s))

    @classmethod
    def of_lambda(cls, lambda_ps: float, sigma_w2_db: float, period_s: float) -> Self:
        """The process of (8) by its coefficient lambda (1/s), driving noise sigma_w2 (dB) and period Delta (s).

        Raises
        ------
        ParamsError
            If lambda is not negative: (8) then diverges, as the text below (10) says.
        """
        if isinstance(lambda_ps, bool) or not isinstance(lambda_ps, numbers.Real) or not -math.inf < lambda_ps < 0.0:
            raise ParamsError(f"lambda_ps must be a finite number below 0, or the noise diverges, got {lambda_ps!r}")
        sigma, x = positive("sigma_w2_db", sigma_w2_db), -lambda_ps * positive("period_s", period_s)
        if x > _PERIODS_MAX:
            raise ParamsError(f"lambda_ps = {lambda_ps!r} leaves no correlation after period_s = {period_s:g}")
        return cls(sigma * sigma / math.expm1(2.0 * x), -1.0 / lambda_ps)  # (11) at lag 0

    @property
    def lambda_ps(self) -> float:
        """Lambda of (7), 1/s; negative."""
        return -1.0 / self.tc_s

    def decay(self, period_s: float) -> float:
        """Decay a = e^{lambda Delta} of (8) at the period Delta (s)."""
        if positive("period_s", period_s) > _PERIODS_MAX * self.tc_s:
            raise ParamsError(f"period_s must be at most {_PERIODS_MAX:g} times tc_s = {self.tc_s:g}, got {period_s!r}")
        return noise.decay(float(period_s), self.tc_s)

    def driving_std_db(self, period_s: float) -> float:
        """Driving noise sigma_w2 of (8) at the period Delta (s), dB: sigma_w2^2 = S (1 - a^2) / a^2."""
        return noise.driving_std(self.variance_db2, self.decay(period_s))

    def autocovariance(self, lag_s: Any) -> Floats:
        """(11), which is S e^{lambda |lag|}, dB^2, at lags in s (array of any shape)."""
        return self.variance_db2 * np.exp(-np.abs(np.asarray(lag_s, dtype=np.float64)) / self.tc_s)

    def covariance(self, m: Any, n: Any, period_s: float, initial_variance_db2: float) -> Floats:
        """R_phi(m, n) of (9)-(10): the process m and n periods after a start of given variance.

        Parameters
        ----------
        m, n : int or array of int
            Steps since the start, >= 0, in either order; they broadcast.
        period_s : float
            Delta, s.
        initial_variance_db2 : float
            E[phi(0)^2], dB^2; 0 for a known start, `variance_db2` for a stationary one.

        Returns
        -------
        ndarray
            a^(m+n) E[phi(0)^2] + S a^|n-m| (1 - a^(2 min(m, n))), the geometric sum of (10) closed, dB^2.
        """
        m, n = np.asarray(m), np.asarray(n)
        if m.dtype.kind not in "iu" or n.dtype.kind not in "iu" or min(m.min(), n.min()) < 0:
            raise ParamsError(f"m and n must be whole numbers of steps, at least 0, got {m} and {n}")
        if not (math.isfinite(initial_variance_db2) and initial_variance_db2 >= 0.0):
            raise ParamsError(f"initial_variance_db2 must be finite and at least 0, got {initial_variance_db2!r}")
        x = positive("period_s", period_s) / self.tc_s
        driven = self.variance_db2 * np.exp(-x * np.abs(n - m)) * -np.expm1(-2.0 * x * np.minimum(m, n))
        return np.exp(-x * (m + n)) * initial_variance_db2 + driven
