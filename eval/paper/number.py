"""One number of the paper beside the one that came out; whether they agree is computed, never written down."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from rss_gym.eval.intervals import Interval
from rss_gym.params import ParamsError

Role = Literal["reproduced", "calibrated", "by construction", "claim", "beside"]
Relation = Literal["equals", "at least", "at most"]

ROLES: tuple[str, ...] = get_args(Role)
RELATIONS: tuple[str, ...] = get_args(Relation)
UNCOUNTED: tuple[str, ...] = ("calibrated", "beside")
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
    seen : Interval
        What came out, with a 95 % confidence interval or the middle 95 % of repetitions: see `over` and `exact`.
    role : str
        "calibrated": used to choose the channel, so it says nothing and counts nowhere. "by construction": it follows
        from how the paper counts. "claim": a claim in words. "beside": measured under conditions that are not the
        paper's, to show what they change; it agrees with nothing and counts nowhere.
    unit : str
        Empty for a pure number.
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
    seen: Interval
    role: Role
    unit: str = ""
    relation: Relation = "equals"
    tolerance: float = 0.0
    note: str = ""

    def __post_init__(self) -> None:
        """Check the words and the numbers."""
        if self.role not in ROLES or self.relation not in RELATIONS:
            raise ParamsError(f"number {self.id!r}: role {self.role!r} or relation {self.relation!r} is unknown")
        value, low, high, _ = self.seen
        if value is None or low is None or high is None or not low <= value <= high:
            raise ParamsError(f"number {self.id!r}: what was seen must have ends on either side, got {self.seen!r}")
        if not all(map(math.isfinite, (self.paper, low, high, self.tolerance))) or self.tolerance < 0.0:
            raise ParamsError(f"number {self.id!r} must be finite, with a tolerance of at least 0, got {self!r}")

    @property
    def measured(self) -> float:
        """The value seen."""
        assert self.seen.value is not None  # checked above
        return self.seen.value

    @property
    def agrees(self) -> bool | None:
        """Whether what was seen meets the relation; None for a number that is not counted."""
        return self.to_dict()["agrees"]

    def to_dict(self) -> dict[str, Any]:
        """One entry of `paper.json`."""
        value, low, high, n = self.seen
        fields = {
            "id": self.id,
            "what": self.what,
            "paper": float(self.paper),
            "measured": value,
            "low": low,
            "high": high,
            "n": n,
            "unit": self.unit,
            "role": self.role,
            "relation": self.relation,
            "tolerance": float(self.tolerance),
        }
        return fields | {"agrees": agrees(fields), "note": self.note}


def agrees(fields: dict[str, Any]) -> bool | None:
    """The criterion, from the fields of `paper.json` alone; None for a number that is not counted.

    "equals": the paper's figure lies in the interval widened by the tolerance. "at least", "at most": the whole
    interval is on the right side of the threshold, to within the tolerance.
    """
    paper, low, high, tolerance = (fields[name] for name in ("paper", "low", "high", "tolerance"))
    if fields["role"] in UNCOUNTED:
        return None
    if fields["relation"] == "equals":
        return bool(low - tolerance <= paper <= high + tolerance)
    return bool(low >= paper - tolerance if fields["relation"] == "at least" else high <= paper + tolerance)


def over(repetitions: ArrayLike) -> Interval:
    """Median and middle 95 % over repetitions."""
    values = np.asarray(repetitions, dtype=np.float64)
    low, high = np.quantile(values, MIDDLE)
    return Interval(float(np.median(values)), float(low), float(high), len(values))


def exact(value: float, n: int = 1) -> Interval:
    """A value without uncertainty: computed, or the extreme of n cases that a claim about all of them is held to."""
    return Interval(float(value), float(value), float(value), n)


def counts(numbers: Sequence[Number]) -> dict[str, tuple[int, int]]:
    """How many agree, of how many, for each role that can."""
    return {
        role: (sum(bool(n.agrees) for n in numbers if n.role == role), sum(n.role == role for n in numbers))
        for role in ROLES
        if role not in UNCOUNTED
    }
