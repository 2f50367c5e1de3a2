"""The kinds of bars of docs/bars.toml: what each asks, and what the flights say to it.

A bar has one or more findings and is met if all hold. A finding with a p-value is a comparison on the same encounters:
it holds if the difference is below zero and the p-value, adjusted over all comparisons of the run, below alpha. One
without holds if the upper end of its 95 % interval is at most the limit.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Self

import numpy as np
import opponents

from rss_gym.eval.curve import Beside, Points, deviation_beside, rate_beside
from rss_gym.eval.intervals import (
    Interval,
    clopper_pearson,
    holm,
    mcnemar_exact,
    mean_t,
    mean_zero_t,
    paired_difference,
)
from rss_gym.eval.reading import Record

ALPHA = 0.05  # family-wise error of the comparisons with the safest setting
EVENTS = {"collision": "collisions", "snmac": "sNMACs"}
RATE, LENGTH = ".2e", ".2f"  # how rates and metres are printed


@dataclass(frozen=True, eq=False)
class Flight:
    """One policy's flights: its scores, and what comparisons need of each encounter, in order.

    Attributes
    ----------
    row : opponents.Row
    points : Points
    snmac, conflict : (n,) bool array
        Of the policy; of `none`, whether it collides.
    hash : str
        Of the policy, with a learned one's numbers.
    """

    row: opponents.Row
    points: Points
    snmac: np.ndarray
    conflict: np.ndarray
    hash: str = ""

    @classmethod
    def of(cls, record: Record, name: str) -> Self:
        """A policy of a record."""
        policy, none = record[name], record["none"]
        # Copies: a column of a table keeps all of it in memory.
        collision, snmac = policy.table["collision"].copy(), policy.table["snmac"].copy()
        row = opponents.Row(name, record.episodes, policy.metrics)
        points = Points(collision, policy.table["deviation_mean_m"].copy())
        return cls(row, points, snmac, none.table["collision"].copy(), policy.hash)

    @property
    def name(self) -> str:
        """In tables."""
        return self.row.spec

    def events(self, event: str) -> np.ndarray:
        """Shape (n,), bool."""
        return self.points.collision if event == "collision" else self.snmac


@dataclass(frozen=True)
class Flown:
    """All flights of an agent's part of the plan.

    Attributes
    ----------
    none : Flight
        Of doing nothing in the agent's suite.
    shipped : Flight or None
        The policy that is handed on.
    seeds : tuple of Flight
        Trainings that differ in their seed only.
    groups : dict
        Flights of the opponents' settings.
    worlds : dict
        Flights of the shipped policy in other worlds.
    """

    none: Flight
    shipped: Flight | None
    seeds: tuple[Flight, ...]
    groups: dict[str, list[Flight]]
    worlds: dict[str, Flight] = field(default_factory=dict)

    def settings(self, groups: Sequence[str]) -> list[Flight]:
        """Of several groups."""
        return [flight for group in groups for flight in self.groups[group]]


@dataclass(frozen=True)
class Finding:
    """One number that a bar asks for; `n` of the interval are the encounters behind it.

    The same comparison for two bars is one finding, told by `what`.
    """

    what: str
    value: Interval
    form: str = RATE
    limit: float = 0.0
    p: float | None = None

    def holds(self, p_adjusted: float | None, alpha: float) -> bool:
        """Whether it is shown to be as asked."""
        if self.value.value is None:
            return False
        if self.p is None:
            return self.value.high is not None and self.value.high <= self.limit
        return self.value.value < self.limit and p_adjusted is not None and p_adjusted < alpha


@dataclass(frozen=True)
class Findings:
    """What the flights say to a bar, and what is told beside it."""

    found: list[Finding]
    remarks: list[str] = field(default_factory=list)


@dataclass(frozen=True, kw_only=True)
class Bar:
    """What every kind has in common.

    Parameters
    ----------
    asked : str
        In words, for the page.
    aim : bool
        Reported as reached or not; a bar is met or missed.
    against : tuple of str
        Groups of opponents.
    world : str
        One of the agent's other worlds; empty: its own.
    """

    asked: str
    aim: bool = False
    against: tuple[str, ...] = ()
    world: str = ""

    compares: ClassVar[bool] = True  # with opponents

    def judged(self, flown: Flown) -> tuple[Flight, ...]:
        """The flights that are judged."""
        flight = flown.worlds[self.world] if self.world else flown.shipped
        return () if flight is None else (flight,)

    def findings(self, flown: Flown) -> Findings:
        """Judge the flights."""
        raise NotImplementedError


def events_between(one: Flight, other: Flight, event: str) -> Finding:
    """Events of the one against the other's on the encounters that both flew: exact McNemar test."""
    n = min(len(one.points), len(other.points))
    a, b = one.events(event)[:n], other.events(event)[:n]
    both, only_a, only_b = (int(np.count_nonzero(x)) for x in (a & b, a & ~b, ~a & b))
    what = f"{EVENTS[event]} against `{other.name}`: {only_a} alone against {only_b}"
    return Finding(what, paired_difference(both, only_a, only_b, n), p=mcnemar_exact(only_a, only_b))


