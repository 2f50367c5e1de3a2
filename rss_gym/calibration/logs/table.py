"""Radio logs as tables: delimited text with a header, UTF-8, one row a sample, links interleaved."""

from __future__ import annotations

import csv
import math
from array import array
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn, TextIO

import numpy as np

from rss_gym.calibration.logs.columns import GLOBAL, VELOCITY, VELOCITY_2, Layout, Quantity, layout
from rss_gym.calibration.logs.geodesy import east_north_up_m, range_rate_mps
from rss_gym.calibration.logs.record import DISTANCE_LIMITS_M, ROWS_MAX, Floats, LogFile, LogRecord
from rss_gym.params import ParamsError

LINE_MAX = 65_536  # characters
LINKS_MAX = 1000
NAME_MAX = 60
MISSING = frozenset(("", "na", "null"))  # and whatever float() takes for NaN


def read_table(path: Path, columns: Mapping[str, str]) -> LogFile:
    """Read a delimited text file; comma, semicolon and tab are told apart by the header.

    The file is read line by line, and reading stops at `ROWS_MAX`, so memory stays bounded whatever the size.

    Parameters
    ----------
    path : Path
        The file.
    columns : mapping of str to str
        As for `columns.layout`.

    Raises
    ------
    ParamsError
        When the file is not such a table; the sentence names file, line, column and value.
    """
    try:
        with path.open(encoding="utf-8-sig") as file:
            return _Table(path.name, file, columns).read()
    except UnicodeDecodeError as error:
        raise ParamsError(f"log {path.name!r} is not text in UTF-8: {error.reason}; save it as CSV in UTF-8") from error


@dataclass
class _Link:
    """The rows kept of one link, one after the other: line number, then each quantity that is read."""

    kept: array[float] = field(default_factory=lambda: array("d"))
    last_s: float = -math.inf
    dropped: int = 0


