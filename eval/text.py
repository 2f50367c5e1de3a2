"""The table that the commands print."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TextIO

from rss_gym.domain import ROAD
from rss_gym.eval import ranking, road
from rss_gym.eval.evaluate import Result
from rss_gym.eval.metrics import Estimate
from rss_gym.eval.ranking import Place

# Metric -> title, factor, format, and whether its interval is shown.
Columns = Mapping[str, tuple[str, float, str] | tuple[str, float, str, bool]]

COLUMNS: Columns = {
    "cost_m": ("cost m", 1.0, ".2f"),
    "collision_rate": ("collision rate", 1.0, ".2e"),
    "snmac_rate": ("sNMAC rate", 1.0, ".2e"),
    "path_deviation_mean_m": ("deviation m", 1.0, ".2f"),
    "unnecessary_manoeuvre_rate": ("unnecessary", 1.0, ".3f", False),
    "zone_severity": ("zone severity", 1.0, ".3f", False),
    "path_regained_rate": ("path regained", 1.0, ".3f", False),
    "faults": ("faults", 1.0, ",.0f", False),
}
RED, PLAIN = "\x1b[31m", "\x1b[0m"


def coloured(stream: TextIO) -> bool:
    """Whether colours belong into a stream: a terminal, and no NO_COLOR (https://no-color.org)."""
    return stream.isatty() and not os.environ.get("NO_COLOR")


def red(line: str, colour: bool) -> str:
    """The line in red, if colours are wanted."""
    return f"{RED}{line}{PLAIN}" if colour else line


def cell(estimate: Estimate | None, scale: float, form: str, interval: bool = True) -> str:
    """Value and, if wanted, interval."""
    if estimate is None or estimate.value is None:
        return "-"
    text = format(estimate.value * scale, form)
    if not interval or estimate.low is None or estimate.high is None:
        return text
    return f"{text} [{format(estimate.low * scale, form)}, {format(estimate.high * scale, form)}]"


def table(result: Result, columns: Columns | None = None, colour: bool = False) -> str:
    """One line a policy, the cheapest of each level of information first: the metrics of `columns` with 95 % intervals.

    Parameters
    ----------
    result : Result
    columns : mapping, optional
        Metric -> title, factor, format and, if given, whether its interval is shown; default: those of the domain.
    colour : bool
        Show policies that are not ranked in red.
    """
    if columns is None:
        columns = road.COLUMNS if result.suite.domain is ROAD else COLUMNS
    titles = {name: [column[0]] for name, column in columns.items()}
    if "cost_m" in titles:
        titles["cost_m"].append("more than the first m")
    rows = [["", "policy", "information", *(title for group in titles.values() for title in group)]]
    places: list[Place | None] = [None]
    for information, order in ranking.of(result, differences=True).items():
        for place in order:
            metrics = result[place.name]
            cells = {name: [cell(metrics.get(name), *form[1:])] for name, form in columns.items()}
            if "cost_m" in cells:
                cells["cost_m"].append(_difference(place))
            number = "-" if place.place is None else f"{place.place}{'*' * place.front}"
            rows.append([number, place.name, information, *(text for group in cells.values() for text in group)])
            places.append(place)
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = ["  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    lines = [
        red(line, colour and place is not None and place.place is None)
        for line, place in zip(lines, places, strict=True)
    ]
    lines.insert(1, "  ".join("-" * width for width in widths))
    barred = [place for place in places if place is not None and place.place is None]
    lines += [red(f"NOT RANKED: {place.name}: {_reason(place)}", colour) for place in barred]
    lines.append(
        f"{result.episodes} encounters of suite {result.suite.name}, split {result.suite.split}, seed {result.seed}; "
        "95 % intervals; rates are per encounter of this distribution, not per flight hour; ranked by cost, the "
        "difference from the first on the same encounters; * no other has both fewer collisions and less deviation"
    )
    return "\n".join(lines)


def _reason(place: Place) -> str:
    count = f"{place.faults:,} encounter{'s' * (place.faults != 1)}"
    return f"in {count} it gave an action that is not finite"


def _difference(place: Place) -> str:
    if place.difference is None or place.difference.value is None:
        return ""
    value, low, high, _ = place.difference
    return f"{value:+.2f}" if low is None or high is None else f"{value:+.2f} [{low:+.2f}, {high:+.2f}]"
