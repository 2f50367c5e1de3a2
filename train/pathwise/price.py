"""A smooth price of being near, in place of the steps that an sNMAC and a collision cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rss_gym.params import Params


@dataclass(frozen=True)
class SmoothPrice:
    """Sum of one logistic function for each event: half its price at its limit, all of it well inside.

    Parameters
    ----------
    prices_m : tuple of float
        Of an sNMAC and a collision, m.
    limits_m : tuple of float
        Separations below which they happen, m.
    softness_m : tuple of float
        Widths of the logistic functions, m.
    """

    prices_m: tuple[float, float]
    limits_m: tuple[float, float]
    softness_m: tuple[float, float]

    @classmethod
    def of(cls, params: Params, softness_m: float) -> SmoothPrice:
        """Of a world."""
        reward, events = params.reward, params.zone
        return cls(
            (reward.snmac_price_m, reward.collision_price_m),
            (events.snmac_horizontal_m, events.collision_m),
            (softness_m, softness_m),
        )

    def slope(self, separation_m: np.ndarray) -> np.ndarray:
        """Derivative of the price by the least separation, at most zero; shape as `separation_m`, infinity allowed."""
        total = np.zeros_like(separation_m)
        for price_m, limit_m, softness_m in zip(self.prices_m, self.limits_m, self.softness_m, strict=True):
            share = 1.0 / (1.0 + np.exp(np.clip((separation_m - limit_m) / softness_m, -60.0, 60.0)))
            total -= price_m / softness_m * share * (1.0 - share)
        return total
