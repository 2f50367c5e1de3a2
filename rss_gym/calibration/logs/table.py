"""Radio logs as tables: delimited text, one row a sample, links interleaved or side by side."""

from __future__ import annotations

import csv
import math
import re
from array import array
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import chain, islice
from pathlib import Path
from typing import NoReturn, TextIO

import numpy as np

from rss_gym.calibration.logs import columns as names
from rss_gym.calibration.logs.clock import time_parser, time_unit, unwrapped
from rss_gym.calibration.logs.columns import GLOBAL, LOCAL, Quantity
from rss_gym.calibration.logs.dialect import LOOK_LINES, dialect, split, uncommented
from rss_gym.calibration.logs.melt import melted
from rss_gym.calibration.logs.options import TIME_UNITS, ReadOptions
from rss_gym.calibration.logs.record import (
    CORRUPT,
    LIMITS,
    MISSING,
    NOT_ARMED,
    ROWS_MAX,
    USED,
    Floats,
    LogFile,
    Rows,
)
from rss_gym.calibration.logs.table_ends import Truth, add_distance
from rss_gym.params import ParamsError

LINE_MAX = 65_536  # characters
LINKS_MAX = 1000
NAME_MAX = 60
TIME_MAX_S = 1e11  # on either side of 0: beyond, steps of the clock are lost in rounding
NOTHING = frozenset(("", "na", "n/a", "null", "none", "nan", "-", "--"))  # a cell that says that there is no value
_PLAIN = re.compile(r"([-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?)\s*(?:dBm|dB|m|ms|s)?$", re.IGNORECASE)
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f]")
_TRUE = {"1": 1.0, "true": 1.0, "yes": 1.0, "armed": 1.0, "0": 0.0, "false": 0.0, "no": 0.0, "disarmed": 0.0}


def is_table(head: bytes) -> bool:
    """Whether the first bytes of a file are text."""
    return bool(head) and 100 * len(_CONTROL.findall(head)) < len(head)  # one damaged cell is no other format


def read_table(path: Path, options: ReadOptions) -> LogFile:
    """Read a delimited text file.

    The file is read line by line, and reading stops at `ROWS_MAX`, so memory stays bounded whatever the size.

    Parameters
    ----------
    path : Path
        The file.
    options : ReadOptions
        Columns, unit of time, wide columns, truth, station.

    Raises
    ------
    ParamsError
        When the file is not such a table; the sentence names file, line, column and value.
    """
    for encoding in ("utf-8-sig", "cp1252"):  # the latter for the degree signs of older programs
        try:
            with path.open(encoding=encoding) as file:
                return Table(path.name, file, options).read()
        except UnicodeDecodeError as error:
            reason = error.reason
    raise ParamsError(f"log {path.name!r} is not text in UTF-8: {reason}; save it as CSV in UTF-8")


@dataclass
class _Link:
    """The rows of one link, one after the other: line number, reason, time, then each quantity that is read."""

    kept: array[float] = field(default_factory=lambda: array("d"))


@dataclass(frozen=True)
class Layout:
    """The columns of one link, or of all links where a column names them."""

    link: str
    quantities: dict[str, Quantity]


