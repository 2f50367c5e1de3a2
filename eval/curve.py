"""A rule's curve of safety against deviation: where another policy stands beside it, on the same encounters.

The curve joins the rule's settings that no other of its settings equals or beats in both, straight in the mean
deviation and in the logarithm of the collision rate. Beyond its ends it has none: there the setting at the end stands
in for it, which is told. So does the nearer one of two settings, if on the encounters in common the policy does not lie
between them.
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

    @property
    def place(self) -> tuple[float, float]:
        """Mean deviation and collision rate."""
        return self.mean_m, self.rate


@dataclass(frozen=True, eq=False)
class Beside:
    """A policy beside the curve, over the encounters that it and the settings used have in common.

    Attributes
    ----------
    own, curve : Delta
        Of the policy, and of the curve at the same value of the other quantity.
    used : tuple of int
        Indices of the two settings between which the curve is read, or of the one that stands in for it.
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
    used, flown = _read(policy, settings, axis=0)
    at, *deviations = (Delta.mean(item.deviation_m) for item in flown)
    rows = _rows(flown)
    logs = [Delta.rate(item.collision, row).log() for item, row in zip(flown[1:], rows[1:], strict=True)]
    return Beside(Delta.share(flown[0].collision, rows[0]), _line(at, deviations, logs).exp(), used)


def deviation_beside(policy: Points, settings: Sequence[Points]) -> Beside:
    """The policy's mean deviation, and the curve's at the policy's collision rate."""
    used, flown = _read(policy, settings, axis=1)
    own, *deviations = (Delta.mean(item.deviation_m) for item in flown)
    at, *logs = (Delta.rate(item.collision, row).log() for item, row in zip(flown, _rows(flown), strict=True))
    return Beside(own, _line(at, logs, deviations), used)


def _read(policy: Points, settings: Sequence[Points], axis: int) -> tuple[tuple[int, ...], list[Points]]:
    """Which settings the curve is read from; the first flights of the policy and of them that all have in common."""
    used = _neighbours([item.place for item in settings], policy.place[axis], axis)
    flown = _common(policy, *(settings[index] for index in used))
    at, *x = (item.place[axis] for item in flown)
    # They were chosen on all flights of each; on those in common the policy can lie beyond both.
    if len(used) == 2 and (x[0] == x[1] or not min(x) <= at <= max(x)):
        used = (used[int(abs(x[1] - at) < abs(x[0] - at))],)
        flown = _common(policy, settings[used[0]])
    return used, flown


def _neighbours(points: list[tuple[float, float]], at: float, axis: int) -> tuple[int, ...]:
    """The two points of the frontier round `at`, or the one at the end that is passed."""
    if not points:
        raise ValueError("a curve needs at least one setting")
    kept = sorted(frontier(points), key=lambda index: points[index][axis])
    above = next((place for place, index in enumerate(kept) if points[index][axis] >= at), len(kept))
    return tuple(kept[max(above - 1, 0) : above + 1])


def _common(*flown: Points) -> list[Points]:
    n = min(len(item) for item in flown)
    return [item.first(n) for item in flown]


def _rows(flown: list[Points]) -> list[int]:
    """A row of its own for each, one without any collision while there are such: see `Delta.share`."""
    quiet_first = np.argsort(np.any([item.collision for item in flown], axis=0), kind="stable")
    return [int(quiet_first[index % len(quiet_first)]) for index in range(len(flown))]


def _line(at: Delta, x: list[Delta], y: list[Delta]) -> Delta:
    """Straight from (x[0], y[0]) to (x[1], y[1]); y[0] where there is one point."""
    if len(x) == 1:
        return y[0]
    return y[0] + (at - x[0]) / (x[1] - x[0]) * (y[1] - y[0])