def deviates_less(one: Flight, other: Flight) -> bool:
    """Whether the one's mean deviation is below the other's, shown by the 95 % interval of the paired difference."""
    n = min(len(one.points), len(other.points))
    high = mean_t(one.points.deviation_m[:n] - other.points.deviation_m[:n]).high
    return high is not None and high < 0.0


def best_of(settings: Sequence[Flight]) -> Flight:
    """The setting that deviates least of those not told from the safest; see `DeviationOfBest`."""
    safest = min(settings, key=lambda flight: (_upper(flight), flight.points.mean_m))
    others = [flight for flight in settings if flight is not safest]
    p_values = holm([events_between(safest, other, "collision").p or 0.0 for other in others])
    tied = [other for other, p in zip(others, p_values, strict=True) if p >= ALPHA]
    return min([safest, *tied], key=lambda flight: flight.points.mean_m)


@dataclass(frozen=True, kw_only=True)
class FewerEvents(Bar):
    """Fewer events than each setting of the groups; with `equal_deviation` only settings that do not deviate less.

    A setting that is shown to deviate less is no comparison at equal or smaller deviation; it is named in a remark.
    With `best` only the groups' best setting counts, as in `DeviationOfBest`.
    """

    events: tuple[str, ...] = ("collision",)
    equal_deviation: bool = False
    best: bool = False

    def findings(self, flown: Flown) -> Findings:
        """A comparison a setting and event."""
        found, less = [], []
        settings = flown.settings(self.against)
        for agent in self.judged(flown):
            for other in [best_of(settings)] if self.best else settings:
                if self.equal_deviation and deviates_less(other, agent):
                    less.append(f"`{other.name}`")
                else:
                    found += [events_between(agent, other, event) for event in self.events]
        remarks = [f"not compared, as they deviate less: {', '.join(less)}"] if less else []
        return Findings(found, remarks)


@dataclass(frozen=True, kw_only=True)
class DeviationOfBest(Bar):
    """Mean deviation below a share of that of the groups' best setting.

    The best, on the encounters that two settings share: of the settings that exact McNemar tests with Holm's
    correction do not tell from the safest, the one that deviates least.
    The safest has the least one-sided 95 % upper bound of the collision rate: one flown seldom is not it by luck.
    """

    share: float

    def findings(self, flown: Flown) -> Findings:
        """One paired t test of each judged flight."""
        settings = flown.settings(self.against)
        best = best_of(settings)
        found = []
        for agent in self.judged(flown):
            n = min(len(agent.points), len(best.points))
            own, other = agent.points.deviation_m[:n], best.points.deviation_m[:n]
            what = (
                f"{np.mean(own):.2f} m against {np.mean(other):.2f} m of `{best.name}`, its best; {_less(self.share)}"
            )
            difference = own - self.share * other
            found.append(Finding(what, mean_t(difference), LENGTH, p=mean_zero_t(difference)))
        return Findings(found)


