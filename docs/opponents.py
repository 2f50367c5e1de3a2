"""The page of the scripted rules from flown records: the tables of docs/opponents.md and the README, and the chart."""

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

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


def chart(tracks: dict[str, dict[str, list[Row]]], none: dict[str, Row]) -> str:
    """An SVG of its own: collisions over deviation along the curve of each rule, a panel a track."""
    rules = list(dict.fromkeys(rule for curves in tracks.values() for rule in curves))
    label = "Collision rate over mean deviation of each rule at several settings, on each track"
    with figure.figure(label, columns=len(tracks), width_in=11.0, height_in=4.6, sharey=True) as drawing:
        for axes, (track, curves) in zip(drawing.axes, tracks.items(), strict=True):
            for rule, rows in curves.items():
                index = rules.index(rule)
                colour, marker = figure.COLOURS[index], MARKERS[index]
                deviation = [row.metrics["path_deviation_mean_m"].value for row in rows]
                rates = [row.metrics["collision_rate"] for row in rows]
                # Without a collision the point is the upper end of the interval, hollow.
                heights = [rate.value or rate.high for rate in rates]
                ends = [
                    [height - (rate.low or height) for height, rate in zip(heights, rates, strict=True)],
                    [rate.high - height for height, rate in zip(heights, rates, strict=True)],
                ]
                axes.errorbar(deviation, heights, ends, color=colour, linewidth=1.2, elinewidth=0.8, label=rule)
                for x, height, rate in zip(deviation, heights, rates, strict=True):
                    axes.plot(x, height, marker, color=colour, markersize=4, fillstyle="full" if rate.value else "none")
            rate, path = (none[track].metrics[name] for name in ("collision_rate", "path_deviation_mean_m"))
            axes.plot(path.value, rate.value, "*", color=figure.NOMINAL, markersize=8, label="none")
            axes.set(title=f"track {track}", xlabel="mean deviation, m", xscale="log", yscale="log")
            axes.set_xticks(TICKS_M, [f"{tick}" for tick in TICKS_M])
            axes.minorticks_off()
        drawing.axes[0].set_ylabel("collisions per encounter")
        handles = {}
        for axes in drawing.axes:
            handles |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
        drawing.axes[0].figure.legend(handles.values(), handles, loc="outside lower center", ncols=len(handles))
    return picture(drawing)


def picture(drawing: figure.Drawing) -> str:
    """A figure of a page as an SVG of its own, with the page's colours."""
    svg = re.sub(r"</?figure[^>]*>", "", drawing.markup)
    style = (page.FOLDER / "style.css").read_text(encoding="utf-8").partition(".nominal")[0]
    return re.sub(r"(<svg[^>]*>)", lambda found: f"{found[1]}<style>{style}</style>", svg, count=1)


def put(path: Path, name: str, text: str) -> None:
    """Replace what stands between the markers of that name of a file."""
    marked = rf"(<!-- {name} -->\n).*?(\n<!-- /{name} -->)"
    content = path.read_text(encoding="utf-8")
    write_text(path, re.sub(marked, lambda found: found[1] + text + found[2], content, flags=re.DOTALL))


def made() -> str:
    """By what, as a sentence."""
    used = ", ".join(f"{name} {number}" for name, number in versions().items())
    return f"Split `suite`, seed 0; 95 % intervals in brackets; made by `make table` with {used}."
