"""The cost of a drive in metres, as the world's: the mean deviation and the prices of a near miss and a collision."""

from __future__ import annotations

from rss_gym.params import Reward


class Cost:
    """The cost of a drive so far; the reward of a decision is minus what the cost rises by.

    Parameters
    ----------
    prices : Reward
        Of which a road knows `deviation_price`, `snmac_price_m` (of a near miss) and `collision_price_m`.
    decisions : int, optional
        Of a whole drive. The term of the deviation is then its sum so far over these in place of its mean so far, and a
        metre costs the same at every decision: rewards of trainings do not depend on how long a drive has lasted.

    Attributes
    ----------
    terms : dict
        The terms of the cost so far, m: `deviation`, `snmac`, `collision`.
    changes : dict
        What the last decision added to each; their sum is minus its reward.
    deviation_mean_m : float
        Mean over the decisions so far of the distance from where the planned lane and speed would have led.
    """

    def __init__(self, prices: Reward, decisions: int | None = None) -> None:
        self.prices, self.decisions = prices, decisions
        self.terms = dict.fromkeys(("deviation", "snmac", "collision"), 0.0)
        self.changes = dict(self.terms)
        self.deviation_mean_m = 0.0
        self._sum_m, self._decisions = 0.0, 0

    @property
    def total_m(self) -> float:
        """The cost, m."""
        return sum(self.terms.values())

    def decided(self, deviation_m: float, snmac: bool, collision: bool) -> float:
        """Account for a decision; both events are of the whole drive so far. Returns its reward."""
        self._sum_m, self._decisions = self._sum_m + deviation_m, self._decisions + 1
        self.deviation_mean_m = self._sum_m / self._decisions
        before, total_m, prices = self.terms, self.total_m, self.prices
        self.terms = {
            "deviation": prices.deviation_price * self._sum_m / (self.decisions or self._decisions),
            "snmac": prices.snmac_price_m * snmac,
            "collision": prices.collision_price_m * collision,
        }
        self.changes = {name: value - before[name] for name, value in self.terms.items()}
        return total_m - self.total_m
