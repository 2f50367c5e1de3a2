"""Tables of metrics: a row a policy, a column a metric; a click on a heading sorts."""

from __future__ import annotations

import dataclasses
import re

from markupsafe import Markup

from rss_gym.domain import ROAD
from rss_gym.eval import ranking
from rss_gym.eval.columns import MORE, ROAD_NOTE, columns_of
from rss_gym.eval.evaluate import NOMINAL, Result
from rss_gym.eval.metrics import METRICS
from rss_gym.eval.ranking import Place
from rss_gym.eval.report import series
from rss_gym.eval.text import difference, number
from rss_gym.pages import numbers
from rss_gym.pages.markup import renderer
from rss_gym.pages.table import Cell, Column, Row, Table

render = renderer(__file__)
FIRST = dataclasses.replace(
    MORE,
    form=numbers.number,
    meaning="paired difference of the cost from that of the first of its level of information",
)
# Title -> beginnings of the names; what begins with none of them is listed last.
GROUPS = {
    "Events": ("collision", "snmac", "zone", "faults"),
    "Least separation": ("min_separation",),
    "Against the policy none": ("risk_ratio", "unnecessary"),
    "Cost and path": ("cost", "path", "extra"),
    "Warnings": ("alert", "never_alerted"),
}
OTHERS = "Others"
_SUFFIXES = {"m": "_m", "s": "_s", "1/h": "_ph", "m/s": "_mps"}


def title(name: str, unit: str) -> str:
    """A metric's name for readers: `min_separation_p0_1_m` is `min separation, 0.1 %`."""
    stem = name.removesuffix(_SUFFIXES.get(unit, "")).replace("snmac", "sNMAC")
    quantile = re.fullmatch(r"(.*)_p(\d+)(?:_(\d+))?", stem)
    if quantile is None:
        return stem.replace("_", " ")
    stem, whole, part = quantile.groups()
    share = "median" if whole == "50" and not part else f"{whole}{'.' + part if part else ''} %"
    return f"{stem.replace('_', ' ')}, {share}"


def column(name: str) -> Column:
    """A metric's column on a page: three digits, and its definition as a tool tip."""
    metric = METRICS[name]
    unit = "" if metric.unit in ("1", "count") else metric.unit
    return Column(title(name, metric.unit), unit, numbers.number, meaning=metric.summary)


def barred(place: Place) -> str:
    """The class of the row of a policy that is not ranked: it is red."""
    return "" if place.place is not None else "fault"


def policies(result: Result) -> list[Cell]:
    """The heading of each policy's row, with the colour that it has in the charts."""
    classes = series.of(result).classes
    return [Cell(one.entry.name, dot=class_) for one, class_ in zip(result.policies, classes, strict=True)]


def ordered(result: Result, differences: bool = False) -> list[tuple[int, Place]]:
    """Index of each policy and its place: level by level of information, the cheapest first."""
    index = {scored.entry.name: number for number, scored in enumerate(result.policies)}
    return [(index[place.name], place) for places in ranking.of(result, differences).values() for place in places]


def table(result: Result, names: list[str], places: bool = False) -> Table:
    """The metrics of these names, a row a policy, in order; with `places` also place and difference from the first."""
    heads, rows = policies(result), []
    for index, place in ordered(result, differences=places):
        cells = [result.policies[index].metrics.get(name) for name in names]
        shown = [number(place), cells[0], difference(place), *cells[1:]] if places else cells
        rows.append(Row([heads[index], *shown], barred(place)))
    columns: list[Column | str] = [column(name) for name in names]
    if places:
        columns = ["place", columns[0], FIRST, *columns[1:]]
    return Table(["policy", *columns], rows, "sortable")


def main(result: Result) -> Markup:
    """The table that is read first, and which policies are not ranked and why."""
    return render(
        "scores.html",
        barred=[place for _, place in ordered(result) if place.why_not],
        table=table(result, list(columns_of(result.suite.params)), places=True),
        note=ROAD_NOTE if result.suite.domain is ROAD else "",
    )


def everything(result: Result) -> Markup:
    """All metrics of the policies in groups, and what each means."""
    groups: dict[str, list[str]] = {name: [] for name in (*GROUPS, OTHERS)}
    shown = [name for name in result[NOMINAL] if not METRICS[name].sensor]
    for name in shown:
        groups[next((title for title, stems in GROUPS.items() if name.startswith(stems)), OTHERS)].append(name)
    tables = {title: table(result, names) for title, names in groups.items() if names}
    return render("metrics.html", groups=tables, columns=[column(name) for name in shown])