class Table:
    """The state of reading one file."""

    def __init__(self, source: str, file: TextIO, options: ReadOptions, needs_rss: bool = True) -> None:
        """Read up to the header."""
        self.source, self.options = source, options
        lines = self._lines(file)
        first = list(islice(lines, LOOK_LINES))
        if not first:
            raise ParamsError(f"log {source!r} is empty; it must be a table with a header")
        text = "".join(line for _, line in first)
        if not is_table(text.encode("utf-8", "surrogatepass")):
            raise ParamsError(
                f"log {source!r} is not text in UTF-8, it holds control characters; save it as CSV in UTF-8"
            )
        self.dialect = dialect(first, options.columns, source)
        self.header = self.dialect.header
        times = Counter(name for name in self.header if name)
        twice = next((name for name in times if times[name] > 1), None)
        if twice is not None:
            raise ParamsError(f"log {source!r}: the header names {twice[:60]!r} twice; give each column its own name")
        self.lines = ((number, line) for number, line in chain(first, lines) if number >= self.dialect.first)
        columns = options.columns
        if options.truth is not None:  # the other names are those of the truth's columns
            columns = {key: name for key, name in columns.items() if key.isdecimal() or name in self.header}
        found = names.found_in(self.header, columns, source)
        self.layouts = [Layout("link", found)]
        if options.melt is not None and needs_rss:
            sample = [split(line, self.dialect.delimiter) for number, line in first if number >= self.dialect.first]
            self.layouts = [
                Layout(link, own) for link, own in melted(self.header, sample, found, options, source).items()
            ]
        self.found = found
        if needs_rss:
            for layout in self.layouts:
                names.checked(layout.quantities, columns, self.header, source)
        self.file = LogFile(source, f"table, {_WORDS[self.dialect.delimiter]}", [])
        self.file.columns = self._taken()
        self._time: Callable[[str], float] | None = None
        self._kind = "number"

    def _taken(self) -> dict[str, str]:
        """Key to the name of its column, or its number in every row; the columns that are not used under ""."""
        taken: dict[str, list[str]] = {}
        used = set()
        for layout in self.layouts:
            for key, quantity in layout.quantities.items():
                used.add(quantity.index)
                if quantity.column not in taken.setdefault(key, []):
                    taken[key].append(quantity.column)
        rest = [name for k, name in enumerate(self.header) if k not in used]
        return {key: ", ".join(names) for key, names in taken.items()} | ({"": ", ".join(rest)} if rest else {})

    def read(self) -> LogFile:
        """Every link of the file with its distances."""
        links = self.values(("rss", "armed", *_DISTANCES))
        self._scale_times(links)
        truth = None if self.options.truth is None else self._truth(Path(self.options.truth))
        for name, values in links.items():
            self._armed(values)
            rows = Rows(
                link=name,
                number=values["number"],
                time_s=values["t"],
                rss_dbm=values["rss"],
                distance_m=np.full(values["t"].size, np.nan),
                range_rate_mps=None,
                reason=values["reason"].astype(np.uint8),
            )
            self.file.rows.append(rows)
            add_distance(self, rows, values, truth)
        return self.file

    def _truth(self, path: Path) -> Truth:
        columns = {key: name for key, name in self.options.columns.items() if not key.isdecimal()}
        options = replace(self.options, melt=None, truth=None)
        try:
            with path.open(encoding="utf-8-sig") as file:
                header = Table(path.name, file, replace(options, columns={}), needs_rss=False).header
            own = {key: name for key, name in columns.items() if name in header}
            with path.open(encoding="utf-8-sig") as file:
                reader = Table(path.name, file, replace(options, columns=own), needs_rss=False)
                if "t" not in reader.found:
                    raise ParamsError(f"truth {path.name!r} has no column for t; name it by t=NAME")
                links = reader.values(_DISTANCES)
                reader._scale_times(links)
        except OSError as error:
            raise ParamsError(f"truth {str(path)!r} cannot be read: {error}") from error
        except UnicodeDecodeError as error:
            raise ParamsError(f"truth {path.name!r} is not text in UTF-8: {error.reason}") from error
        return Truth(links, reader.found)

    def values(self, wanted: tuple[str, ...]) -> dict[str, dict[str, Floats]]:
        """The numbers of every link by key, with the numbers of their lines and the reason of rows that are no rows."""
        links: dict[str, _Link] = {}
        layouts = [
            (layout, [(q, q.index) for key, q in layout.quantities.items() if key in wanted and q.index is not None])
            for layout in self.layouts
        ]
        by_link = self.found.get("link")
        at = by_link.index if by_link is not None else None
        fixed = by_link.column if by_link is not None and at is None else None
        time, date = self.found["t"].index, self.found["date"].index if "date" in self.found else None
        assert time is not None  # `checked` sees to it
        for number, line in self.lines:
            if uncommented(line)[1]:
                continue
            cells, reason = self._cells(number, line)
            stamp = self._stamp(number, cells, time, date) if not reason else math.nan
            if not reason and math.isnan(stamp):
                reason = MISSING
            for layout, quantities in layouts:
                name = layout.link if fixed is None else fixed
                if at is not None:
                    name = cells[at].strip() if at < len(cells) else ""
                    name = name or (next(iter(links)) if links else "link") if reason else name
                    if not name:
                        self.file.example(MISSING, f"line {number}, no link")
                        name, reason = next(iter(links), "link"), MISSING
                if name not in links:
                    if len(links) == LINKS_MAX or len(name) > NAME_MAX:
                        self._fail(
                            number, f"link {name[:NAME_MAX]!r}; a log has at most {LINKS_MAX} links with short names"
                        )
                    links[name] = _Link()
                link = links[name]
                head = len(link.kept)
                link.kept.extend((number, reason, stamp))
                for quantity, column in quantities:
                    value, fault = (math.nan, USED) if reason else self._number(number, quantity, cells[column])
                    if fault and not link.kept[head + 1]:
                        link.kept[head + 1] = fault
                    link.kept.append(value)
        found: dict[str, dict[str, Floats]] = {}
        several = {layout.link: quantities for layout, quantities in layouts}
        for name, link in links.items():
            own = several.get(name, layouts[0][1])
            table = np.frombuffer(link.kept).reshape(-1, 3 + len(own))
            values = {"number": table[:, 0], "reason": table[:, 1].copy(), "t": table[:, 2].copy()}
            values |= {quantity.key: table[:, 3 + k].copy() for k, (quantity, _) in enumerate(own)}
            if len(self.layouts) > 1:  # an access point that was not heard is no fault
                heard = ~np.isnan(values["rss"])
                values = {key: value[heard] for key, value in values.items()}
            layout = next((one for one in self.layouts if one.link == name), self.layouts[0])
            for key, quantity in layout.quantities.items():
                if key in wanted and quantity.index is None:
                    values[key] = np.full(values["t"].size, quantity.constant)
            found[name] = values
        return found

    def _scale_times(self, links: dict[str, dict[str, Floats]]) -> None:
        """Times in s."""
        if self._kind == "clock":
            for values in links.values():
                good = np.isfinite(values["t"])
                values["t"][good] = unwrapped(values["t"][good])
        if self._kind != "number":
            return
        pairs = [(v["t"], v.get("dist", np.full(v["t"].size, np.nan))) for v in links.values()]
        unit, why = self.options.time_unit or self.found["t"].unit, ""
        if not unit:
            unit, why = time_unit(pairs)
        if unit != "s":
            if why:
                self.file.notes.append(f"time is taken as {unit}: {why}; name another by --time-unit")
            for values in links.values():
                values["t"] *= TIME_UNITS[unit]
        for values in links.values():
            values["t"][np.abs(values["t"]) > TIME_MAX_S] = math.nan
        self.file.format += f", time in {unit}"

    def _armed(self, values: dict[str, Floats]) -> None:
        if "armed" in values and not self.options.whole and (values["armed"] == 1.0).any():
            values["reason"][(values["armed"] == 0.0) & (values["reason"] == USED)] = NOT_ARMED

    def _lines(self, file: TextIO) -> Iterator[tuple[int, str]]:
        """The lines that are not blank, with their numbers; a quoted line break is not known in logs."""
        number = 0
        while line := file.readline(LINE_MAX + 1):
            number += 1
            if len(line) > LINE_MAX:
                self._fail(number, f"longer than {LINE_MAX} characters; a row of a log is short")
            if number > ROWS_MAX + 1:
                raise ParamsError(f"log {self.source!r} has more than {ROWS_MAX:,} lines; split it or thin it out")
            if not line.isspace():
                yield number, line

    def _cells(self, number: int, line: str) -> tuple[list[str], int]:
        try:
            if "\0" in line:
                raise csv.Error("a null character")
            cells = split(line, self.dialect.delimiter)
        except (csv.Error, StopIteration) as error:
            self.file.example(CORRUPT, f"line {number}, not a row of a table: {error}")
            return [], CORRUPT
        while len(cells) > len(self.header) and not cells[-1].strip():
            cells.pop()  # a delimiter at the end of the row
        if len(cells) != len(self.header):
            self.file.example(CORRUPT, f"line {number}, {len(cells)} cells where the header has {len(self.header)}")
            return cells, CORRUPT
        return cells, USED

    def _stamp(self, number: int, cells: list[str], time: int, date: int | None) -> float:
        text = cells[time].strip() if date is None else f"{cells[date].strip()} {cells[time].strip()}"
        if text.lower() in NOTHING:
            self.file.example(MISSING, f"line {number}, column {self.header[time][:60]!r}")
            return math.nan
        if self._time is None:
            parser = time_parser(text)
            if parser is not None:
                self._kind, self._time = parser
                self.file.format += "" if self._kind == "number" else f", time as a {self._kind}"
        try:
            if self._time is None:
                raise ValueError(text)
            value = self._time(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            self.file.example(
                MISSING, f"line {number}, column {self.header[time][:60]!r}: t must be a time, got {text[:60]!r}"
            )
            return math.nan
        return value

    def _number(self, number: int, quantity: Quantity, text: str) -> tuple[float, int]:
        """The value of a cell in SI, NaN when missing, and the reason why the row cannot be used."""
        if quantity.key == "armed":
            return _TRUE.get(text.strip().lower(), math.nan), USED
        try:
            value = float(text)
        except ValueError:
            found = _PLAIN.match(text.strip())
            if found is None:
                if text.strip().lower() in NOTHING:
                    return math.nan, USED
                self._example(CORRUPT, number, quantity, text)
                return math.nan, CORRUPT
            value = float(found.group(1).replace(",", "."))
        value *= quantity.factor
        if quantity.low <= value <= quantity.high or math.isnan(value):
            return value, USED
        if quantity.key in ("lat", "lon", "lat2", "lon2") and abs(value) > 1e6:
            return self._number(number, _scaled(quantity, 1e-7), text)
        self._example(LIMITS, number, quantity, text)
        return math.nan, LIMITS

    def _example(self, reason: int, number: int, quantity: Quantity, text: str) -> None:
        place = f"line {number}, column {quantity.column[:60]!r}"
        self.file.example(reason, f"{place}: {quantity.wanted}, got {text.strip()[:60]!r}")

    def _fail(self, number: int, what: str) -> NoReturn:
        raise ParamsError(f"log {self.source!r}, line {number}: {what}")


def _scaled(quantity: Quantity, factor: float) -> Quantity:
    """Degrees times 1e7, as autopilots write them."""
    return Quantity(
        quantity.key,
        quantity.column,
        quantity.index,
        quantity.constant,
        quantity.low,
        quantity.high,
        quantity.what,
        factor,
    )


_DISTANCES = ("dist", "rate", *LOCAL, *GLOBAL, *names.VELOCITY, *names.VELOCITY_2, *names.COMPASS, *names.POLAR)
_WORDS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", " ": "blanks"}
