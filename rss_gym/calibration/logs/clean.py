"""The checks that every log passes whatever its format: what is no signal, no row of its own, or out of order."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np
from numpy.typing import NDArray

from rss_gym.calibration.logs.options import ReadOptions
from rss_gym.calibration.logs.record import (
    AT_ONE_PLACE,
    BACKWARDS,
    DISTANCE,
    DISTANCE_LIMITS_M,
    DUPLICATE,
    FAULTS,
    FAULTS_MAX,
    MISSING,
    NO_RSS,
    NO_SIGNAL,
    NO_SIGNAL_MAX,
    NOT_BELOW_0,
    OUTSIDE,
    REASONS,
    ROWS_MIN,
    SATURATED,
    SENTINEL,
    USED,
    Floats,
    LogFile,
    LogRecord,
    Rows,
)
from rss_gym.params import ParamsError

# No receiver hears below thermal noise in 1 Hz, -174 dBm; narrow-band radios end near -148 dBm.
FLOOR_DBM = -150.0
# What receivers and their drivers write in place of a signal: ends of 8 bits, and round numbers.
SENTINELS_DBM = frozenset(
    (0.0, 100.0, 127.0, 128.0, 255.0, -150.0, -140.0, -130.0, -129.0, -128.0, -127.0, -120.0, -110.0, -100.0, -99.0)
)
_APART_DB = 8.0  # between such a number and the signals
_EDGE_SHARE, _EDGE_RATIO, _EDGE_LEVELS = 0.05, 1.5, 8
_SPREAD_FROM = 0.2  # share of repeated times above which the clock is taken as coarse
_ISOLATED = 0.01  # share of rows out of order up to which they are single ones
_SESSION_ROWS, _PAUSE = 10, 100.0  # rows of a session at least, and intervals between two
_ANEW = 5.0  # intervals after the first time of all within which a clock has begun anew
_VELOCITY_SHARE = 0.5
_SLOW_MPS, _FAST_MPS = 0.01, 300.0
_SHORT_S, _LONG_S = 1e-3, 30.0  # intervals that a radio's reports have


def cleaned(file: LogFile, options: ReadOptions) -> tuple[list[LogRecord], list[str]]:
    """The records of a file, and sentences on what was left out.

    Raises
    ------
    ParamsError
        If the file has no rows, too many of them are faulty or without signal, no link has 30 rows in use, or the
        distance of a link never changes.
    """
    count = sum(rows.reason.size for rows in file.rows)
    if count == 0:
        raise ParamsError(f"log {file.source!r} holds no rows; each link needs {ROWS_MIN} at least")
    start_s = min(
        (float(np.nanmin(rows.time_s)) for rows in file.rows if np.isfinite(rows.time_s).any()), default=float("nan")
    )
    notes = [*file.notes]
    for rows in file.rows:
        notes += _clean(file, rows, options, start_s)
    _refuse(file, count)
    records = [_record(file, rows, start_s) for rows in file.rows]
    dropped = count - sum(record.time_s.size for record in records)
    if dropped:
        notes.append(f"{dropped} of {count} rows dropped: {_counted(file)}")
    good = [record for record in records if record.time_s.size >= ROWS_MIN]
    if not good:
        longest = max(records, key=lambda record: record.time_s.size)
        why = f"; {dropped} of {count} rows were dropped: {_counted(file)}" if dropped else ""
        raise ParamsError(
            f"log {file.source!r}: link {longest.link!r} has {longest.time_s.size} valid rows and no link has more; "
            f"{ROWS_MIN} at least are needed{why}"
        )
    for record in good:
        notes += _plausible(file, record)
    notes += [
        f"link {record.link!r} left out, {record.time_s.size} valid rows of {ROWS_MIN} needed"
        for record in records
        if record.time_s.size < ROWS_MIN
    ]
    return good, [f"log {file.source!r}: {note}" for note in notes]


def _clean(file: LogFile, rows: Rows, options: ReadOptions, start_s: float) -> list[str]:
    """Give a reason to every row of a link that cannot be used."""
    notes = []
    rows.rss_dbm = rows.rss_dbm + options.offset_db
    rows.drop(np.isnan(rows.time_s), MISSING)
    rows.drop((rows.time_s - start_s < options.from_s) | (rows.time_s - start_s > options.to_s), OUTSIDE)
    _say(file, rows, np.isnan(rows.rss_dbm), NO_RSS, rows.rss_dbm)
    notes += _no_signal(file, rows, options.offset_db)
    _say(file, rows, rows.rss_dbm >= 0.0, NOT_BELOW_0, rows.rss_dbm)
    _say(file, rows, np.isnan(rows.distance_m), MISSING, rows.distance_m)
    low, high = DISTANCE_LIMITS_M
    _say(file, rows, rows.distance_m == 0.0, AT_ONE_PLACE, rows.distance_m)
    _say(file, rows, ~((rows.distance_m >= low) & (rows.distance_m <= high)), DISTANCE, rows.distance_m)
    notes += _in_order(file, rows)
    return notes


def _say(file: LogFile, rows: Rows, where: NDArray[np.bool_], reason: int, values: Floats) -> None:
    """Drop rows, and keep the first as an example."""
    hit = np.flatnonzero(where & (rows.reason == USED))
    if hit.size:
        value = "" if np.isnan(values[hit[0]]) else f" of {values[hit[0]]:g}"
        file.example(reason, f"{file.row} {rows.number[hit[0]]:.0f}{value}")
        rows.drop(where, reason)


def _no_signal(file: LogFile, rows: Rows, offset_db: float) -> list[str]:
    """Numbers in place of a signal, and the pile of values where a receiver's scale ends.

    A number below every receiver's reach is one, and so is one of `SENTINELS_DBM` (before the offset is added) that is
    not below 0 or lies below all signals by 8 dB.
    A value at an edge is saturated if it holds 5 % of the rows, and 1.5 times as many as the next two levels together:
    the levels at the ends of a scale that goes on are the rarest.
    """
    notes: list[str] = []
    used = rows.rss_dbm[rows.reason == USED]
    levels, times = np.unique(used, return_counts=True)
    known = np.isin(np.round(levels - offset_db, 6), list(SENTINELS_DBM))
    marks = set(levels[(levels <= FLOOR_DBM) | (known & (levels >= 0.0))].tolist())
    signals = levels[(levels > FLOOR_DBM) & (levels < 0.0)]
    while (
        signals.size > 1 and round(signals[0] - offset_db, 6) in SENTINELS_DBM and signals[1] - signals[0] >= _APART_DB
    ):
        marks.add(float(signals[0]))
        signals = signals[1:]
    if marks:
        _say(file, rows, np.isin(rows.rss_dbm, list(marks)), SENTINEL, rows.rss_dbm)
    keep = np.isin(levels, list(marks), invert=True) & (levels < 0.0)
    levels, times = levels[keep], times[keep]
    if levels.size < _EDGE_LEVELS:
        return notes
    for edge, inner in ((0, slice(1, 3)), (-1, slice(-3, -1))):
        share = times[edge] / times.sum()
        if share >= _EDGE_SHARE and times[edge] > _EDGE_RATIO * times[inner].sum():
            _say(file, rows, rows.rss_dbm == levels[edge], SATURATED, rows.rss_dbm)
            notes.append(
                f"link {rows.link!r}: {share:.0%} of the rows have the {'lowest' if edge == 0 else 'highest'} RSS, "
                f"{levels[edge]:g} dBm, where the receiver's scale seems to end"
            )
    return notes


def _in_order(file: LogFile, rows: Rows) -> list[str]:
    """Times that rise: the most rows that do are kept; a coarse clock is spread out."""
    used = np.flatnonzero(rows.reason == USED)
    steps = np.diff(rows.time_s[used])
    notes = []
    if (steps < 0.0).any():
        keep = _longest_rising(rows.time_s[used])
        joined = _joined(rows.time_s[used]) if used.size - keep.size > _ISOLATED * used.size else None
        if joined is None:
            back = np.ones(rows.reason.size, bool)
            back[used[keep]] = False
            _say(file, rows, back, BACKWARDS, rows.time_s)
            used = used[keep]
        else:
            notes.append(
                f"link {rows.link!r}: the clock is set back {(steps < 0.0).sum()} times, first in {file.row} "
                f"{rows.number[used[np.argmax(steps < 0.0) + 1]]:.0f}; it is taken to go on there"
            )
            rows.time_s = rows.time_s.copy()
            rows.time_s[used] = joined
        steps = np.diff(rows.time_s[used])
    same = np.flatnonzero(steps == 0.0) + 1
    if not same.size:
        return notes
    copies = (rows.rss_dbm[used[same]] == rows.rss_dbm[used[same - 1]]) & (
        rows.distance_m[used[same]] == rows.distance_m[used[same - 1]]
    )
    if same.size - copies.sum() > _SPREAD_FROM * used.size:
        rows.time_s = rows.time_s.copy()
        rows.time_s[used] = _spread(rows.time_s[used])
        return [
            *notes,
            f"link {rows.link!r}: {same.size} of {used.size} rows repeat the time of the row before, as of a "
            "coarse clock; "
            "rows of one time are spread evenly up to the next",
        ]
    where = np.zeros(rows.reason.size, bool)
    where[used[same]] = True
    _say(file, rows, where, DUPLICATE, rows.time_s)
    return notes


def _joined(time_s: Floats) -> Floats | None:
    """Times that go on where the clock was set back, after a pause where it began anew; None if that is too often."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(time_s) < 0.0) + 1])
    ends = np.append(starts[1:], time_s.size)
    if (ends - starts).min() < _SESSION_ROWS:
        return None
    steps = np.diff(time_s)
    interval_s = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 1.0
    joined = time_s.copy()
    for start, end in zip(starts[1:], ends[1:], strict=True):
        anew = time_s[start] <= time_s[0] + _ANEW * interval_s
        joined[start:end] += joined[start - 1] - time_s[start] + interval_s * (_PAUSE if anew else 1.0)
    return joined