@dataclass(frozen=True, kw_only=True)
class CollisionsAtDeviation(Bar):
    """Collision rate below a share of the one on the groups' curve at the same mean deviation (`rss_gym.eval.curve`).

    With `every_seed` each of the seeds is judged, else the shipped policy.
    """

    share: float = 1.0
    every_seed: bool = False

    def judged(self, flown: Flown) -> tuple[Flight, ...]:
        """The seeds, or as ever."""
        return flown.seeds if self.every_seed else super().judged(flown)

    def findings(self, flown: Flown) -> Findings:
        """One of each judged flight."""
        settings = flown.settings(self.against)
        found = []
        for agent in self.judged(flown):
            beside = rate_beside(agent.points, [flight.points for flight in settings])
            what = (
                f"`{agent.name}`: {beside.own.value:.2e} against {beside.curve.value:.2e} of the curve at its "
                f"deviation ({_names(settings, beside)}); {_less(self.share)}"
            )
            difference = beside.own - self.share * beside.curve
            found.append(Finding(what, difference.interval(), p=difference.p()))
        return Findings(found)


@dataclass(frozen=True, kw_only=True)
class DeviationAtCollisions(Bar):
    """Mean deviation below a share of the one on the groups' curve at the same rate (`rss_gym.eval.curve`)."""

    share: float

    def findings(self, flown: Flown) -> Findings:
        """One of each judged flight."""
        settings = flown.settings(self.against)
        found = []
        for agent in self.judged(flown):
            beside = deviation_beside(agent.points, [flight.points for flight in settings])
            what = (
                f"{beside.own.value:.2f} m against {beside.curve.value:.2f} m of the curve at its collision rate "
                f"({_names(settings, beside)}); {_less(self.share)}"
            )
            difference = beside.own - self.share * beside.curve
            found.append(Finding(what, difference.interval(), LENGTH, p=difference.p()))
        return Findings(found)


@dataclass(frozen=True, kw_only=True)
class ConflictsLeft(Bar):
    """One-sided 95 % upper bound of the collision rate over the encounters that collide under `none`."""

    most: float

    compares = False

    def findings(self, flown: Flown) -> Findings:
        """One of each judged flight."""
        found = []
        for agent in self.judged(flown):
            left, n = int(np.count_nonzero(agent.points.collision & agent.conflict)), int(agent.conflict.sum())
            what = f"{left} collisions in {n} encounters that collide under `none`; one-sided bound"
            found.append(Finding(what, clopper_pearson(left, n, side="upper"), limit=self.most))
        return Findings(found)


@dataclass(frozen=True, kw_only=True)
class AtMost(Bar):
    """A metric of the evaluator, with its 95 % interval, at most this."""

    metric: str
    most: float

    compares = False

    def findings(self, flown: Flown) -> Findings:
        """One of each judged flight."""
        found = []
        for agent in self.judged(flown):
            estimate = agent.row.metrics[self.metric]
            value = Interval(estimate.value, estimate.low, estimate.high, estimate.n)
            title, form = opponents.COLUMNS.get(self.metric, (self.metric, RATE))
            found.append(Finding(title, value, form, limit=self.most))
        return Findings(found)


KINDS: dict[str, type[Bar]] = {
    "fewer-events": FewerEvents,
    "deviation-of-best": DeviationOfBest,
    "collisions-at-deviation": CollisionsAtDeviation,
    "deviation-at-collisions": DeviationAtCollisions,
    "conflicts-left": ConflictsLeft,
    "at-most": AtMost,
}


def _names(settings: list[Flight], beside: Beside) -> str:
    """The settings between which the curve is read."""
    return " to ".join(f"`{settings[index].name}`" for index in beside.used)


def _less(share: float) -> str:
    """What is subtracted."""
    return "difference" if share == 1.0 else f"less {share:.3g} of that"


def _upper(flight: Flight) -> float:
    """One-sided 95 % upper bound of the collision rate."""
    high = clopper_pearson(int(flight.points.collision.sum()), len(flight.points), side="upper").high
    assert high is not None
    return high
