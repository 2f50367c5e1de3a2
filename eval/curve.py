"""A rule's curve of safety against deviation: where another policy stands beside it, on the same encounters.

The curve joins the rule's settings that no other of its settings equals or beats in both, straight in the mean
deviation and in the logarithm of the collision rate. Beyond its ends it has none: there the setting at the end stands
in for it, which is told.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rss_gym.eval.delta import Delta


@dataclass(frozen=True, eq=False)
class Points:
    """What the curve needs of one policy's flights, in the order of their encounters.

    Attributes
    ----------
    collision : (n,) bool array
    deviation_m : (n,) array
        Time mean of |u - u^d| of each flight.
    """

    collision: np.ndarray
    deviation_m: np.ndarray

    def __len__(self) -> int:
        return len(self.collision)

    def first(self, n: int) -> Points:
        """The first n flights."""
        return Points(self.collision[:n], self.deviation_m[:n])

    @property
    def rate(self) -> float:
        """Collisions an encounter; none at all counts as half a one."""
        return Delta.rate(self.collision).value

    @property
    def mean_m(self) -> float:
        """Mean deviation."""
        return Delta.mean(self.deviation_m).value


@dataclass(frozen=True, eq=False)
class Beside:
    """A policy beside the curve, over the encounters that it and the settings used have in common.

    Attributes
    ----------
    own, curve : Delta
        Of the policy, and of the curve at the same value of the other quantity.
    used : tuple of int
        Indices of the two settings between which the curve is read, or of the one at its end.
    """

    own: Delta
    curve: Delta
    used: tuple[int, ...]


def frontier(points: Sequence[tuple[float, float]]) -> list[int]:
    """Indices of the points that no other equals or beats in both (the first of equal ones), by the first ascending."""
    kept: list[int] = []
    for index in sorted(range(len(points)), key=lambda i: (*points[i], i)):
        if not kept or points[index][1] < points[kept[-1]][1]:
            kept.append(index)
    return kept


def rate_beside(policy: Points, settings: Sequence[Points]) -> Beside:
    """The policy's collision rate, and the curve's at the policy's mean deviation."""
    used = _neighbours([(item.mean_m, item.rate) for item in settings], policy.mean_m, axis=0)
    flown, ends = _common(policy, [settings[index] for index in used])
    deviations = [Delta.mean(item.deviation_m) for item in ends]
    logs = [Delta.rate(item.collision).log() for item in ends]
    curve = _line(Delta.mean(flown.deviation_m), deviations, logs).exp()
    return Beside(Delta.mean(flown.collision), curve, used)


def deviation_beside(policy: Points, settings: Sequence[Points]) -> Beside:
    """The policy's mean deviation, and the curve's at the policy's collision rate."""
    used = _neighbours([(item.mean_m, item.rate) for item in settings], policy.rate, axis=1)
    flown, ends = _common(policy, [settings[index] for index in used])
    deviations = [Delta.mean(item.deviation_m) for item in ends]
    logs = [Delta.rate(item.collision).log() for item in ends]
    curve = _line(Delta.rate(flown.collision).log(), logs, deviations)
    return Beside(Delta.mean(flown.deviation_m), curve, used)


def _neighbours(points: list[tuple[float, float]], at: float, axis: int) -> tuple[int, ...]:
    """The two points of the frontier round `at`, or the one at the end that is passed."""
    if not points:
        raise ValueError("a curve needs at least one setting")
    kept = sorted(frontier(points), key=lambda index: points[index][axis])
    above = next((place for place, index in enumerate(kept) if points[index][axis] >= at), len(kept))
    return tuple(kept[max(above - 1, 0) : above + 1])


def _common(policy: Points, ends: list[Points]) -> tuple[Points, list[Points]]:
    n = min(len(item) for item in (policy, *ends))
    return policy.first(n), [item.first(n) for item in ends]


def _line(at: Delta, x: list[Delta], y: list[Delta]) -> Delta:
    """Straight from (x[0], y[0]) to (x[1], y[1]), or y[0] where there is one point, or two of one x."""
    if len(x) == 1 or x[0].value == x[1].value:
        return y[0]
    return y[0] + (at - x[0]) / (x[1] - x[0]) * (y[1] - y[0])