class _Table:
    """The state of reading one file."""

    def __init__(self, source: str, file: TextIO, columns: Mapping[str, str]) -> None:
        self.source = source
        lines = self._lines(file)
        number, line = next(lines, (0, ""))
        if not number:
            raise ParamsError(f"log {source!r} is empty; it must be a table with a header")
        if not line.rstrip("\r\n").replace("\t", " ").isprintable():
            raise ParamsError(f"log {source!r} is not a table of text: line {number} holds control characters")
        self.delimiter = max(",;\t", key=line.count)
        self.header = [name.strip() for name in self._cells(number, line)]
        times = Counter(name for name in self.header if name)
        twice = next((name for name in times if times[name] > 1), None)
        if twice is not None:
            raise ParamsError(f"log {source!r}: the header names {twice[:60]!r} twice; give each column its own name")
        self.lines = lines
        self.layout: Layout = layout(self.header, columns, source)
        quantities = self.layout.quantities.values()  # t and rss first
        self.read_keys = [(quantity, quantity.index) for quantity in quantities if quantity.index is not None]

    def read(self) -> LogFile:
        """Every link of the file."""
        links: dict[str, _Link] = {}
        rows = 0
        for number, line in self.lines:
            cells = self._cells(number, line)
            rows += 1
            if len(cells) != len(self.header):
                self._fail(number, f"{len(cells)} cells where the header has {len(self.header)} columns")
            name = self._link_name(cells)
            values = [self._number(number, quantity, cells[index]) for quantity, index in self.read_keys]
            if name not in links:
                if len(links) == LINKS_MAX or len(name) > NAME_MAX:
                    self._fail(
                        number, f"link {name[:NAME_MAX]!r}; a log has at most {LINKS_MAX} links with short names"
                    )
                links[name] = _Link()
            link, time_s, rss_dbm = links[name], values[0], values[1]
            if not name or math.isnan(sum(values)) or rss_dbm >= 0.0:
                link.dropped += 1
                continue
            if time_s <= link.last_s:
                fault = "a duplicate" if time_s == link.last_s else f"before the {link.last_s!r} of an earlier row"
                self._fail(
                    number,
                    f"time {time_s!r} of link {name!r} is {fault}; the times of a link must increase",
                    self.read_keys[0][0].column,
                )
            link.last_s = time_s
            link.kept.append(number)
            link.kept.extend(values)
        records = [self._record(name, link) for name, link in links.items() if name]
        return LogFile(self.source, records, rows, sum(link.dropped for link in links.values()))

    def _lines(self, file: TextIO) -> Iterator[tuple[int, str]]:
        """The lines that are not blank, with their numbers; a quoted line break is not known in logs."""
        number = 0
        while line := file.readline(LINE_MAX + 1):
            number += 1
            if len(line) > LINE_MAX:
                self._fail(number, f"longer than {LINE_MAX} characters; a row of a log is short")
            if number > ROWS_MAX + 1:
                raise ParamsError(f"log {self.source!r} has more than {ROWS_MAX:,} lines; split it or thin it out")
            if "\0" in line:
                self._fail(number, "a null character; a log must be a table of text")
            if not line.isspace():
                yield number, line

    def _cells(self, number: int, line: str) -> list[str]:
        try:
            cells = next(csv.reader((line,), delimiter=self.delimiter, skipinitialspace=True, strict=True))
        except csv.Error as error:
            self._fail(number, f"not a row of a table: {error}")
        return cells

    def _link_name(self, cells: list[str]) -> str:
        """Name of the row's link, empty when missing."""
        index = self.layout.link_index
        return self.layout.link if index is None else cells[index].strip()

    def _number(self, number: int, quantity: Quantity, text: str) -> float:
        """The value of a cell, NaN when missing."""
        try:
            value = float(text)
        except ValueError:
            if text.strip().lower() in MISSING:
                return math.nan
            value = math.inf
        if not (quantity.low <= value <= quantity.high or math.isnan(value)):
            self._fail(number, f"{quantity.wanted}, got {text[:60]!r}", quantity.column)
        return value

    def _record(self, name: str, link: _Link) -> LogRecord:
        """Distance and range rate from what was kept of one link."""
        kept = np.frombuffer(link.kept).reshape(-1, 1 + len(self.read_keys))
        values = {quantity.key: kept[:, 1 + k] for k, (quantity, _) in enumerate(self.read_keys)}

        def of(*keys: str) -> Floats:
            constant = np.zeros(len(kept))
            quantities = self.layout.quantities
            return np.column_stack([values.get(key, constant + quantities[key].constant) for key in keys])

        distance_m, rate_mps = values.get("dist"), None
        if self.layout.ends:
            first, second = of(*self.layout.ends[:3]), of(*self.layout.ends[3:])
            relative_m = east_north_up_m(first, second) if self.layout.ends == GLOBAL else first - second
            length_m = np.linalg.norm(relative_m, axis=1)
            bad = np.flatnonzero((length_m < DISTANCE_LIMITS_M[0]) | (length_m > DISTANCE_LIMITS_M[1]))
            if bad.size:
                self._fail(
                    int(kept[bad[0], 0]),
                    f"the positions are {length_m[bad[0]]:g} m apart; a distance must be in "
                    f"[{DISTANCE_LIMITS_M[0]:g}, {DISTANCE_LIMITS_M[1]:g}] m",
                )
            distance_m = length_m if distance_m is None else distance_m
            if "vx" in self.layout.quantities:
                relative_mps = of(*VELOCITY)
                if "vx2" in self.layout.quantities:
                    relative_mps = relative_mps - of(*VELOCITY_2)
                rate_mps = range_rate_mps(relative_m, relative_mps)
        assert distance_m is not None  # the layout has it, or positions
        time_s, rss_dbm = values["t"].copy(), values["rss"].copy()
        return LogRecord(name, self.source, time_s, rss_dbm, distance_m.copy(), rate_mps, link.dropped)

    def _fail(self, number: int, what: str, column: str = "") -> NoReturn:
        place = f"line {number}, column {column[:60]!r}" if column else f"line {number}"
        raise ParamsError(f"log {self.source!r}, {place}: {what}")
