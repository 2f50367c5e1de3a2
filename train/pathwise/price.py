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

    def slope(self, separations_m: np.ndarray) -> np.ndarray:
        """Derivatives of the price by the least separations (n, 2) of `EVENTS`, at most zero; infinity is allowed."""
        softness_m = np.array(self.softness_m)
        excess = np.clip((separations_m - np.array(self.limits_m)) / softness_m, -60.0, 60.0)
        share = 1.0 / (1.0 + np.exp(excess))
        slopes: np.ndarray = -np.array(self.prices_m) / softness_m * share * (1.0 - share)
        return slopes
