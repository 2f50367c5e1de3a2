"""The page of the scripted rules from flown records: the tables of docs/opponents.md and the README, and the chart."""

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rss_gym.eval.metrics import Estimate
from rss_gym.eval.records import SCORES, versions
from rss_gym.eval.text import cell
from rss_gym.files import write_text
from rss_gym.pages import figure, page

LEGEND = "Bars are 95 % intervals; a hollow point had no collision and stands at the upper end of its interval."
TICKS_M = (1, 2, 5, 10, 20, 50, 100)
MARKERS = "osDv^PX"
COLUMNS = {
    "collision_rate": ("collisions", ".2e"),
    "snmac_rate": ("sNMACs", ".2e"),
    "risk_ratio": ("risk ratio", ".4f"),
    "path_deviation_mean_m": ("mean deviation, m", ".1f"),
    "unnecessary_manoeuvre_rate": ("unnecessary manoeuvres", ".3f"),
}


@dataclass(frozen=True)
class Row:
    """One policy's scores."""

    spec: str
    episodes: int
    metrics: dict[str, Estimate]

    def __getitem__(self, name: str) -> str:
        """A metric with its interval."""
        return cell(self.metrics[name], 1.0, COLUMNS[name][1])


def read(folder: Path) -> dict[str, Row]:
    """The policies of a record."""
    scores = json.loads((folder / SCORES).read_text(encoding="utf-8"))
    rows = {}
    for policy in scores["policies"]:
        metrics = {name: Estimate(**value) for name, value in policy["metrics"].items()}
        rows[policy["spec"]] = Row(policy["spec"], scores["episodes"], metrics)
    return rows


def table(titles: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Markdown."""
    lines = [titles, ["---"] * len(titles), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def scores(rows: Iterable[Row]) -> str:
    """All columns of `COLUMNS`."""
    titles = ["policy", "encounters", *(title for title, _ in COLUMNS.values())]
    return table(titles, ([f"`{row.spec}`", f"{row.episodes}", *(row[name] for name in COLUMNS)] for row in rows))


def settings(rows: Iterable[Row]) -> str:
    """Collisions and deviation of the points of the curves."""
    names = ("collision_rate", "path_deviation_mean_m")
    titles = ["policy", "encounters", *(COLUMNS[name][0] for name in names)]
    return table(titles, ([f"`{row.spec}`", f"{row.episodes}", *(row[name] for name in names)] for row in rows))


def by_family(families: dict[str, dict[str, Row]]) -> str:
    """Collisions: a row a policy, a column a family."""
    lines = []
    for spec, row in next(iter(families.values())).items():
        cells = (rows[spec]["collision_rate"] for rows in families.values())
        lines.append([f"`{spec}`", f"{row.episodes}", *cells])
    return table(["policy", "encounters each", *families], lines)


def chart(
    panels: dict[str, dict[str, list[Row]]],
    none: dict[str, Row],
    single: dict[str, list[Row]] | None = None,
    title: str = "track {}",
    label: str = "Collision rate over mean deviation of each rule at several settings, on each track",
) -> str:
    """An SVG of its own: collisions over deviation along the curve of each rule, a panel a track.

    Parameters
    ----------
    panels : dict
        Panel -> rule -> settings along its curve.
    none : dict
        Panel -> the row of `none`.
    single : dict, optional
        Panel -> rows that no line joins: an agent's seeds.
    title : str
        Of a panel, with {} for its name.
    label : str
        What it shows, for readers who do not see it.
    """
    rules = list(dict.fromkeys(rule for curves in panels.values() for rule in curves))
    with figure.figure(label, columns=len(panels), width_in=11.0, height_in=4.6, sharey=True, squeeze=False) as drawing:
        grid = drawing.axes[0]
        for axes, (panel, curves) in zip(grid, panels.items(), strict=True):
            for rule, rows in curves.items():
                index = rules.index(rule)
                _draw(axes, rows, figure.COLOURS[index], MARKERS[index], rule, linewidth=1.2)
            if single and single.get(panel):
                _draw(axes, single[panel], figure.INK, "h", "agents, each seed", linestyle="none")
            rate, path = (none[panel].metrics[name] for name in ("collision_rate", "path_deviation_mean_m"))
            axes.plot(path.value, rate.value, "*", color=figure.NOMINAL, markersize=8, label="none")
            axes.set(title=title.format(panel), xlabel="mean deviation, m", xscale="log", yscale="log")
            axes.set_xticks(TICKS_M, [f"{tick}" for tick in TICKS_M])
            axes.minorticks_off()
        grid[0].set_ylabel("collisions per encounter")
        handles = {}
        for axes in grid:
            handles |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
        grid[0].figure.legend(handles.values(), handles, loc="outside lower center", ncols=len(handles))
    return picture(drawing)


def picture(drawing: figure.Drawing) -> str:
    """A figure of a page as an SVG of its own, with the page's colours."""
    svg = re.sub(r"</?figure[^>]*>", "", drawing.markup)
    style = (page.FOLDER / "style.css").read_text(encoding="utf-8").partition(".nominal")[0]
    return re.sub(r"(<svg[^>]*>)", lambda found: f"{found[1]}<style>{style}</style>", svg, count=1)


def _draw(axes: Any, rows: list[Row], colour: str, marker: str, label: str, **line: Any) -> None:
    """Points with their intervals, hollow at the upper end of it where there was no collision."""
    deviation = [row.metrics["path_deviation_mean_m"].value for row in rows]
    rates = [row.metrics["collision_rate"] for row in rows]
    heights = [rate.value or rate.high for rate in rates]
    ends = [
        [height - (rate.low or height) for height, rate in zip(heights, rates, strict=True)],
        [rate.high - height for height, rate in zip(heights, rates, strict=True)],
    ]
    axes.errorbar(deviation, heights, ends, color=colour, elinewidth=0.8, **line)
    axes.plot([], [], marker=marker, color=colour, markersize=4, label=label, **line)  # for the legend
    for x, height, rate in zip(deviation, heights, rates, strict=True):
        axes.plot(x, height, marker, color=colour, markersize=4, fillstyle="full" if rate.value else "none")


def put(path: Path, name: str, text: str) -> None:
    """Replace what stands between the markers of that name of a file."""
    marked = rf"(<!-- {name} -->\n).*?(\n<!-- /{name} -->)"
    content = path.read_text(encoding="utf-8")
    write_text(path, re.sub(marked, lambda found: found[1] + text + found[2], content, flags=re.DOTALL))


def made(target: str = "table", where: str = "Split `suite`, seed 0; ") -> str:
    """By what, as a sentence."""
    used = ", ".join(f"{name} {number}" for name, number in versions().items())
    return f"{where}95 % intervals in brackets; made by `make {target}` with {used}."