def _longest_rising(time_s: Floats) -> NDArray[np.intp]:
    """Indices of the longest subsequence that never falls."""
    ends: list[float] = []
    at: list[int] = []
    before = np.full(time_s.size, -1)
    for k, value in enumerate(time_s.tolist()):
        place = bisect_right(ends, value)
        before[k] = at[place - 1] if place else -1
        if place == len(ends):
            ends.append(value)
            at.append(k)
        else:
            ends[place], at[place] = value, k
    chain = [at[-1]]
    while before[chain[-1]] >= 0:
        chain.append(int(before[chain[-1]]))
    return np.array(chain[::-1])


def _spread(time_s: Floats) -> Floats:
    """Rows of one time evenly between it and the next; those of the last time as far apart as the ones before."""
    firsts = np.flatnonzero(np.diff(time_s, prepend=-np.inf) > 0.0)
    counts = np.diff(firsts, append=time_s.size)
    lengths = np.diff(time_s[firsts])
    length = float(np.median(lengths)) if lengths.size else 1.0
    lengths = np.minimum(np.append(lengths, length), length)
    place = np.arange(time_s.size) - np.repeat(firsts, counts)
    spread: Floats = time_s + place * np.repeat(lengths / counts, counts)
    return spread


def _refuse(file: LogFile, count: int) -> None:
    reasons = np.concatenate([rows.reason for rows in file.rows])
    for kinds, limit in ((FAULTS, FAULTS_MAX), (NO_SIGNAL, NO_SIGNAL_MAX)):
        bad = int(np.isin(reasons, list(kinds)).sum())
        if bad > limit * count:
            hint = ""
            if (reasons == NOT_BELOW_0).sum() > 0.5 * bad:
                hint = "; for a receiver that reports relative power name --offset-db, such as -120"
            raise ParamsError(
                f"log {file.source!r}: {bad} of {count} rows ({bad / count:.1%}) cannot be used, at most "
                f"{limit:.0%} may: "
                f"{_counted(file, kinds)}{hint}"
            )


