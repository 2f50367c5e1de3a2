"""One number of the paper beside the one that came out; whether they agree is computed, never written down."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np

from rss_gym.params import ParamsError

Role = Literal["reproduced", "calibrated", "by construction", "claim"]
Relation = Literal["equals", "at least", "at most"]

ROLES: tuple[str, ...] = get_args(Role)
MIDDLE = (0.025, 0.975)  # the middle 95 % of repetitions


@dataclass(frozen=True, kw_only=True)
class Number:
    """A number, or a claim in words as a number with a criterion.

    Parameters
    ----------
    id : str
        Unique, beginning with the figure's.
    what : str
        What is measured, in words.
    paper : float
        The paper's figure; of a claim, its threshold.
    measured : float
    low, high : float, optional
        Ends of the 95 % interval, or of the middle 95 % of repetitions; without them the measured value is exact.
    unit : str
        Empty for a pure number.
    role : str
        "calibrated": used to choose the channel, so it says nothing and counts nowhere. "by construction": it follows
        from how the paper counts. "claim": a claim in words.
    relation : str
        How the measured number has to stand to the paper's: "equals", "at least" or "at most".
    tolerance : float
        Allowed beside the interval; for a figure read off a curve, as much as it may be misread.
    note : str
        What a reader has to know, above all the reason where it does not agree.

    Raises
    ------
    ParamsError
        When a number is not finite, the ends are out of order, or a word is unknown.
    """

    id: str
    what: str
    paper: float
    measured: float
    low: float | None = None
    high: float | None = None
    unit: str = ""
    role: Role
    relation: Relation = "equals"
    tolerance: float = 0.0
    note: str = ""

    def __post_init__(self) -> None:
        """Check the words and the numbers, and fill in the ends of an exact one."""
        if self.role not in ROLES or self.relation not in get_args(Relation):
            raise ParamsError(f"number {self.id!r}: role {self.role!r} or relation {self.relation!r} is unknown")
        for name in ("paper", "measured", "low", "high", "tolerance"):
            value = getattr(self, name)
            object.__setattr__(self, name, float(self.measured if value is None else value))
        assert self.low is not None and self.high is not None
        if not all(map(math.isfinite, (self.paper, self.low, self.high, self.tolerance))) or self.tolerance < 0.0:
            raise ParamsError(f"number {self.id!r} must be finite, with a tolerance of at least 0, got {self!r}")
        if not self.low <= self.measured <= self.high:
            raise ParamsError(f"number {self.id!r}: {self.measured!r} must lie in [{self.low!r}, {self.high!r}]")

    @property
    def agrees(self) -> bool | None:
        """Whether the interval, widened by the tolerance, meets the relation; None for a calibrated number."""
        return None if self.role == "calibrated" else agrees(self.to_dict())

    def to_dict(self) -> dict[str, Any]:
        """As in `paper.json`, without `agrees`."""
        return dict(self.__dict__)


def agrees(fields: dict[str, Any]) -> bool:
    """The criterion, from the fields of `paper.json` alone.

    "equals": the paper's figure lies in the interval widened by the tolerance. "at least", "at most": the whole interval
    is on the right side of the threshold, to within the tolerance.
    """
    paper, low, high, tolerance = (fields[name] for name in ("paper", "low", "high", "tolerance"))
    above, below = low >= paper - tolerance, high <= paper + tolerance
    if fields["relation"] == "equals":
        return bool(low - tolerance <= paper <= high + tolerance)
    return bool(above if fields["relation"] == "at least" else below)


def over(repetitions: Any) -> dict[str, float]:
    """Median and middle 95 % of a number over repetitions, as fields of `Number`."""
    low, high = np.quantile(repetitions, MIDDLE)
    return {"measured": float(np.median(repetitions)), "low": float(low), "high": float(high)}


def counts(numbers: Sequence[Number]) -> dict[str, tuple[int, int]]:
    """How many agree, of how many, for each role that can."""
    return {
        role: (sum(bool(n.agrees) for n in numbers if n.role == role), sum(n.role == role for n in numbers))
        for role in ROLES
        if role != "calibrated"
    }


def record(number: Number) -> dict[str, Any]:
    """One entry of `paper.json`."""
    fields = number.to_dict()
    note = fields.pop("note")
    return fields | {"agrees": number.agrees, "note": note}
