"""The cost of an encounter in metres, by which policies are ranked, and intervals of its mean.

    cost = deviation price * mean |u - u^d| while flown + sNMAC price * (sNMAC) + collision price * (collision)

The deviation varies by metres from one encounter to the next, a collision is rare and adds ten thousand: Student's
interval of the whole covers far too seldom, and with no collision seen it would say that there never is one. So each
part has its own interval (Student's for the deviation, Clopper and Pearson's for the events), and these are joined.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import fsum
from typing import Any

import numpy as np

from rss_gym.eval.intervals import Interval, Part, clopper_pearson, mean_t, sum_of_means
from rss_gym.params import Params


@dataclass(frozen=True, slots=True)
class Prices:
    """What the parts of a cost weigh.

    Attributes
    ----------
    deviation : float
        Per metre of mean deviation.
    snmac_m, collision_m : float
        The prices of an encounter with the event.
    """

    deviation: float = 1.0
    snmac_m: float = 100.0
    collision_m: float = 10_000.0

    @classmethod
    def of(cls, params: Params) -> Prices:
        """Those of a world."""
        reward = params.reward
        return cls(reward.deviation_price, reward.snmac_price_m, reward.collision_price_m)


SCORE = Prices()  # those of every suite


def cost_m(deviation_mean_m: Any, snmac: Any, collision: Any, prices: Prices = SCORE) -> Any:
    """Cost of encounters with these mean deviations and events."""
    return prices.deviation * deviation_mean_m + prices.snmac_m * snmac + prices.collision_m * collision


@dataclass(frozen=True, eq=False)
class Costs:
    """The costs of one policy's flights, in the order of their encounters.

    Attributes
    ----------
    cost_m : (n,) array
    snmac, collision : (n,) bool array
    prices : Prices
        By which `cost_m` was made.
    """

    cost_m: np.ndarray
    snmac: np.ndarray
    collision: np.ndarray
    prices: Prices = SCORE

    @classmethod
    def of(cls, table: np.ndarray, prices: Prices = SCORE) -> Costs:
        """Those of an episode table, without keeping it in memory."""
        return cls(table["cost_m"].copy(), table["snmac"].copy(), table["collision"].copy(), prices)

    def __len__(self) -> int:
        return len(self.cost_m)

    @property
    def mean_m(self) -> float:
        """Mean, correctly rounded, so that no order of the encounters changes it."""
        return fsum(self.cost_m.tolist()) / len(self)

    @property
    def deviation_m(self) -> np.ndarray:
        """What is left of the costs without the events. Shape (n,)."""
        return self.cost_m - cost_m(0.0, self.snmac, self.collision, self.prices)

    def interval(self) -> Interval:
        """Mean, with the ends of `sum_of_means`: Student's for the deviation, Clopper and Pearson's for the events."""
        if len(self) == 0:
            return Interval(None, None, None, 0)
        found = sum_of_means([_mean(self.deviation_m), *self._events()], self.mean_m)
        return found if found.low is None else found._replace(low=min(max(found.low, 0.0), self.mean_m))

    def minus(self, other: Costs) -> Interval:
        """Mean difference to another policy on the same encounters.

        Only encounters with an event in one of the two flights count: each kind has its own Clopper-Pearson interval.
        """
        if len(self) != len(other) or self.prices != other.prices:
            raise ValueError("costs are compared on the same encounters and by the same prices")
        if len(self) == 0:
            return Interval(None, None, None, 0)
        parts = [_mean(self.deviation_m - other.deviation_m)]
        for price, own, others in zip(self._event_prices, self._event_columns, other._event_columns, strict=True):
            parts += [_share(price, own & ~others), _share(-price, others & ~own)]
        return sum_of_means(parts, fsum((self.cost_m - other.cost_m).tolist()) / len(self))

    def _events(self) -> list[Part]:
        return [_share(price, column) for price, column in zip(self._event_prices, self._event_columns, strict=True)]

    @property
    def _event_prices(self) -> tuple[float, float]:
        return self.prices.snmac_m, self.prices.collision_m

    @property
    def _event_columns(self) -> tuple[np.ndarray, np.ndarray]:
        return self.snmac, self.collision


def _mean(values: np.ndarray) -> Part:
    return Part(1.0, values, mean_t(values))


def _share(price: float, events: np.ndarray) -> Part:
    return Part(price, events.astype(np.float64), clopper_pearson(int(np.count_nonzero(events)), len(events)))