def _counted(file: LogFile, kinds: frozenset[int] = frozenset(REASONS)) -> str:
    """`3 a value is missing (line 7), 1 ...`: each reason with its count and first row."""
    codes, times = np.unique(np.concatenate([rows.reason for rows in file.rows]), return_counts=True)
    parts = []
    for code, number in zip(codes.tolist(), times.tolist(), strict=True):
        if code in kinds:
            first = f" ({file.examples[code]})" if code in file.examples else ""
            parts.append(f"{number} × {REASONS[code]}{first}")
    return ", ".join(parts)


def _record(file: LogFile, rows: Rows, start_s: float) -> LogRecord:
    used = rows.reason == USED
    codes, times = np.unique(rows.reason[~used], return_counts=True)
    rate = rows.range_rate_mps
    if rate is not None:
        known = used & np.isfinite(rate)
        if known.sum() < max(_VELOCITY_SHARE * used.sum(), 2):
            rate = None
        else:
            rate = np.interp(rows.time_s[used], rows.time_s[known], rate[known])
    return LogRecord(
        link=rows.link,
        source=file.source,
        time_s=rows.time_s[used] - start_s,
        rss_dbm=rows.rss_dbm[used],
        distance_m=rows.distance_m[used],
        range_rate_mps=rate,
        dropped=int((~used).sum()),
        reasons={REASONS[code]: int(number) for code, number in zip(codes.tolist(), times.tolist(), strict=True)},
        sender=rows.sender,
        start_s=start_s,
    )


def _plausible(file: LogFile, record: LogRecord) -> list[str]:
    """Refuse a distance that never changes; name intervals that no radio and speeds that no aircraft has."""
    if np.ptp(record.distance_m) <= 1e-6 * record.distance_m[0]:
        raise ParamsError(
            f"log {file.source!r}: the distance of link {record.link!r} is {record.distance_m[0]:g} m in every "
            "row; path loss can only be fitted over distances that differ"
        )
    span_s = float(record.time_s[-1] - record.time_s[0])
    speed_mps = float(np.abs(np.diff(record.distance_m)).sum()) / span_s
    interval_s = float(np.median(np.diff(record.time_s)))
    if _SLOW_MPS <= speed_mps <= _FAST_MPS and _SHORT_S <= interval_s <= _LONG_S:
        return []
    return [
        f"link {record.link!r}: the distance changes by {speed_mps:.3g} m/s in the mean, at intervals of "
        f"{interval_s:.3g} s; "
        "name --time-unit if the time is not in the unit taken"
    ]
