"""The table that the commands print."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, TextIO

from rss_gym.eval import ranking
from rss_gym.eval.columns import MORE, columns_of
from rss_gym.eval.evaluate import Result
from rss_gym.eval.metrics import Estimate
from rss_gym.eval.ranking import FRONT, Place
from rss_gym.pages.table import Cell, Column, Table

RED, PLAIN = "\x1b[31m", "\x1b[0m"


def coloured(stream: TextIO) -> bool:
    """Whether colours belong into a stream: a terminal, and no NO_COLOR (https://no-color.org)."""
    return stream.isatty() and not os.environ.get("NO_COLOR")


def red(line: str, colour: bool) -> str:
    """The line in red, if colours are wanted."""
    return f"{RED}{line}{PLAIN}" if colour else line


def cell(estimate: Estimate | None, scale: float, form: str, interval: bool = True) -> str:
    """Value and, if wanted, interval."""
    return Column("", form=form, factor=scale, interval=interval).cell(estimate).plain


def table(result: Result, columns: Mapping[str, Column] | None = None, colour: bool = False) -> str:
    """One line a policy, the cheapest of each level of information first: the metrics of `columns` with 95 % intervals.

    Parameters
    ----------
    result : Result
    columns : mapping, optional
        Metric -> column; default: those of the domain.
    colour : bool
        Show policies that are not ranked in red.
    """
    metrics = dict(columns_of(result.suite.params) if columns is None else columns)
    levels = ranking.of(result, differences=True)
    places = [place for order in levels.values() for place in order]
    names = list(metrics)
    at = names.index("cost_m") + 1 if "cost_m" in names else 0
    shown = [metrics[name] for name in names]
    shown[at:at] = [MORE] * bool(at)
    rows = []
    for information, order in levels.items():
        for place in order:
            cells: list[Any] = [result[place.name].get(name) for name in names]
            cells[at:at] = [difference(place)] * bool(at)
            rows.append([number(place), place.name, information, *cells])
    head, rule, *lines = Table(["", "policy", "information", *shown], rows).lines(rule=True)
    lines = [red(line, colour and place.place is None) for line, place in zip(lines, places, strict=True)]
    barred = [place for place in places if place.place is None]
    lines += [red(f"NOT RANKED: {place.name}: {_reason(place)}", colour) for place in barred]
    lines.append(
        f"{result.episodes} encounters of suite {result.suite.name}, split {result.suite.split}, seed {result.seed}; "
        "95 % intervals; rates are per encounter of this distribution, not per flight hour; ranked by cost, the "
        "difference from the first on the same encounters; * no other has both fewer collisions and less deviation"
    )
    return "\n".join([head, rule, *lines])


def number(place: Place) -> Cell:
    """The place, with an asterisk on the front."""
    return Cell(None) if place.place is None else Cell(str(place.place), place.place, mark=FRONT * place.front)


def difference(place: Place) -> Estimate | str | None:
    """How much more a policy costs than the first; nothing for the first."""
    if place.difference is None:
        return None if place.place is None else ""
    return Estimate(*place.difference, unit="m")


def _reason(place: Place) -> str:
    count = f"{place.faults:,} encounter{'s' * (place.faults != 1)}"
    return f"in {count} it gave an action that is not finite"
