"""The tables and the chart of the policies, from flown records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from rss_gym.eval import ranking
from rss_gym.eval.columns import AIR, MORE, REGRET
from rss_gym.eval.costs import Prices
from rss_gym.eval.ranking import Candidate, Place
from rss_gym.eval.reading import load
from rss_gym.eval.studies.study import ScoreRow, read
from rss_gym.eval.text import difference, number
from rss_gym.pages import colours, figure
from rss_gym.pages.table import Cell, Column, Table

TICKS_M = (1, 2, 5, 10, 20, 50, 100, 200)
MARKERS = "osDv^PX"
COLUMNS = {
    name: AIR[name] for name in ("collision_rate", "snmac_rate", "path_deviation_mean_m", "unnecessary_manoeuvre_rate")
}
COLUMNS["unnecessary_manoeuvre_rate"] = replace(AIR["unnecessary_manoeuvre_rate"], interval=True)
SHORT = {
    "cost_m": replace(AIR["cost_m"], form=".1f"),
    "collision_rate": replace(AIR["collision_rate"], unit="%", form=".3f", factor=100.0),
    "snmac_rate": Column("near collisions", "%", ".2f", 100.0),
    "path_deviation_mean_m": Column("mean distance from the path", "m", ".1f"),
}


def short(folders: Sequence[Path]) -> str:
    """The policies of records over the same encounters in order of cost, in words and numbers for the README."""
    rows = sorted(read(folders).values(), key=lambda row: row.metrics["cost_m"].value or float("inf"))
    lines = ([f"`{row.spec}`", *(row.metrics[name] for name in SHORT)] for row in rows)
    return Table(["policy", *SHORT.values()], lines).markdown


def ranked(folders: Sequence[Path]) -> str:
    """The policies of records over the same encounters in order of cost, with all columns of `COLUMNS`.

    The front is marked by an asterisk; a policy with a fault has no place and stands last, in bold.
    """
    rows = read(folders)
    candidates: dict[str, Candidate] = {}
    for record in map(load, folders):
        prices = Prices.of(record.params)
        for policy in record.policies:
            candidates[policy.spec] = Candidate.of(policy.spec, policy.table, prices)
    places = ranking.rank(candidates.values())
    tables_m = [candidate.costs.mean_m for spec, candidate in candidates.items() if spec.split(":")[0] == "qmdp"]
    regret_m = {spec: candidate.costs.mean_m - min(tables_m) for spec, candidate in candidates.items() if tables_m}
    columns = ["place", "policy", AIR["cost_m"], MORE, *([REGRET] if tables_m else []), *COLUMNS.values()]
    return Table(columns, (_line(place, rows[place.name], regret_m) for place in places)).markdown


def _line(place: Place, row: ScoreRow, regret_m: Mapping[str, float]) -> list[Any]:
    """One policy; `regret_m` by specification is empty where the value table has not flown."""
    at = number(place) if place.place else Cell(place.why_not, strong=True)
    more = [difference(place) or "", *([regret_m[row.spec] if place.place else None] if regret_m else [])]
    return [at, f"`{row.spec}`", row.metrics["cost_m"], *more, *(row.metrics[name] for name in COLUMNS)]


def by_family(families: dict[str, dict[str, ScoreRow]]) -> str:
    """Cost and collision rate: a row a family, a column a policy; of the cheapest the cost is bold."""
    specs = list(dict.fromkeys(spec for rows in families.values() for spec in rows))
    lines = []
    for family, rows in families.items():
        least = min(row.metrics["cost_m"].value or 0.0 for row in rows.values())
        lines.append([family, *(_of_family(rows.get(spec), least) for spec in specs)])
    return Table(["family", *(f"`{spec}`" for spec in specs)], lines).markdown


def _of_family(row: ScoreRow | None, least: float) -> str | None:
    if row is None:
        return None
    cost = replace(SHORT["cost_m"], interval=False).cell(row.metrics["cost_m"])
    rate = Column("", form=".1e", interval=False).cell(row.metrics["collision_rate"]).plain
    return f"{replace(cost, strong=cost.value == least).markdown} ({rate})"


def chart(
    panels: dict[str, dict[str, list[ScoreRow]]],
    none: dict[str, ScoreRow],
    single: dict[str, list[ScoreRow]] | None = None,
) -> str:
    """An SVG of its own: sNMACs over deviation along the curve of each rule, a panel a level of information.

    Parameters
    ----------
    panels : dict
        Level -> rule -> settings along its curve.
    none : dict
        Level -> the row of `none`.
    single : dict, optional
        Level -> rows that no line joins: agents.
    """
    rules = list(dict.fromkeys(rule for curves in panels.values() for rule in curves))
    label = "sNMAC rate over mean deviation of each rule at several radii, at each level of information"
    with figure.figure(label, columns=len(panels), width_in=11.0, height_in=4.6, sharey=True, squeeze=False) as drawing:
        grid = drawing.axes[0]
        for axes, (panel, curves) in zip(grid, panels.items(), strict=True):
            for rule, rows in curves.items():
                colour, marker = figure.CLASSES[colours.POLICIES[rule]], MARKERS[rules.index(rule)]
                _draw(axes, rows, colour, marker, rule, linewidth=1.2)
            if single and single.get(panel):
                _draw(axes, single[panel], figure.INK, "h", "agents", linestyle="none")
            rate, path = (none[panel].metrics[name] for name in ("snmac_rate", "path_deviation_mean_m"))
            axes.plot(path.value, rate.value, "*", color=figure.NOMINAL, markersize=8, label="none")
            axes.set(title=f"information: {panel}", xlabel="mean deviation, m", xscale="log", yscale="log")
            axes.set_xticks(TICKS_M, [f"{tick}" for tick in TICKS_M])
            axes.minorticks_off()
        grid[0].set_ylabel("sNMACs per encounter (best: lower left)")
        handles: dict[str, Any] = {}
        for axes in grid:
            handles |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
        grid[0].figure.legend(handles.values(), handles, loc="outside lower center", ncols=len(handles))
    return figure.standalone(drawing.markup)


def _draw(axes: Any, rows: list[ScoreRow], colour: str, marker: str, label: str, **line: Any) -> None:
    """Points with their intervals, hollow at the upper end of it where there was no sNMAC."""
    deviation = [row.metrics["path_deviation_mean_m"].value for row in rows]
    rates = [row.metrics["snmac_rate"] for row in rows]
    heights = [rate.value or rate.high or 0.0 for rate in rates]
    ends = [
        [height - (rate.low or height) for height, rate in zip(heights, rates, strict=True)],
        [(rate.high or height) - height for height, rate in zip(heights, rates, strict=True)],
    ]
    axes.errorbar(deviation, heights, ends, color=colour, elinewidth=0.8, **line)
    axes.plot([], [], marker=marker, color=colour, markersize=4, label=label, **line)  # for the legend
    for x, height, rate in zip(deviation, heights, rates, strict=True):
        axes.plot(x, height, marker, color=colour, markersize=4, fillstyle="full" if rate.value else "none")
