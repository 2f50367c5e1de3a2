"""Where the table of a text file begins, and what separates its columns."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rss_gym.calibration.logs.columns import NAMES, plain
from rss_gym.params import ParamsError

LOOK_LINES = 200  # from the beginning of the file
_DELIMITERS = (",", ";", "\t", "|", " ")
_MARKS = ("#", "%", "//")
_NUMBER = re.compile(r"\s*[-+]?(\d+([.,]\d*)?|[.,]\d+)(e[-+]?\d+)?\s*(dbm|db|m|ms|s)?\s*$", re.IGNORECASE)
_STAMP = re.compile(r"\s*(\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4})?[T ]?\d{1,2}:\d{2}(:\d{2}([.,]\d+)?)?\S*\s*$")
_KNOWN = {name for names in NAMES.values() for name in names}


@dataclass(frozen=True)
class Dialect:
    """How the rows of a file are split.

    Attributes
    ----------
    delimiter : str
        A blank stands for any number of blanks.
    header : tuple of str
        Names of the columns; their numbers from 1 where the file has none.
    first : int
        Number of the first line that may be a row, from 1.
    """

    delimiter: str
    header: tuple[str, ...]
    first: int


def split(line: str, delimiter: str) -> list[str]:
    """The cells of a line; raises csv.Error for what is no row."""
    if delimiter == " ":
        return line.split()
    if '"' not in line:
        return line.rstrip("\r\n").split(delimiter)
    return next(csv.reader((line,), delimiter=delimiter, skipinitialspace=True, strict=True))


def is_number(cell: str) -> bool:
    """Whether a cell holds a number or a time."""
    return bool(_NUMBER.match(cell) or _STAMP.match(cell))


def uncommented(line: str) -> tuple[str, bool]:
    """A line without the mark of a comment, and whether it had one."""
    text = line.lstrip()
    mark = next((mark for mark in _MARKS if text.startswith(mark)), None)
    return (text[len(mark) :].lstrip(), True) if mark else (line, False)


def dialect(lines: Sequence[tuple[int, str]], columns: Mapping[str, str], source: str) -> Dialect:
    """Find the table in the first lines of a file.

    Lines of prose before it are passed over: the table begins where the same number of cells goes on, and its header is
    the last line before its first row of numbers, be it a comment or not.

    Parameters
    ----------
    lines : sequence of (number, text)
        The first lines that are not blank.
    columns : mapping of str to str
        As for `columns.found_in`: a file without a header needs numbers.
    source : str
        The file's name, for messages.

    Raises
    ------
    ParamsError
        For a file without a header whose columns were not named by number.
    """
    best = max(_DELIMITERS, key=lambda delimiter: _evidence(lines, delimiter))
    if _evidence(lines, best)[0] == 0:
        best = max(",;\t", key=lines[0][1].count)
    width = _evidence(lines, best)[1]
    data = [k for k, (_, line) in enumerate(lines) if _is_row(line, best) and len(_cells(line, best)) == width]
    start = data[0] if data else None
    if start is None:
        head = next((k for k, (_, line) in enumerate(lines) if not uncommented(line)[1]), 0)
        return Dialect(best, _names(lines[head][1], best), lines[head][0] + 1)
    above = next((k for k in range(start - 1, -1, -1) if _is_header(lines[k][1], best, width)), None)
    if above is not None:
        return Dialect(best, _names(lines[above][1], best), lines[start][0])
    if any(key.isdecimal() for key in columns):
        return Dialect(best, tuple(str(k + 1) for k in range(width)), lines[start][0])
    raise ParamsError(
        f"log {source!r} has no header, line {lines[start][0]} is {lines[start][1].strip()[:60]!r}; name its "
        "columns by "
        "number: --columns 1=t,2=rss,3=dist"
    )


def _cells(line: str, delimiter: str) -> list[str]:
    try:
        return split(line, delimiter)
    except (csv.Error, StopIteration):
        return []


def _is_row(line: str, delimiter: str) -> bool:
    """At least half of the cells that hold something are numbers or times, and two of them."""
    if uncommented(line)[1]:
        return False
    cells = [cell for cell in _cells(line, delimiter) if cell.strip()]
    numbers = sum(map(is_number, cells))
    return numbers >= 2 and 2 * numbers >= len(cells)


def _is_header(line: str, delimiter: str, width: int) -> bool:
    names = _names(line, delimiter)
    filled = [name for name in names if name]
    if len(names) != width or not filled or sum(map(is_number, filled)) > len(filled) // 2:
        return False
    return not uncommented(line)[1] or any(plain(name)[0] in _KNOWN for name in filled)


def _names(line: str, delimiter: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in _cells(uncommented(line)[0], delimiter))


def _evidence(lines: Sequence[tuple[int, str]], delimiter: str) -> tuple[float, int]:
    """How many rows of numbers of the commonest width there are, by the share of numbers in each, and this width."""
    widths: dict[int, float] = {}
    for _, line in lines:
        if _is_row(line, delimiter):
            cells = _cells(line, delimiter)
            widths[len(cells)] = widths.get(len(cells), 0.0) + sum(map(is_number, cells)) / len(cells)
    if not widths:
        return 0.0, 0
    width, score = max(widths.items(), key=lambda item: (item[1], item[0]))
    return score, width
