"""Readers of radio logs: one file each, one line in `READERS`; what they hand over is checked alike."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from rss_gym.calibration.logs.mavlink import read_telemetry
from rss_gym.calibration.logs.record import LogFile, LogRecord, checked
from rss_gym.calibration.logs.table import read_table
from rss_gym.params import ParamsError, suggestion

__all__ = ["READERS", "LogRecord", "Logs", "read"]

READERS: dict[str, Callable[[Path, Mapping[str, str]], LogFile]] = {
    "csv": read_table,
    "mavlink": read_telemetry,
}


class Logs(list[LogRecord]):
    """The records, and in `notes` what the user should be told about them, one sentence each."""

    def __init__(self, records: Iterable[LogRecord] = (), notes: Iterable[str] = ()) -> None:
        super().__init__(records)
        self.notes = tuple(notes)


def read(
    paths: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    format: str = "csv",
    columns: Mapping[str, str] | None = None,
) -> Logs:
    """Read radio logs: one record for each file and link, in the order of the files.

    Links with fewer than 30 valid rows are left out with a note if the file has a longer one.

    Parameters
    ----------
    paths : path or iterable of paths
        The files.
    format : str
        One of `READERS`.
    columns : mapping of str to str, optional
        For tables, what is in which column: `columns.NAMES` has the keys, a value is a column's name or a number that
        holds in every row. Keys that are not given are looked for under well-known names.

    Returns
    -------
    Logs
        A list of `LogRecord`; its `notes` are sentences for the user.

    Raises
    ------
    ParamsError
        For a file that cannot be read or is not a log, in one sentence.
    """
    if format not in READERS:
        raise ParamsError(f"format {format!r} is unknown{suggestion(str(format), READERS)}")
    names = [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)
    if not names:
        raise ParamsError("no log was given; name at least one file")
    logs, notes = [], []
    for name in names:
        records, remarks = checked(_read_file(os.fspath(name), format, columns or {}))
        logs += records
        notes += remarks
    return Logs(logs, notes)


def _read_file(name: str, format: str, columns: Mapping[str, str]) -> LogFile:
    """One file by its reader; pipes and devices have no end that can be relied on, and folders are no files."""
    if not os.path.isfile(name):
        kind = "a folder" if os.path.isdir(name) else "no regular file" if os.path.exists(name) else "missing"
        raise ParamsError(f"log {name!r} is {kind}; name a log file")
    try:
        return READERS[format](Path(name), columns)
    except OSError as error:
        raise ParamsError(f"log {name!r} cannot be read: {error}") from error
