"""Readers of radio logs: one file each, one line in `READERS`; what they hand over is checked alike."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rss_gym.calibration.logs.clean import cleaned
from rss_gym.calibration.logs.dataflash import is_dataflash, read_dataflash
from rss_gym.calibration.logs.edgetx import is_edgetx, read_edgetx
from rss_gym.calibration.logs.mavlink import is_telemetry, read_telemetry
from rss_gym.calibration.logs.options import ReadOptions
from rss_gym.calibration.logs.record import LogFile, LogRecord
from rss_gym.calibration.logs.rosbag import is_bag, read_bag
from rss_gym.calibration.logs.table import is_table, read_table
from rss_gym.calibration.logs.ulog import is_ulog, read_ulog
from rss_gym.params import ParamsError, suggestion

__all__ = ["READERS", "LogRecord", "Logs", "ReadOptions", "Reader", "read", "read_file"]

HEAD = 4096  # bytes by which a format is told


@dataclass(frozen=True)
class Reader:
    """One format.

    Attributes
    ----------
    title : str
        For readers.
    begins : function
        Whether a file that begins with these bytes may be one.
    read : function
        Path and options to what the file holds.
    """

    title: str
    begins: Callable[[bytes], bool]
    read: Callable[[Path, ReadOptions], LogFile]


# In the order in which they are asked: tables of text last, as they begin with anything.
READERS: dict[str, Reader] = {
    "mavlink": Reader("MAVLink telemetry log (.tlog)", is_telemetry, read_telemetry),
    "dataflash": Reader("ArduPilot DataFlash log (.bin)", is_dataflash, read_dataflash),
    "ulog": Reader("PX4 ULog (.ulg)", is_ulog, read_ulog),
    "ros": Reader("ROS bag (.bag, .mcap, .db3)", is_bag, read_bag),
    "edgetx": Reader("EdgeTX table", is_edgetx, read_edgetx),
    "csv": Reader("table of text", is_table, read_table),
}


class Logs(list[LogRecord]):
    """The records, and in `notes` what the user should be told about them, one sentence each."""

    def __init__(self, records: Iterable[LogRecord] = (), notes: Iterable[str] = ()) -> None:
        super().__init__(records)
        self.notes = tuple(notes)


def read(
    paths: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    format: str | None = None,
    columns: Mapping[str, str] | None = None,
    **options: Any,
) -> Logs:
    """Read radio logs: one record for each file and link, in the order of the files.

    Links with fewer than 30 valid rows are left out with a note if the file has a longer one.

    Parameters
    ----------
    paths : path or iterable of paths
        The files.
    format : str, optional
        One of `READERS`; by default it is told by the file's content.
    columns : mapping of str to str, optional
        For tables and bags, what is in which column: `columns.NAMES` has the keys, a value is a column's name or a
        number that holds in every row. Keys that are not given are looked for under well-known names.
    **options
        Of `ReadOptions`.

    Returns
    -------
    Logs
        A list of `LogRecord`; its `notes` are sentences for the user.

    Raises
    ------
    ParamsError
        For a file that cannot be read, is not a log or is named twice, in one sentence.
    """
    if format is not None and format not in READERS:
        raise ParamsError(f"format {format!r} is unknown{suggestion(str(format), READERS)}")
    names = [os.fspath(paths)] if isinstance(paths, (str, os.PathLike)) else [os.fspath(path) for path in paths]
    if not names:
        raise ParamsError("no log was given; name at least one file")
    chosen = ReadOptions(columns=columns or {}, **options)
    logs, notes = [], []
    for number, (name, source) in enumerate(zip(names, sources(names), strict=True)):
        records, remarks = cleaned(read_file(name, format, chosen, source), chosen)
        logs += [replace(record, file=number) for record in records]
        notes += remarks
    twice = next((name for name, times in Counter(map(os.path.realpath, names)).items() if times > 1), None)
    if twice is not None:
        raise ParamsError(f"log {os.path.basename(twice)!r} is named twice; its samples would count twice")
    return Logs(logs, notes)


def sources(names: list[str]) -> list[str]:
    """The file's name, with as many of its folders as tell it from the others: `may/flight.csv`, `june/flight.csv`."""
    parts = [os.path.abspath(name).split(os.sep) for name in names]
    found = []
    for name, own in zip(names, parts, strict=True):
        same = {tuple(other) for other in parts if other[-1] == own[-1]}
        depth = 1
        while depth < len(own) and sum(other[-depth:] == tuple(own[-depth:]) for other in same) > 1:
            depth += 1
        found.append("/".join(part for part in own[-depth:] if part) or name)
    return found


def read_file(name: str, format: str | None, options: ReadOptions, source: str) -> LogFile:
    """One file by its reader, before its rows are checked.

    Raises
    ------
    ParamsError
        For pipes, devices and folders, which are no files, a file that cannot be read, or one of no known format.
    """
    if os.path.isfile(os.path.join(name, "metadata.yaml")):  # a bag of ROS 2 is a folder
        format = format or "ros"
    elif not os.path.isfile(name):
        kind = "a folder" if os.path.isdir(name) else "no regular file" if os.path.exists(name) else "missing"
        raise ParamsError(f"log {name!r} is {kind}; name a log file")
    try:
        format = format or told(Path(name))
        if format is None:
            known = ", ".join(reader.title for reader in READERS.values() if reader.begins is not is_table)
            raise ParamsError(f"log {source!r} is not text in UTF-8 and of no known format; known: {known}")
        if format != "csv":
            for option, value in (("time_unit", options.time_unit), ("melt", options.melt), ("truth", options.truth)):
                if value is not None:
                    raise ParamsError(
                        f"{option} is for tables, and log {source!r} is a {READERS[format].title}, which needs none"
                    )
        file = READERS[format].read(Path(name), options)
    except OSError as error:
        raise ParamsError(f"log {name!r} cannot be read: {error}") from error
    except ParamsError as error:
        plain = f"log {os.path.basename(name)!r}"
        raise ParamsError(str(error).replace(plain, f"log {source!r}")) from error
    return replace(file, source=source)


def told(path: Path) -> str | None:
    """The format of a file by its first bytes; None if it is none of those known."""
    with path.open("rb") as file:
        head = file.read(HEAD)
    if not head:
        return "csv"
    return next((name for name, reader in READERS.items() if reader.begins(head)), None)
