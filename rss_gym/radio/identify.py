"""White plus Gauss-Markov noise found from the whole Allan curve, with standard errors.

In place of the two points of Sec. III (see `two_point`): R, S and Tc are fitted to every point, in the logarithm and
weighted by the degrees of freedom. The points of a curve are correlated, so the standard errors come from their
covariance under the fitted noise, not from the weights.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from rss_gym.checks import Floats
from rss_gym.params import ParamsError
from rss_gym.radio.allan import AllanCurve, allan_covariance, allan_model, unit_allan
from rss_gym.radio.gauss_markov import GaussMarkov

# Of the mean square of n Tc seconds of Gauss-Markov noise the relative error is sqrt(2 / n): 20 % at 50.
DURATION_TC = 50.0
MISFIT = 0.01  # below this p-value the curve is not that of the model
_FLOOR = 1e-6  # a variance below this share of the Allan curve's largest value counts as none


@dataclass(frozen=True)
class NoiseFit:
    """White variance R, Gauss-Markov variance S and time Tc, each with its standard error.

    `misfit` is the p-value of the curve's deviations from the model: small if the noise is not white plus Gauss-Markov.
    `warnings` are sentences on what the record cannot tell.
    """

    white_variance_db2: float
    white_variance_std_db2: float
    coloured_variance_db2: float
    coloured_variance_std_db2: float
    coloured_tc_s: float
    coloured_tc_std_s: float
    curve: AllanCurve
    misfit: float
    warnings: tuple[str, ...]

    @property
    def noise(self) -> GaussMarkov:
        """The coloured part."""
        return GaussMarkov(self.coloured_variance_db2, self.coloured_tc_s)

    @property
    def model_db2(self) -> Floats:
        """The fitted Allan variance at the clusters of the curve, dB^2."""
        return allan_model(self.curve.clusters, self.white_variance_db2, self.noise, self.curve.period_s)


def identify(curve: AllanCurve) -> NoiseFit:
    """Fit white plus Gauss-Markov noise to a whole Allan curve.

    Parameters
    ----------
    curve : AllanCurve
        At least 4 clusters, of one record or of several pooled.

    Returns
    -------
    NoiseFit
        Standard errors are first-order. A part that the curve does not show comes out at (nearly) zero.

    Raises
    ------
    ParamsError
        For fewer than 4 clusters, or a curve with a zero: a constant record has no noise to fit.
    """
    from scipy.optimize import least_squares
    from scipy.special import digamma

    if len(curve.clusters) < 4:
        raise ParamsError(f"the Allan curve must have at least 4 clusters, got {len(curve.clusters)}; record longer")
    if not (curve.variance_db2 > 0.0).all():
        raise ParamsError("the Allan curve must be positive everywhere; a constant record has no noise to fit")
    half = 0.5 * curve.freedom
    # The logarithm of a chi-square variable of F degrees of freedom is low by log(F/2) - digamma(F/2).
    measured, weight = np.log(curve.variance_db2) + np.log(half) - digamma(half), np.sqrt(half)
    top = float(curve.variance_db2.max())
    longest_s = max(curve.lengths) * curve.period_s
    low = np.log([_FLOOR * top, _FLOOR * top, 0.5 * curve.period_s])
    high = np.log([1e3 * top, 1e3 * top, 10.0 * longest_s])

    def model(point: Floats) -> Floats:
        white, variance, tc_s = np.exp(point)
        return np.log(allan_model(curve.clusters, white, GaussMarkov(variance, tc_s), curve.period_s))

    start = np.clip(_start(curve, np.exp(measured), np.exp(low[2]), np.exp(high[2])), low + 1e-3, high - 1e-3)
    fit = least_squares(lambda point: weight * (model(point) - measured), start, bounds=(low, high))
    white, variance, tc_s = (float(x) for x in np.exp(fit.x))
    errors, misfit = _errors(curve, white, GaussMarkov(variance, tc_s), weight, weight * (model(fit.x) - measured))
    found = NoiseFit(white, errors[0], variance, errors[1], tc_s, errors[2], curve, misfit, ())
    return replace(found, warnings=_warnings(found))


def _start(curve: AllanCurve, measured: Floats, tc_low_s: float, tc_high_s: float) -> Floats:
    """Logarithms of (R, S, Tc) at the best of many Tc, where R and S are a linear problem."""
    weight = curve.freedom / measured**2
    white = 1.0 / curve.clusters
    times = np.geomspace(tc_low_s, tc_high_s, 60)
    coloured = unit_allan(curve.clusters.astype(np.float64), curve.period_s / times[:, None])
    ww, wc, cc = weight @ (white * white), coloured @ (weight * white), (coloured * coloured) @ weight
    wy, cy = weight @ (white * measured), coloured @ (weight * measured)
    r, s = cc * wy - wc * cy, ww * cy - wc * wy  # times the determinant
    scale = 1.0 / np.maximum(ww * cc - wc * wc, 1e-12 * ww * cc)
    r, s = (
        np.where(s < 0.0, wy / ww, np.maximum(r * scale, 0.0)),
        np.where(r < 0.0, cy / cc, np.maximum(s * scale, 0.0)),
    )
    cost = ((measured - r[:, None] * white - s[:, None] * coloured) ** 2) @ weight
    best = int(np.argmin(cost))
    return np.log([max(r[best], 1e-300), max(s[best], 1e-300), times[best]])


def _errors(
    curve: AllanCurve, white: float, noise: GaussMarkov, weight: Floats, residual: Floats
) -> tuple[list[float], float]:
    """Standard errors of (R, S, Tc), and the p-value of the weighted square sum of the residuals."""
    from scipy.special import chdtrc

    m, x, step = curve.clusters.astype(np.float64), curve.period_s / noise.tc_s, 1e-4
    model = allan_model(m, white, noise, curve.period_s)
    slope_x = (unit_allan(m, x * (1.0 + step)) - unit_allan(m, x * (1.0 - step))) / (2.0 * step * x)
    slopes = np.stack([1.0 / m, unit_allan(m, x), -noise.variance_db2 * slope_x * x / noise.tc_s], axis=1)
    jacobian = weight[:, None] * slopes / model[:, None]
    covariance = np.outer(weight / model, weight / model) * allan_covariance(curve, white, noise)
    size = np.linalg.norm(jacobian, axis=0) + 1e-300
    inverse = np.linalg.pinv(jacobian / size)
    spread = inverse @ covariance @ inverse.T
    errors = [float(x) for x in np.sqrt(np.diag(spread)) / size]
    # The square sum is a quadratic form; a chi-square variable of its mean and variance stands for it (Satterthwaite).
    basis, _ = np.linalg.qr(jacobian / size)
    project = np.eye(len(m)) - basis @ basis.T
    form = project @ covariance @ project
    mean, half_variance = float(np.trace(form)), float(np.sum(form * form))
    return errors, float(chdtrc(mean * mean / half_variance, float(residual @ residual) * mean / half_variance))


def _warnings(fit: NoiseFit) -> tuple[str, ...]:
    """What the record cannot tell, one sentence each."""
    curve, found = fit.curve, []
    duration_s, tc_s = sum(curve.lengths) * curve.period_s, fit.coloured_tc_s
    if fit.coloured_variance_db2 < 2.0 * fit.coloured_variance_std_db2:
        found.append(
            f"coloured noise is not told from none: its variance is {fit.coloured_variance_db2:.3g} dB^2 with a "
            f"standard error of {fit.coloured_variance_std_db2:.3g}"
        )
    if duration_s < DURATION_TC * tc_s:
        found.append(
            f"the record of {duration_s:.3g} s is short for a correlation time of {tc_s:.3g} s: it should last "
            f"{DURATION_TC * tc_s:.3g} s, which fixes the coloured variance to {math.sqrt(2.0 / DURATION_TC):.0%}"
        )
    if tc_s < curve.period_s:
        found.append(
            f"the correlation time is below the period of {curve.period_s:.3g} s: white and coloured noise look alike"
        )
    if fit.misfit < MISFIT:
        found.append(
            f"the Allan curve is not that of white plus one Gauss-Markov noise (p = {fit.misfit:.1g}): the three "
            "numbers are a rough model"
        )
    return tuple(found)
