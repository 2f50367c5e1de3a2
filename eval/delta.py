"""Functions of means over the same encounters, with intervals by the delta method.

A `Delta` is a value and what each encounter adds to its error: its influence, to first order. Sums, products and
logarithms of means carry both along, so that whatever encounters have in common cancels by itself.

References
----------
Hampel, "The influence curve and its role in robust estimation", JASA 69 (1974) 383. van der Vaart, "Asymptotic
Statistics" (1998), ch. 3 and 20.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from math import fsum

import numpy as np

from rss_gym.eval.intervals import Interval, mean_t, mean_zero_t


@dataclass(frozen=True, eq=False)
class Delta:
    """A function of means.

    Attributes
    ----------
    value : float
    influence : (n,) array
        Of each encounter, in the unit of the value; their mean is zero.
    """

    value: float
    influence: np.ndarray

    @classmethod
    def mean(cls, values: np.ndarray) -> Delta:
        """Mean of one number an encounter."""
        numbers = np.asarray(values, dtype=np.float64)
        if len(numbers) == 0:
            raise ValueError("the mean of no encounter is undefined")
        mean = fsum(numbers.tolist()) / len(numbers)
        return cls(mean, numbers - mean)

    @classmethod
    def share(cls, events: np.ndarray, row: int = 0) -> Delta:
        """Share of encounters with an event; one of none has the influence of one event, in encounter `row`.

        Without it a share of none would count as known exactly. Shares of none are independent if their rows differ.
        """
        found = cls.mean(events)
        return found if found.value > 0.0 else cls(0.0, cls.mean(np.arange(len(events)) == row).influence)

    @classmethod
    def rate(cls, events: np.ndarray, row: int = 0) -> Delta:
        """As `share`, but none at all counts as half a one, so that there is a logarithm."""
        found = cls.share(events, row)
        return cls(found.value or 0.5 / len(events), found.influence)

    def __add__(self, other: Delta) -> Delta:
        return Delta(self.value + other.value, self.influence + other.influence)

    def __sub__(self, other: Delta) -> Delta:
        return self + -1.0 * other

    def __mul__(self, other: Delta) -> Delta:
        return Delta(self.value * other.value, self.influence * other.value + self.value * other.influence)

    def __rmul__(self, factor: float) -> Delta:
        return Delta(factor * self.value, factor * self.influence)

    def __truediv__(self, other: Delta) -> Delta:
        ratio = self.value / other.value
        return Delta(ratio, (self.influence - ratio * other.influence) / other.value)

    def log(self) -> Delta:
        """Natural logarithm."""
        return Delta(math.log(self.value), self.influence / self.value)

    def exp(self) -> Delta:
        """Exponential."""
        power = math.exp(self.value)
        return Delta(power, power * self.influence)

    def interval(self) -> Interval:
        """With the ends of Student's t."""
        return mean_t(self.value + self.influence)

    def p(self) -> float:
        """Two-sided p-value of the value zero."""
        return mean_zero_t(self.value + self.influence)
