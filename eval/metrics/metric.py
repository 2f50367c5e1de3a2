"""What a metric is, what it is computed from, and what it returns."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Protocol

import numpy as np

from rss_gym.eval.costs import SCORE, Prices
from rss_gym.eval.intervals import Interval, clopper_pearson
from rss_gym.eval.table import TABLES
from rss_gym.params import Params

ONE = "1"  # the unit of ratios and shares


@dataclass(frozen=True)
class Estimate:
    """A metric's value with its 95 % confidence interval.

    Attributes
    ----------
    value, low, high : float or None
        None where the flights do not define it, such as a ratio to zero or the end of an interval of one value.
    n : int
        Number of observations behind the value.
    unit : str
        SI; `1` for ratios.
    """

    value: float | None
    low: float | None
    high: float | None
    n: int
    unit: str


@dataclass(frozen=True, eq=False)
class Flights:
    """Everything that a metric sees: episode tables of the same encounters in the same order, and the zone's numbers.

    Attributes
    ----------
    table : (n,) array of TABLE
        The policy's flights.
    none : (n,) array of TABLE
        The flights of the policy `none`, which follows the predefined trajectory.
    reference : (n,) array of TABLE or None
        The flights of the policy that completed-only figures are compared with.
    suite_radius_m : float
        S, the safety zone's radius.
    trials : int
        n_d of (37), the estimates that must all be wrong for a missed conflict.
    range_error_probability : float
        P(delta) of (31), the share of range errors within delta.
    reaction_s : float
        t_r of (40), the time needed to react to a warning.
    prices : Prices
        The prices of the parts of a cost.
    """

    table: np.ndarray
    none: np.ndarray
    reference: np.ndarray | None
    suite_radius_m: float
    trials: int
    range_error_probability: float
    reaction_s: float
    prices: Prices = SCORE

    @classmethod
    def of(
        cls, params: Params, table: np.ndarray, none: np.ndarray, reference: np.ndarray | None, prices: Prices = SCORE
    ) -> Flights:
        """Flights in a world, whose zone gives the numbers."""
        zone = params.zone
        numbers = (zone.radius_m, zone.trials, zone.range_error_probability, zone.reaction_s)
        return cls(table, none, reference, *numbers, prices)

    def __post_init__(self) -> None:
        for name in ("table", "none", "reference"):
            rows = getattr(self, name)
            if rows is None and name == "reference":
                continue
            if rows.dtype not in TABLES.values() or rows.ndim != 1:
                raise ValueError(f"{name} must be a row of TABLE records, got {rows.dtype} of shape {rows.shape}")
            if not np.array_equal(rows["episode"], self.table["episode"]):
                raise ValueError(f"{name} must hold the same episodes as table, in the same order")

    def __len__(self) -> int:
        return len(self.table)

    @property
    def domain(self) -> str:
        """Name of the domain, whose columns the table has."""
        return next(name for name, columns in TABLES.items() if columns == self.table.dtype)

    def rows(self, chosen: np.ndarray) -> Flights:
        """The flights of some encounters only, by mask or index: one family, one channel."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        for name in ("table", "none", "reference"):
            values[name] = None if values[name] is None else values[name][chosen]
        return Flights(**values)

    @property
    def completed(self) -> np.ndarray:
        """Encounters that policy and reference both flew to the end; none without a reference. Shape (n,)."""
        if self.reference is None:
            return np.zeros(len(self), np.bool_)
        return ~self.table["collision"] & ~self.reference["collision"]


class Function(Protocol):
    """Computes a metric: a pure function that no order of the rows changes."""

    def __call__(self, flights: Flights, /) -> Interval:
        """Value, ends of the interval, number of observations."""
        ...


@dataclass(frozen=True)
class Metric:
    """One score of one policy.

    Parameters
    ----------
    summary : str
        The definition in one line, for reports.
    unit : str
    function : Function
    sensor : bool
        Computed from the flights of `none` alone: a property of the radio, equal for every policy.
    domains : tuple of str
        Where it is defined.
    """

    summary: str
    unit: str
    function: Function
    sensor: bool = False
    domains: tuple[str, ...] = ("air", "road")

    def __call__(self, flights: Flights) -> Estimate:
        """The metric of these flights."""
        return Estimate(*self.function(flights), unit=self.unit)


def share(events: np.ndarray) -> Interval:
    """Share of encounters with an event, with Clopper and Pearson's interval."""
    return clopper_pearson(int(np.count_nonzero(events)), len(events))
