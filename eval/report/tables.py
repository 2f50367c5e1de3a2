"""Tables of metrics: a row a policy, a column a metric; a click on a heading sorts."""

from __future__ import annotations

import re

from rss_gym.domain import ROAD, domain_of
from rss_gym.eval import ranking, road
from rss_gym.eval.evaluate import NOMINAL, Result
from rss_gym.eval.metrics import METRICS, Estimate
from rss_gym.eval.ranking import Place
from rss_gym.eval.report import series
from rss_gym.eval.report.numbers import interval, number
from rss_gym.pages.page import text
from rss_gym.params import Params

MAIN = (
    "cost_m",
    "collision_rate",
    "snmac_rate",
    "path_deviation_mean_m",
    "unnecessary_manoeuvre_rate",
    "zone_severity",
    "path_regained_rate",
    "faults",
)
FIRST = (
    '<th scope="col" title="paired difference of the cost from that of the first of its level of information">'
    "more than the first (m)</th>"
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


def main_metrics(world: Params) -> tuple[str, ...]:
    """The metrics of the table that is read first."""
    return road.MAIN if domain_of(world) is ROAD else MAIN


def title(name: str, unit: str) -> str:
    """A metric's name for readers: `min_separation_p0_1_m` is `min separation, 0.1 %`."""
    stem = name.removesuffix(_SUFFIXES.get(unit, "")).replace("snmac", "sNMAC")
    quantile = re.fullmatch(r"(.*)_p(\d+)(?:_(\d+))?", stem)
    if quantile is None:
        return stem.replace("_", " ")
    stem, whole, part = quantile.groups()
    share = "median" if whole == "50" and not part else f"{whole}{'.' + part if part else ''} %"
    return f"{stem.replace('_', ' ')}, {share}"


def cell(estimate: Estimate | None) -> str:
    """Value and interval; the attributes hold all digits."""
    if estimate is None:
        return "<td></td>"
    parts = {"value": estimate.value, "low": estimate.low, "high": estimate.high}
    data = "".join(f' data-{key}="{value!r}"' for key, value in parts.items() if value is not None)
    exact = estimate.low == estimate.value == estimate.high  # a count
    small = f' <span class="interval">{interval(estimate)}</span>' if not exact and interval(estimate) else ""
    return f'<td{data}><span class="value">{number(estimate.value)}</span>{small}</td>'


def heading(name: str) -> str:
    """A column's heading, with its unit and, as a tool tip, its definition."""
    metric = METRICS[name]
    unit = "" if metric.unit in ("1", "count") else f" ({text(metric.unit)})"
    return f'<th scope="col" title="{text(metric.summary)}">{text(title(name, metric.unit))}{unit}</th>'


def policy_heading(name: str, class_: str) -> str:
    """A row's heading, with the colour that the policy has in the charts; long names break between their options."""
    shown = re.sub("[:,]", r"\g<0><wbr>", text(name))
    return f'<th scope="row"><span class="who"><span class="dot {class_}"></span><span>{shown}</span></span></th>'


def barred(place: Place) -> str:
    """The class of the row of a policy that is not ranked: it is red."""
    return "" if place.place is not None else ' class="fault"'


def place_cell(place: Place) -> str:
    """The place, with a star on the front."""
    if place.place is None:
        return "<td>–</td>"
    star = '<abbr title="on the front: no other has both fewer collisions and less deviation">*</abbr>' * place.front
    return f'<td data-value="{place.place}">{place.place}{star}</td>'


def difference(place: Place) -> str:
    """How much more a policy costs than the first."""
    if place.difference is None:
        return "<td>–</td>" if place.place is None else "<td></td>"
    return cell(Estimate(*place.difference, unit="m"))


def ordered(result: Result, differences: bool = False) -> list[tuple[int, Place]]:
    """Index of each policy and its place: level by level of information, the cheapest first."""
    index = {scored.entry.name: number for number, scored in enumerate(result.policies)}
    return [(index[place.name], place) for places in ranking.of(result, differences).values() for place in places]


def table(result: Result, names: list[str], places: bool = False) -> str:
    """The metrics of these names, a row a policy, in order; with `places` also place and difference from the first."""
    classes = series.of(result).classes
    rows = ""
    for index, place in ordered(result, differences=places):
        scored = result.policies[index]
        cells = [cell(scored.metrics.get(name)) for name in names]
        if places:
            cells = [place_cell(place), cells[0], difference(place), *cells[1:]]
        rows += f"<tr{barred(place)}>{policy_heading(scored.entry.name, classes[index])}{''.join(cells)}</tr>\n"
    headings = [heading(name) for name in names]
    if places:
        headings = ['<th scope="col">place</th>', headings[0], FIRST, *headings[1:]]
    head = '<th scope="col">policy</th>' + "".join(headings)
    return scrolled(f'<table class="sortable"><thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody></table>')


def faults(result: Result) -> str:
    """Which policies are not ranked and why, in red; nothing where all are."""
    return "".join(
        f'<p class="fault">{text(place.name)} is {text(place.why_not)}, encounters in which it gave an '
        "action that is not finite.</p>\n"
        for _, place in ordered(result)
        if place.why_not
    )


def scrolled(markup: str) -> str:
    """A frame that scrolls sideways where the window is too narrow for the table."""
    return f'<div class="scroll" tabindex="0">{markup}</div>\n'


def main(result: Result) -> str:
    """The table that is read first."""
    return (
        faults(result)
        + table(result, list(main_metrics(result.suite.params)), places=True)
        + '<p class="note">Ranked by cost, each level of information on its own: mean deviation while flown, plus '
        "100 m for an sNMAC and 10,000 m for a collision. Below each value its 95 % interval; that of what a policy "
        "costs more than the first is of the pairs of flights over the same encounters. * marks the front: no other "
        "policy has both fewer collisions and less deviation. Rates are per encounter of this suite's distribution, "
        f"not per flight hour. {road.NOTE if result.suite.domain is ROAD else ''} Click a heading to sort.</p>"
    )


def everything(result: Result) -> str:
    """All metrics of the policies in groups, and what each means."""
    groups: dict[str, list[str]] = {name: [] for name in (*GROUPS, OTHERS)}
    shown = {name: METRICS[name] for name in result[NOMINAL] if not METRICS[name].sensor}
    for name in shown:
        groups[next((title for title, stems in GROUPS.items() if name.startswith(stems)), OTHERS)].append(name)
    markup = "".join(f"<h3>{text(title)}</h3>\n{table(result, names)}" for title, names in groups.items() if names)
    meanings = "".join(
        f"<dt>{text(title(name, metric.unit))}</dt><dd>{text(metric.summary)}</dd>\n" for name, metric in shown.items()
    )
    return f'{markup}<details><summary>What the columns mean</summary><dl class="meanings">\n{meanings}</dl></details>'
