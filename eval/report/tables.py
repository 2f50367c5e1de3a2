"""Tables of metrics: a row a policy, a column a metric; a click on a heading sorts."""

from __future__ import annotations

import re

from rss_gym.eval.evaluate import NOMINAL, Result
from rss_gym.eval.metrics import METRICS, Estimate
from rss_gym.eval.report import series
from rss_gym.eval.report.numbers import interval, number
from rss_gym.pages.page import text

MAIN = ("collision_rate", "snmac_rate", "risk_ratio", "path_deviation_mean_m", "unnecessary_manoeuvre_rate")
# Title -> beginnings of the names; what begins with none of them is listed last.
GROUPS = {
    "Events": ("collision", "snmac", "zone", "faults"),
    "Least separation": ("min_separation",),
    "Against the policy none": ("risk_ratio", "unnecessary"),
    "Path and cost": ("path", "extra", "cost"),
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


def table(result: Result, names: list[str]) -> str:
    """The metrics of these names, a row a policy."""
    classes = series.of(result).classes
    rows = ""
    for scored, class_ in zip(result.policies, classes, strict=True):
        cells = "".join(cell(scored.metrics.get(name)) for name in names)
        rows += f"<tr>{policy_heading(scored.entry.name, class_)}{cells}</tr>\n"
    headings = '<th scope="col">policy</th>' + "".join(heading(name) for name in names)
    return scrolled(f'<table class="sortable"><thead><tr>{headings}</tr></thead>\n<tbody>\n{rows}</tbody></table>')


def scrolled(markup: str) -> str:
    """A frame that scrolls sideways where the window is too narrow for the table."""
    return f'<div class="scroll" tabindex="0">{markup}</div>\n'


def main(result: Result) -> str:
    """The table that is read first."""
    return (
        table(result, [name for name in MAIN if name in METRICS])
        + '<p class="note">Below each value its 95 % interval. Rates are per encounter of this suite\'s distribution, '
        f"not per flight hour; the risk ratio is relative to {NOMINAL} on the same encounters. "
        "Click a heading to sort.</p>"
    )


def everything(result: Result) -> str:
    """All metrics of the policies in groups, and what each means."""
    groups: dict[str, list[str]] = {name: [] for name in (*GROUPS, OTHERS)}
    for name, metric in METRICS.items():
        if not metric.sensor:
            groups[next((title for title, stems in GROUPS.items() if name.startswith(stems)), OTHERS)].append(name)
    markup = "".join(f"<h3>{text(title)}</h3>\n{table(result, names)}" for title, names in groups.items() if names)
    meanings = "".join(
        f"<dt>{text(title(name, metric.unit))}</dt><dd>{text(metric.summary)}</dd>\n"
        for name, metric in METRICS.items()
        if not metric.sensor
    )
    return f'{markup}<details><summary>What the columns mean</summary><dl class="meanings">\n{meanings}</dl></details>'
