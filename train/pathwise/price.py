"""A smooth price of each event, in place of the steps that an sNMAC and a collision cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rss_gym.eval.metrics.unnecessary_manoeuvre_rate import MANOEUVRE_M
from rss_gym.params import Params

MANOEUVRE_SOFTNESS_M = 1.0  # the limit is at 3 m; a flight without a manoeuvre is priced at a twentieth


@dataclass(frozen=True)
class SmoothPrice:
    """Sum of one logistic function for each of `EVENTS`: half its price at its limit, all of it well inside.

    Parameters
    ----------
    prices_m : tuple of float
        The prices of the events, m.
    limits_m : tuple of float
        Margins below which they happen, m.
    softness_m : tuple of float
        Widths of the logistic functions, m.
    """

    prices_m: tuple[float, float, float]
    limits_m: tuple[float, float, float]
    softness_m: tuple[float, float, float]

    @classmethod
    def of(cls, params: Params, softness_m: float, manoeuvre_price_m: float) -> SmoothPrice:
        """Of a world, which has no price of a manoeuvre itself."""
        reward, events = params.reward, params.zone
        return cls(
            (reward.snmac_price_m, reward.collision_price_m, manoeuvre_price_m),
            (events.snmac_horizontal_m, events.collision_m, -MANOEUVRE_M),
            (softness_m, softness_m, MANOEUVRE_SOFTNESS_M),
        )

    def slope(self, margins_m: np.ndarray) -> np.ndarray:
        """Derivatives of the price by the least margins (n, 3) of `EVENTS`, at most zero; infinity is allowed."""
        softness_m = np.array(self.softness_m)
        excess = np.clip((margins_m - np.array(self.limits_m)) / softness_m, -60.0, 60.0)
        share = 1.0 / (1.0 + np.exp(excess))
        slopes: np.ndarray = -np.array(self.prices_m) / softness_m * share * (1.0 - share)
        return slopes
