"""What the readers of radio logs hand over: the rows of each link with a reason for each that is not used."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Codes = NDArray[np.uint8]

ROWS_MIN = 30  # of a link
ROWS_MAX = 2_000_000  # of a file: at most 0.6 GB of memory while it is read, with every column there is
DISTANCE_LIMITS_M = (1e-3, 1e6)
NEAREST_M = 1.0  # the reference distance of (2): an aircraft on its launch point says nothing about path loss

# Reasons for which a row is not used; 0 is a row in use.
USED: Final = 0
MISSING, CORRUPT, LIMITS, DISTANCE, NOT_BELOW_0, BACKWARDS = 1, 2, 3, 4, 5, 6
NO_RSS, SENTINEL, SATURATED, AT_ONE_PLACE = 20, 21, 22, 23
DUPLICATE, COPY = 40, 41
NO_POSITION, TOO_NEAR, NOT_ARMED, ON_GROUND, OUTSIDE = 60, 61, 62, 63, 64

REASONS: dict[int, str] = {
    MISSING: "a value is missing",
    CORRUPT: "a cell that is no number",
    LIMITS: "a number out of its limits",
    DISTANCE: "a distance out of its limits",
    NOT_BELOW_0: "an RSS that is not below 0 dBm",
    BACKWARDS: "the clock goes back",
    NO_RSS: "no RSS",
    SENTINEL: "a number that stands for no signal",
    SATURATED: "an RSS at the edge of what the receiver reports",
    AT_ONE_PLACE: "a distance of 0",
    DUPLICATE: "the time of the row before",
    COPY: "a copy of another report",
    NO_POSITION: "no position near in time",
    TOO_NEAR: f"nearer than {NEAREST_M:g} m",
    NOT_ARMED: "not armed",
    ON_GROUND: "on the ground",
    OUTSIDE: "outside of --from and --to",
}
# A log is refused where more of its rows than these shares have such a reason. Copies are no fault, and rows on the
# ground are no part of the flight: they have no limit.
FAULTS = frozenset(range(MISSING, NO_RSS))
NO_SIGNAL = frozenset((NO_RSS, SENTINEL, SATURATED, AT_ONE_PLACE))
FAULTS_MAX, NO_SIGNAL_MAX = 0.05, 0.5


@dataclass(frozen=True, eq=False)
class LogRecord:
    """One link of one log file.

    Attributes
    ----------
    link, source : str
        Name of the link, and of the file, with as many of its folders as tell it from the others.
    time_s : (n,) array
        Strictly increasing.
    rss_dbm, distance_m : (n,) arrays
        RSS, below 0, and the true distance.
    range_rate_mps : (n,) array or None
        Range rate from the logged velocities along the true line of sight: what psi of (12) is made of, positive
        when the distance grows.
    dropped : int
        Rows of the link that are not used.
    reasons : mapping of str to int
        How many of them for which reason (`REASONS`).
    sender : str
        Who reported the link, empty where the format does not say.
    start_s : float
        Time of the log's own clock at `time_s` 0; NaN where the log does not say.
    file : int
        Number of the file among those read together.
    """

    link: str
    source: str
    time_s: Floats
    rss_dbm: Floats
    distance_m: Floats
    range_rate_mps: Floats | None
    dropped: int
    reasons: Mapping[str, int] = field(default_factory=dict)
    sender: str = ""
    start_s: float = float("nan")
    file: int = 0


@dataclass(eq=False)
class Rows:
    """The rows of one link as its reader found them, good and bad.

    Attributes
    ----------
    link, sender : str
        As in `LogRecord`.
    number : (n,) array
        The number of the line, or of the message in the file, for messages.
    time_s, rss_dbm, distance_m : (n,) arrays
        NaN where not known. Times are the log's own clock in s.
    range_rate_mps : (n,) array or None
        NaN where not known; None where the log has no velocity.
    reason : (n,) array
        `USED`, or why the row is not used.
    """

    link: str
    number: Floats
    time_s: Floats
    rss_dbm: Floats
    distance_m: Floats
    range_rate_mps: Floats | None
    reason: Codes
    sender: str = ""

    def drop(self, where: NDArray[np.bool_], reason: int) -> int:
        """Give a reason to rows in use; returns how many."""
        hit = where & (self.reason == USED)
        self.reason[hit] = reason
        return int(hit.sum())


@dataclass(eq=False)
class LogFile:
    """One file as its reader left it.

    Attributes
    ----------
    source : str
        Name of the file.
    format : str
        In words.
    rows : list of Rows
        A link each.
    row : str
        What one row is in messages: "line" or "message".
    notes : list of str
        What the reader had to assume.
    examples : dict of int to str
        For a reason, the first row that has it and what it holds.
    columns : dict of str to str
        Key to the column, field or message that it is taken from; under "" what is not used.
    """

    source: str
    format: str
    rows: list[Rows]
    row: str = "line"
    notes: list[str] = field(default_factory=list)
    examples: dict[int, str] = field(default_factory=dict)
    columns: dict[str, str] = field(default_factory=dict)

    def example(self, reason: int, text: str) -> None:
        """Keep the first of its kind."""
        self.examples.setdefault(reason, text)
