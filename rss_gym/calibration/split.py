"""The part of a log that is fitted and the part that is held out for the test."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from rss_gym.calibration.logs import LogRecord

FITTED_SHARE = 2.0 / 3.0


def held_out(records: Sequence[LogRecord]) -> tuple[list[LogRecord], list[LogRecord]]:
    """Where no log is named for the test: the first two thirds of every record's samples, and the last third."""
    cuts = [round(FITTED_SHARE * len(record.time_s)) for record in records]
    pairs = list(zip(records, cuts, strict=True))
    return [_part(record, slice(None, cut)) for record, cut in pairs], [
        _part(record, slice(cut, None)) for record, cut in pairs
    ]


def _part(record: LogRecord, part: slice) -> LogRecord:
    rate = record.closing_mps
    return dataclasses.replace(
        record,
        time_s=record.time_s[part],
        rss_dbm=record.rss_dbm[part],
        distance_m=record.distance_m[part],
        closing_mps=None if rate is None else rate[part],
    )
