"""The paper's way from two points of a curve to lambda and sigma_w2 (below (11)), as printed.

The paper reads the points from Fig. 3, the Allan variance; but (11) is an autocovariance. On the rising part of an
Allan curve the method returns lambda > 0, a process that diverges. On two points of the autocovariance it works.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rss_gym.checks import Floats, finite, positive
from rss_gym.params import ParamsError
from rss_gym.radio.allan import AllanCurve


@dataclass(frozen=True)
class Autocovariance:
    """Sample autocovariance: values in dB^2, shape (m,), at lags of `lags` periods of `period_s`."""

    period_s: float
    lags: NDArray[np.int64]
    covariance_db2: Floats

    @property
    def tau_s(self) -> Floats:
        """Lags, s."""
        return self.lags * self.period_s


@dataclass(frozen=True)
class TwoPoint:
    """What two points give: lambda (1/s), sigma_w2 (dB; NaN if it diverges), and whether lambda >= 0."""

    lambda_ps: float
    sigma_w2_db: float
    diverges: bool


def autocovariance(values: Any, period_s: float, lags: int) -> Autocovariance:
    """Sample autocovariance of a record about its mean, at lags 0, 1, ..., `lags` periods.

    Parameters
    ----------
    values : array, shape (n,)
        Samples, dB.
    period_s : float
        Sampling period, s.
    lags : int
        The longest lag, in periods, below n.

    Raises
    ------
    ParamsError
        For values that are not finite or a lag out of range.
    """
    x = finite("values", values, dimensions=(1,))
    if isinstance(lags, bool) or not isinstance(lags, (int, np.integer)) or not 1 <= lags < len(x):
        raise ParamsError(f"lags must be a whole number from 1 to {len(x) - 1}, got {lags!r}")
    x = x - x.mean()
    sums = [x[: len(x) - k] @ x[k:] / len(x) for k in range(lags + 1)]
    return Autocovariance(positive("period_s", period_s), np.arange(lags + 1), np.array(sums))


def two_point(curve: AllanCurve | Autocovariance, tau_1_s: float, tau_2_s: float) -> TwoPoint:
    """(11) solved for lambda and sigma_w2 from the points of a curve nearest to two times.

    (11) at tau = Delta (n - m) is sigma_w2^2 e^{lambda (tau + 2 Delta)} / (1 - e^{2 lambda Delta}), so that lambda is
    the slope of its logarithm.

    Parameters
    ----------
    curve : AllanCurve or Autocovariance
        The first is the paper's choice, the second what (11) holds for.
    tau_1_s, tau_2_s : float
        Two times within the curve, s.

    Raises
    ------
    ParamsError
        If a time lies outside the curve, both mean one point, or the curve is not positive there.
    """
    values = curve.variance_db2 if isinstance(curve, AllanCurve) else curve.covariance_db2
    points = []
    for name, tau_s in (("tau_1_s", tau_1_s), ("tau_2_s", tau_2_s)):
        low, high = curve.tau_s[0], curve.tau_s[-1]
        if not low - 1e-9 <= tau_s <= high + 1e-9:
            raise ParamsError(f"{name} must lie within the curve, [{low:g}, {high:g}], got {tau_s!r}")
        points.append(int(np.argmin(np.abs(curve.tau_s - tau_s))))
    one, two = points
    if one == two:
        raise ParamsError(f"tau_1_s = {tau_1_s!r} and tau_2_s = {tau_2_s!r} are one point of the curve")
    if min(values[one], values[two]) <= 0.0:
        raise ParamsError(f"the curve must be positive at both times, got {values[one]:g} and {values[two]:g}")
    slope = float(math.log(values[two] / values[one]) / (curve.tau_s[two] - curve.tau_s[one]))
    if slope >= 0.0:
        return TwoPoint(slope, math.nan, True)
    delta = curve.period_s
    sigma_squared = -math.expm1(2.0 * slope * delta) * values[one] * math.exp(-slope * (curve.tau_s[one] + 2.0 * delta))
    return TwoPoint(slope, math.sqrt(sigma_squared), False)
