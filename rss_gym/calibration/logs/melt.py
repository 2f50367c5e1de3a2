"""Wide tables, with columns of their own for each link."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fnmatch import fnmatchcase

from rss_gym.calibration.logs.columns import NAMES, Quantity, found_in, near, plain
from rss_gym.calibration.logs.options import ReadOptions
from rss_gym.params import ParamsError, suggestion

_RSS, _DIST = frozenset(("rss", "rssi", "dbm", "db", "signal")), frozenset(("dist", "distance", "d"))


def melted(
    header: Sequence[str], sample: list[list[str]], found: dict[str, Quantity], options: ReadOptions, source: str
) -> dict[str, dict[str, Quantity]]:
    """The quantities of each link of a wide table, by the link's name.

    Parameters
    ----------
    header : sequence of str
        Names of the columns.
    sample : list of rows
        The first rows, to tell columns of RSS.
    found : dict of str to Quantity
        What holds for all links.
    options : ReadOptions
        `melt` says which columns are those of links.
    source : str
        The file's name, for messages.

    Raises
    ------
    ParamsError
        If no column fits, or a pattern has no star.
    """
    patterns = options.melt or "*"
    if patterns == "*":
        links = _guessed(header, sample, found)
    else:
        links = {}
        for item in patterns.split(","):
            key, equals, pattern = (part.strip() for part in item.rpartition("="))
            key = key if equals else "rss"
            if key not in NAMES:
                raise ParamsError(f"melt: {key!r} is unknown{suggestion(key, NAMES)}")
            if pattern.count("*") != 1:
                raise ParamsError(f"melt: {pattern!r} must hold one star, which stands for the link's name")
            before, after = pattern.split("*")
            for k, name in enumerate(header):
                if fnmatchcase(name, pattern):
                    links.setdefault(name[len(before) : len(name) - len(after)], {})[key] = k
    wide = {name: own for name, own in links.items() if "rss" in own}
    if not wide:
        raise ParamsError(f"log {source!r} has no column of RSS that fits --melt {patterns}{near('rss', header)}")
    taken = {k for own in wide.values() for k in own.values()}
    shared = {key: quantity for key, quantity in found.items() if quantity.index not in taken}
    layouts = {}
    for name, own in wide.items():
        layouts[name] = dict(shared)
        for key, k in own.items():
            quantity = found_in([header[k]], {key: header[k]}, source)[key]
            layouts[name][key] = replace(quantity, index=k)
    return layouts


def _guessed(header: Sequence[str], sample: list[list[str]], found: dict[str, Quantity]) -> dict[str, dict[str, int]]:
    """Columns that say that they are a link's, else those whose numbers are an RSS'."""
    links: dict[str, dict[str, int]] = {}
    taken = {quantity.index for key, quantity in found.items() if key not in ("rss", "dist", "link")}
    for k, column in enumerate(header):
        if k in taken:
            continue
        words = plain(column)[0].split()
        for key, marks in (("rss", _RSS), ("dist", _DIST)):
            name = " ".join(word for word in words if word not in marks)
            if name and set(words) & marks:
                links.setdefault(name, {})[key] = k
                break
        else:
            if _is_rss([row[k] for row in sample if k < len(row)]):
                links.setdefault(" ".join(words), {}).setdefault("rss", k)
    return links


def _is_rss(cells: list[str]) -> bool:
    values = []
    for cell in cells:
        try:
            values.append(float(cell))
        except ValueError:
            continue
    signals = [value for value in values if -150.0 < value < 0.0 and math.isfinite(value)]
    return len(signals) > 0 and 10 * len(signals) >= len(values) and min(signals) < -20.0
