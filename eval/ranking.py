"""The order of policies on a leaderboard: safety first, the length of the detour where safety is not told apart.

The algorithm, on entries flown over the same encounters:

1. Entries with a fault come last, ordered by number of faults, then name. They take part in nothing else.
2. The others are sorted by the one-sided 95 % upper bound of their collision risk ratio (undefined last), then number
   of collisions, mean path deviation, name.
3. The first of these that are left is the leader. It is compared with each other one left by the exact McNemar test on
   collisions; the p-values of these comparisons are adjusted by Holm's method.
4. The leader and all whose adjusted p-value is at least 0.05 form a group. Within it the order is by mean path
   deviation, then name.
5. Steps 3 and 4 repeat with the rest until none is left; each group follows the one before.

Each entry lands in one group, and a group is sorted by one key, so the result is a total order: transitive, and the
same for any order of the input. A new entry may lead a group or add a comparison, and so change places of others.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from math import inf, isfinite

import numpy as np

from rss_gym.eval.intervals import holm, mcnemar_exact
from rss_gym.eval.metrics import Flights, measure

ALPHA = 0.05  # family-wise error of the comparisons with one leader


@dataclass(frozen=True, eq=False)
class Candidate:
    """What the ranking needs of one policy.

    Attributes
    ----------
    name : str
        Unique among the entries.
    faults : int
    risk_ratio_upper : float or None
        One-sided 95 % upper bound; None where `none` never collides.
    path_deviation_mean_m : float
    episode : (n,) array
        Numbers of the encounters, the same for every entry.
    collision : (n,) bool array
    """

    name: str
    faults: int
    risk_ratio_upper: float | None
    path_deviation_mean_m: float
    episode: np.ndarray
    collision: np.ndarray

    @classmethod
    def of(cls, name: str, flights: Flights) -> Candidate:
        """The entry of a policy with these flights, of which there is at least one."""
        wanted = ("faults", "risk_ratio_upper", "path_deviation_mean_m")
        faults, upper, deviation = (measure(flights, [metric])[metric].value for metric in wanted)
        if faults is None or deviation is None:
            raise ValueError(f"policy {name!r} has no flights")
        return cls(name, int(faults), upper, deviation, flights.table["episode"], flights.table["collision"])

    @property
    def safety(self) -> tuple[float, int, float, str]:
        """Key of step 2."""
        upper = inf if self.risk_ratio_upper is None else self.risk_ratio_upper
        return upper, int(np.count_nonzero(self.collision)), self.path_deviation_mean_m, self.name


@dataclass(frozen=True)
class Place:
    """Where one policy stands.

    Attributes
    ----------
    place : int
        From 1.
    name : str
    group : int or None
        From 1; entries of one group are not told apart in safety. None with faults.
    leader : str or None
        Of the group. None with faults.
    p_adjusted : float or None
        Holm-adjusted p-value of the comparison with the leader; None for the leader itself and with faults.
    """

    place: int
    name: str
    group: int | None
    leader: str | None
    p_adjusted: float | None


def rank(entries: Iterable[Candidate], alpha: float = ALPHA) -> list[Place]:
    """The entries in order, best first; the module's docstring has the algorithm.

    Raises
    ------
    ValueError
        For a name given twice, a score that is not finite, or entries over different encounters.
    """
    given = sorted(entries, key=lambda entry: entry.name)
    check(given)
    left = sorted((entry for entry in given if entry.faults == 0), key=lambda entry: entry.safety)
    places: list[Place] = []
    group = 0
    while left:
        group += 1
        leader, p_values = left[0], compare(left[0], left[1:])
        together = [entry for entry in left if p_values.get(entry.name, 1.0) >= alpha]
        for entry in sorted(together, key=lambda entry: (entry.path_deviation_mean_m, entry.name)):
            places.append(Place(len(places) + 1, entry.name, group, leader.name, p_values.get(entry.name)))
        left = [entry for entry in left if entry not in together]
    for entry in sorted((entry for entry in given if entry.faults), key=lambda entry: (entry.faults, entry.name)):
        places.append(Place(len(places) + 1, entry.name, None, None, None))
    return places


def compare(leader: Candidate, others: list[Candidate]) -> dict[str, float]:
    """Holm-adjusted p-values of exact McNemar tests of the leader's collisions against each other one's, by name."""
    p_values = [
        mcnemar_exact(
            int(np.count_nonzero(leader.collision & ~other.collision)),
            int(np.count_nonzero(~leader.collision & other.collision)),
        )
        for other in others
    ]
    return dict(zip((other.name for other in others), holm(p_values), strict=True))


def check(entries: list[Candidate]) -> None:
    """Refuse names given twice, numbers that do not sort, and different encounters; `entries` are sorted by name."""
    for entry in entries:
        if not all(isfinite(x) for x in (entry.risk_ratio_upper or 0.0, entry.path_deviation_mean_m)):
            raise ValueError(f"entry {entry.name!r} has a score that is not finite")
    for one, other in pairwise(entries):
        if one.name == other.name:
            raise ValueError(f"entry {one.name!r} is given twice")
        if not np.array_equal(one.episode, other.episode):
            raise ValueError(f"entries {one.name!r} and {other.name!r} were flown over different encounters")
