"""The order of policies: by mean cost, each with the paired interval of its cost's difference from the first.

A policy's cost is its own, so adding an entry never changes the order of the others. Entries of one cost go by name.
A policy with a fault has no place: what it would have cost nobody knows.

The front are the ranked policies that no other ranked one equals or beats in both collision rate and mean deviation and
beats in one of them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite
from typing import get_args

import numpy as np

from rss_gym.eval.costs import Costs, Prices
from rss_gym.eval.evaluate import Result
from rss_gym.eval.intervals import Interval
from rss_gym.params import Information

FRONT = "on the front: no other has both fewer collisions and less deviation"


@dataclass(frozen=True, eq=False)
class Candidate:
    """What the ranking needs of one policy.

    Attributes
    ----------
    name : str
        Unique among the entries.
    faults : int
    costs : Costs
    episode : (n,) array
        Numbers of the encounters, the same for every entry.
    """

    name: str
    faults: int
    costs: Costs
    episode: np.ndarray

    @classmethod
    def of(cls, name: str, table: np.ndarray, prices: Prices) -> Candidate:
        """The entry of a policy with these flights."""
        faults = int(np.count_nonzero(table["fault"]))
        return cls(name, faults, Costs.of(table, prices), table["episode"].copy())

    @property
    def key(self) -> tuple[float, str]:
        """What entries without faults are sorted by."""
        return self.costs.mean_m, self.name

    @property
    def corner(self) -> tuple[float, float]:
        """Collision rate and mean deviation: best is the lower left."""
        return float(np.mean(self.costs.collision)), float(np.mean(self.costs.deviation_m))


@dataclass(frozen=True)
class Place:
    """Where one policy stands.

    Attributes
    ----------
    name : str
    place : int or None
        From 1; None where it is not ranked.
    difference : Interval or None
        The difference of its cost from the first one's, in m; None for the first and where it is not ranked.
    front : bool
        Whether no other is as good in both collision rate and mean deviation and better in one.
    faults : int
        Any keeps it from being ranked.
    """

    name: str
    place: int | None
    difference: Interval | None
    front: bool
    faults: int

    @property
    def why_not(self) -> str:
        """Why it is not ranked, in words; empty where it is."""
        return "" if self.place is not None else f"not ranked: {self.faults:,} fault{'s' * (self.faults != 1)}"


def rank(entries: Iterable[Candidate], differences: bool = True) -> list[Place]:
    """The entries in order, the cheapest first, those with faults last by name.

    Parameters
    ----------
    entries : iterable of Candidate
    differences : bool
        Whether the differences from the first are wanted; without them it takes no time.

    Raises
    ------
    ValueError
        For a name given twice, no flight, a cost that is not finite, or entries over different encounters.
    """
    given = sorted(entries, key=lambda entry: entry.name)
    check(given)
    ranked = sorted((entry for entry in given if not entry.faults), key=lambda entry: entry.key)
    on_front = front([entry.corner for entry in ranked])
    places = [
        Place(
            entry.name,
            index + 1,
            entry.costs.minus(ranked[0].costs) if index and differences else None,
            on_front[index],
            0,
        )
        for index, entry in enumerate(ranked)
    ]
    return places + [Place(entry.name, None, None, False, entry.faults) for entry in given if entry.faults]


def front(corners: list[tuple[float, float]]) -> list[bool]:
    """Of each point, whether no other is as low in both and lower in one."""
    return [not any(a <= x and b <= y and (a, b) != (x, y) for a, b in corners) for x, y in corners]


def check(entries: list[Candidate]) -> None:
    """Refuse names given twice, numbers that do not sort, and different encounters; `entries` are sorted by name."""
    for entry in entries:
        if not len(entry.costs):
            raise ValueError(f"entry {entry.name!r} has no flights")
        if not isfinite(entry.costs.mean_m):
            raise ValueError(f"entry {entry.name!r} has a cost that is not finite")
    for one, other in pairwise(entries):
        if one.name == other.name:
            raise ValueError(f"entry {one.name!r} is given twice")
        if not np.array_equal(one.episode, other.episode):
            raise ValueError(f"entries {one.name!r} and {other.name!r} were flown over different encounters")


def of(result: Result, differences: bool = False) -> dict[str, list[Place]]:
    """The policies of a result in order by level of information: who knows more is no rival. See `rank`."""
    prices = Prices.of(result.suite.params)
    places = {}
    for information in get_args(Information):
        members = [one for one in result.policies if one.entry.params.interface.information == information]
        if members:
            places[information] = rank(
                (Candidate.of(one.entry.name, one.table, prices) for one in members), differences
            )
    return places
