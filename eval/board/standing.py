"""Where the entries of a season stand: from the lines of the board, and, where they are at hand, the tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np

from rss_gym.eval import ranking
from rss_gym.eval.board import verdict
from rss_gym.eval.board.fly import Places, tables_of
from rss_gym.eval.costs import Costs, Prices
from rss_gym.eval.suites import SUITES
from rss_gym.params import Information


@dataclass(frozen=True)
class Row:
    """One entry on one suite.

    Attributes
    ----------
    line : dict
        The line of the board.
    place : int or None
        By the cost on sealed encounters; None for one with faults, one that was not flown to its end, and one that
        flies exactly as another.
    front : bool
    more : tuple or None
        How much more it costs than the first, with its 95 % interval.
    why_not : str
        Why it has no place.
    """

    line: dict[str, Any]
    place: int | None
    front: bool
    more: tuple[float | None, float | None, float | None] | None
    why_not: str

    @property
    def alarm(self) -> bool:
        """Whether cost or deviation is surely larger on sealed encounters: it may have memorised the public ones."""
        if self.line["failed"]:
            return False
        return any((self.line[name]["low"] or 0.0) > 0.0 for name in ("gap_m", "deviation_gap_m"))


def newest(lines: Sequence[dict[str, Any]], season: str, suite: str) -> list[dict[str, Any]]:
    """The last line of each entry on a suite: what was flown by older rules stays in the file and is not shown."""
    found: dict[str, dict[str, Any]] = {}
    for line in lines:
        if line["kind"] == verdict.KIND and (line["season"], line["suite"]) == (season, suite):
            found[line["entry_hash"]] = line
    return [line for line in found.values() if line["rules"] == verdict.RULES]


def standings(
    lines: Sequence[dict[str, Any]], season: str, suite: str, places: Places | None = None, sealed: int | None = None
) -> dict[str, list[Row]]:
    """The rows of a suite by level of information.

    Parameters
    ----------
    lines : sequence of dict
        The lines of the board.
    season, suite : str
    places : Places, optional
    sealed : int, optional
        Seed of the sealed encounters; with both the differences from the first are those of pairs of flights.
    """
    shown = newest(lines, season, suite)
    failed = [Row(line, None, False, None, f"not ranked: {line['failed']}") for line in shown if line["failed"]]
    levels: dict[str, list[Row]] = {}
    for level in get_args(Information):
        members = [line for line in shown if not line["failed"] and line["information"] == level]
        if members:
            levels[level] = _ranked(members, places, sealed)
    if failed:
        levels["not flown to the end"] = failed
    return levels


def _ranked(members: list[dict[str, Any]], places: Places | None, sealed: int | None) -> list[Row]:
    rows: list[Row] = []
    seen: dict[str, str] = {}
    counted = []
    for line in members:
        twin = seen.setdefault(line["sealed"]["table_sha256"], line["entry"]["name"])
        if line["faults"]:
            rows.append(Row(line, None, False, None, f"not ranked: {line['faults']} faults"))
        elif twin != line["entry"]["name"]:
            rows.append(Row(line, None, False, None, f"not ranked: it flies exactly as {twin}"))
        else:
            counted.append(line)
    counted.sort(key=lambda line: (_value(line, "cost_m"), line["entry"]["name"]))
    front = ranking.front([(_value(line, "collision_rate"), _value(line, "path_deviation_mean_m")) for line in counted])
    first = _costs(counted[0], places, sealed) if counted else None
    ranked = []
    for index, line in enumerate(counted):
        own = _costs(line, places, sealed) if index and first is not None else None
        pair = own.minus(first)[:3] if own is not None and first is not None and len(own) == len(first) else None
        ranked.append(Row(line, index + 1, front[index], pair, ""))
    return ranked + rows


def _value(line: dict[str, Any], name: str) -> float:
    value = line["sealed"]["metrics"][name]["value"]
    return float(np.inf if value is None else value)


def _costs(line: dict[str, Any], places: Places | None, sealed: int | None) -> Costs | None:
    if places is None or sealed is None:
        return None
    table = tables_of(line, places, sealed, "sealed")
    return None if table is None else Costs.of(table, Prices.of(SUITES[line["suite"]].params))
