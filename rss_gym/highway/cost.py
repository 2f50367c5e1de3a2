"""The cost of a drive in metres, as the world's: the mean deviation and the prices of a near miss and a collision."""

from __future__ import annotations

from dataclasses import dataclass

from rss_gym.params import Group, number


@dataclass(frozen=True, slots=True, kw_only=True)
class RoadReward(Group):
    """What makes the cost of a drive; the reward of a decision is minus what the cost rises by."""

    deviation_price: float = number(1.0, 0.0, 1e6)  # per metre of mean deviation
    near_miss_price_m: float = number(100.0, 0.0, 1e9)
    collision_price_m: float = number(10_000.0, 0.0, 1e9)


class Cost:
    """The cost of a drive so far.

    Parameters
    ----------
    prices : RoadReward

    Attributes
    ----------
    terms : dict
        Of the cost so far, m: `deviation`, `near_miss`, `collision`.
    changes : dict
        What the last decision added to each; their sum is minus its reward.
    deviation_mean_m : float
        Mean over the decisions so far of the distance from where the planned lane and speed would have led.
    """

    def __init__(self, prices: RoadReward) -> None:
        self.prices = prices
        self.terms = dict.fromkeys(("deviation", "near_miss", "collision"), 0.0)
        self.changes = dict(self.terms)
        self.deviation_mean_m = 0.0
        self._sum_m, self._decisions = 0.0, 0

    @property
    def total_m(self) -> float:
        """The cost, m."""
        return sum(self.terms.values())

    def decided(self, deviation_m: float, near_miss: bool, collision: bool) -> float:
        """Account for a decision; both events are of the whole drive. Returns its reward."""
        self._sum_m, self._decisions = self._sum_m + deviation_m, self._decisions + 1
        self.deviation_mean_m = self._sum_m / self._decisions
        before, total_m, prices = self.terms, self.total_m, self.prices
        self.terms = {
            "deviation": prices.deviation_price * self.deviation_mean_m,
            "near_miss": prices.near_miss_price_m * near_miss,
            "collision": prices.collision_price_m * collision,
        }
        self.changes = {name: value - before[name] for name, value in self.terms.items()}
        return total_m - self.total_m
