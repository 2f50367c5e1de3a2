"""What the readers of radio logs hand over, and the checks that every log passes whatever its format."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rss_gym.params import ParamsError

Floats = NDArray[np.float64]

ROWS_MIN = 30  # of a link
ROWS_MAX = 2_000_000  # of a file: at most 0.6 GB of memory while it is read, with every column there is
DROPPED_MAX = 0.05  # share of a file's rows
DISTANCE_LIMITS_M = (1e-3, 1e6)


@dataclass(frozen=True, eq=False)
class LogRecord:
    """One link of one log file.

    Attributes
    ----------
    link, source : str
        Name of the link, and of the file without its folders.
    time_s : (n,) array
        Strictly increasing.
    rss_dbm, distance_m : (n,) arrays
        RSS, below 0, and the true distance.
    range_rate_mps : (n,) array or None
        Range rate from the logged velocities along the true line of sight: what psi of (12) is made of, positive
        when the distance grows.
    dropped : int
        Rows of the link left out for an invalid RSS or a missing value.
    """

    link: str
    source: str
    time_s: Floats
    rss_dbm: Floats
    distance_m: Floats
    range_rate_mps: Floats | None
    dropped: int


@dataclass(frozen=True, eq=False)
class LogFile:
    """One file as its reader left it: every link however short, the counts of all rows, remarks for the user."""

    source: str
    records: list[LogRecord]
    rows: int
    dropped: int
    notes: tuple[str, ...] = ()


def checked(file: LogFile) -> tuple[list[LogRecord], list[str]]:
    """The links of a file that are long enough, and the remarks.

    Raises
    ------
    ParamsError
        If the file has no rows, more than 5 % of them were dropped, no link has 30, or the distance of a link with
        enough rows never changes.
    """
    if file.rows == 0:
        raise ParamsError(f"log {file.source!r} holds no rows; each link needs {ROWS_MIN} at least")
    if file.dropped > DROPPED_MAX * file.rows:
        raise ParamsError(
            f"log {file.source!r}: {file.dropped} of {file.rows} rows ({file.dropped / file.rows:.1%}) have a missing "
            f"value or an RSS that is not below 0; at most {DROPPED_MAX:.0%} may"
        )
    good = [record for record in file.records if record.time_s.size >= ROWS_MIN]
    short = [record for record in file.records if record.time_s.size < ROWS_MIN]
    if not good:
        longest = max(short, key=lambda record: record.time_s.size)
        raise ParamsError(
            f"log {file.source!r}: link {longest.link!r} has {longest.time_s.size} valid rows and no link has more; "
            f"{ROWS_MIN} at least are needed"
        )
    for record in good:
        if np.ptp(record.distance_m) <= 1e-6 * record.distance_m[0]:
            raise ParamsError(
                f"log {file.source!r}: the distance of link {record.link!r} is {record.distance_m[0]:g} m in every "
                "row; path loss can only be fitted over distances that differ"
            )
    notes = [f"log {file.source!r}: {note}" for note in file.notes]
    if file.dropped:
        notes.append(f"log {file.source!r}: {file.dropped} of {file.rows} rows dropped")
    for record in short:
        notes.append(
            f"log {file.source!r}: link {record.link!r} left out, {record.time_s.size} valid rows of {ROWS_MIN} needed"
        )
    return good, notes
