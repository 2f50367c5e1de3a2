"""A smooth price of each event, in place of the steps that an sNMAC and a collision cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from rss_gym.eval.metrics.unnecessary_manoeuvre_rate import MANOEUVRE_M
from rss_gym.params import Params

MANOEUVRE_SOFTNESS_M = 1.8  # the limit is at 3 m; a flight without a manoeuvre is priced at a twentieth


@dataclass(frozen=True)
class SmoothPrice:
    """Sum of one normal distribution function for each of `EVENTS`: half its price at its limit, all of it well inside.

    It is the price that is expected where the margin has a normal error of that standard deviation.

    Parameters
    ----------
    prices_m : tuple of float
        The prices of the events, m.
    limits_m : tuple of float
        Margins below which they happen, m.
    softness_m : tuple of float
        Standard deviations of these functions, m.
    sigmas : float
        Width that is added in quadrature to those of sNMAC and collision, in standard deviations of the track where
        the margin is least: the less is known of the intruder, the softer is the price.
    """

    prices_m: tuple[float, float, float]
    limits_m: tuple[float, float, float]
    softness_m: tuple[float, float, float]
    sigmas: float = 0.0

    @classmethod
    def of(cls, params: Params, softness_m: float, manoeuvre_price_m: float, sigmas: float) -> SmoothPrice:
        """Of a world, which has no price of a manoeuvre itself."""
        reward, events = params.reward, params.zone
        return cls(
            (reward.snmac_price_m, reward.collision_price_m, manoeuvre_price_m),
            (events.snmac_horizontal_m, events.collision_m, -MANOEUVRE_M),
            (softness_m, softness_m, MANOEUVRE_SOFTNESS_M),
            sigmas,
        )

    def slope(self, margins_m: np.ndarray, std_m: np.ndarray) -> np.ndarray:
        """Derivatives of the price by the least margins (n, 3) of `EVENTS`, at most zero; infinity is allowed.

        `std_m` (n, 3) is the standard deviation of the track where each margin is least.
        """
        softness_m = np.hypot(self.softness_m, np.array([self.sigmas, self.sigmas, 0.0]) * std_m)
        excess = (margins_m - np.array(self.limits_m)) / softness_m
        slopes: np.ndarray = -np.array(self.prices_m) / softness_m * norm.pdf(excess)
        return slopes
