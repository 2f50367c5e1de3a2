"""The safety zone when successive errors are correlated, which (36)-(37) leave out.

The errors e_1, ..., e_n are a stationary normal Gauss-Markov sequence, of correlation rho between successive looks. The
probability that all exceed delta in size is the n-fold integral of its transition density over |x| > c, where c is
delta in standard deviations. Its symmetric form, discretised at Gauss-Legendre points (Nystroem's method), has
eigenvalues d_k in [0, 1), and the probability is sum_k s_k d_k^(n - 1).
"""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, exp, sqrt

import numpy as np
import numpy.typing as npt

from rss_gym.checks import finite, single
from rss_gym.params import ParamsError
from rss_gym.safety.zone import PROBABILITY, radius_m

CORRELATION_MAX = 0.9999  # the points needed grow as 1 / sqrt(1 - rho^2)
_TAIL = 9.0  # beyond c + 9 standard deviations lies less than 1e-17 of what lies beyond c


@lru_cache(maxsize=16)
def _spectrum(probability: float, correlation: float) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """s_k and d_k."""
    from scipy.special import ndtri, roots_legendre

    innovation = sqrt(1.0 - correlation * correlation)
    point, weight = roots_legendre(max(64, ceil(20.0 / innovation)))
    x = ndtri(0.5 * (1.0 + probability)) + 0.5 * _TAIL * (1.0 + point)
    density = np.sqrt(2.0 / np.pi) * np.exp(-0.5 * x * x)  # of |e|
    start = np.sqrt(0.5 * _TAIL * weight * density)
    # Joint density of (|e_1|, |e_2|) over the root of the product of their own, in one exponent: neither overflows.
    square, product = np.add.outer(x * x, x * x), np.multiply.outer(x, x)
    scale = 2.0 * innovation * innovation
    ratio = sum(
        np.exp((2.0 * sign * correlation * product - square) / scale + 0.25 * square) for sign in (1.0, -1.0)
    ) / (innovation * sqrt(2.0 * np.pi))
    root = np.sqrt(0.5 * _TAIL * weight)
    decay, vectors = np.linalg.eigh(root[:, None] * ratio * root)
    return (start @ vectors) ** 2, np.maximum(decay, 0.0)  # below zero by rounding only


def _correlation(value: float, name: str = "correlation") -> float:
    return single(name, value, 0.0, CORRELATION_MAX)


def miss_probability_correlated(
    range_error_probability: float, trials: npt.ArrayLike, correlation: float
) -> npt.NDArray[np.float64]:
    """Probability that `trials` successive errors all exceed delta: (32) without independence.

    Parameters
    ----------
    range_error_probability : float
        P(delta) of (31), of one error, which is normal.
    trials : array_like
        Numbers of looks n >= 1.
    correlation : float
        rho between successive looks, 0 to 0.9999; a lag of m looks has rho^m.

    Returns
    -------
    ndarray or float
        The probabilities, in the shape of `trials`. For rho = 0 they are (32).

    Raises
    ------
    ParamsError
        When an argument is out of its range.
    """
    probability = single("range_error_probability", range_error_probability, *PROBABILITY)
    shares, decay = _spectrum(probability, _correlation(correlation))
    return (decay ** (finite("trials", trials, 1.0)[..., None] - 1.0)) @ shares


@dataclass(frozen=True)
class CorrelatedZone:
    """Looks and radius that meet a collision probability when errors are correlated."""

    correlation: float  # between successive looks
    trials: int
    miss_probability: float
    radius_m: float
    duration_s: float  # from the first look to the last
    closing_s: float  # from the edge of the zone to contact, at the largest relative speed

    @property
    def in_time(self) -> bool:
        """Whether the last look comes before contact; looks more than t_r + delta / (P |v|) apart come too late."""
        return self.duration_s <= self.closing_s


def correlated_zone(
    range_error_m: float,
    range_error_probability: float,
    speed_relative_mps: float,
    reaction_s: float,
    collision_probability: float,
    correlation_time_s: float,
    spacing_s: float,
) -> CorrelatedZone:
    """The radius (40) with as many looks as correlated errors need, in place of (37).

    Parameters
    ----------
    range_error_m, range_error_probability, speed_relative_mps, reaction_s : float
        delta, P(delta), |v| > 0 and t_r as in `radius_m`.
    collision_probability : float
        The miss probability to fall to.
    correlation_time_s : float
        Time in which the correlation of the errors falls to 1/e, > 0.
    spacing_s : float
        Time between looks, > 0: rho = exp(-spacing / correlation time).

    Raises
    ------
    ParamsError
        When an argument is out of its range, or the looks follow faster than 1e-4 of the correlation time.
    """
    probability = single("range_error_probability", range_error_probability, *PROBABILITY)
    target = single("collision_probability", collision_probability, 1e-300, 1.0 - 1e-9)
    speed = single("speed_relative_mps", speed_relative_mps, 1e-9)
    tc_s, spacing = single("correlation_time_s", correlation_time_s, 1e-9), single("spacing_s", spacing_s, 1e-9)
    correlation = exp(-spacing / tc_s)
    if correlation > CORRELATION_MAX:
        raise ParamsError(f"spacing_s must be above 1e-4 of correlation_time_s = {tc_s:g}, got {spacing_s!r}")
    shares, decay = _spectrum(probability, correlation)

    def miss(n: int) -> float:
        return float(decay ** (n - 1) @ shares)

    high = 1
    while miss(high) > target * (1.0 + 1e-10):  # a target that is met to rounding is met
        high *= 2
    low = high // 2  # the last one that did not do, or 0
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if miss(middle) <= target * (1.0 + 1e-10) else (middle, high)
    radius = float(radius_m(range_error_m, probability, speed, reaction_s, high))
    return CorrelatedZone(correlation, high, miss(high), radius, (high - 1) * spacing, radius / speed)
