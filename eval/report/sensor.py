"""What the radio does, whoever flies: range errors, missed detections beside the paper's bound (36), false alerts."""

from __future__ import annotations

import dataclasses
import math

from markupsafe import Markup

from rss_gym.eval.evaluate import NOMINAL, Result
from rss_gym.eval.metrics import METRICS, Estimate
from rss_gym.eval.report.charts import FALL, SIZES, Size, ends, height
from rss_gym.eval.report.tables import title
from rss_gym.pages import colours
from rss_gym.pages.figure import CLASSES, Drawing, figure
from rss_gym.pages.markup import renderer
from rss_gym.pages.numbers import full, number
from rss_gym.pages.table import Column, Table

BOUND, FLOWN = "missed_detection_bound", "missed_detection_encounter_rate"
ROW_IN = 0.48  # the height of a probability
MEDIUM, NARROW = dataclasses.replace(SIZES[1], class_="wide medium"), SIZES[2]
COLUMNS = ("figure", Column("value", form=number), Column("unit", words=True), Column("n", form=","),
           Column("meaning", words=True))  # fmt: skip
render = renderer(__file__)


def section(result: Result) -> Markup:
    """The chart of the bound, and the table of all sensor metrics."""
    metrics = result[NOMINAL]
    names = [name for name, metric in METRICS.items() if metric.sensor and name in metrics]
    charts = [chart for size in (MEDIUM, NARROW) if (chart := _chart(metrics, size))]
    return render("sensor.html", charts=charts, table=_table(metrics, names))


def _chart(metrics: dict[str, Estimate], size: Size) -> Markup:
    """One size; nothing where there is nothing to see."""
    rows = [
        ("bound (36), independent errors", metrics.get(BOUND), colours.NOMINAL),
        ("flown, per zone entry", metrics.get(FLOWN), "c0"),
    ]
    shown = [(label, estimate, class_) for label, estimate, class_ in rows if estimate and estimate.value is not None]
    seen = [value for _, e, _ in shown for value in (height(e), e.low, e.high) if value]
    if not seen:
        return Markup("")
    least = min(-2, math.floor(math.log10(min(seen)) - 0.3))
    with figure(
        "Bound (36) beside the flown miss probability", width_in=size.width_in,
        height_in=0.5 + ROW_IN * len(shown), class_=size.class_,
    ) as drawing:  # fmt: skip
        axes = drawing.axes
        axes.set(xscale="log", xlim=(10.0**least, 1.0), ylim=(len(shown) - 0.5, -0.7))
        axes.minorticks_off()
        axes.xaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_visible(False)
        axes.spines["left"].set_visible(False)
        for row, (label, estimate, class_) in enumerate(shown):
            _row(drawing, row, label, estimate, CLASSES[class_])
    return drawing.html


def _row(drawing: Drawing, row: int, label: str, e: Estimate, colour: str) -> None:
    """One probability with its interval, its words above it at the left edge."""
    axes, at, bound = drawing.axes, height(e), e.value == 0.0
    across = [[FALL * at], [0.0]] if bound else ends(e, at)
    axes.errorbar([at], [row], xerr=across, xuplims=bound, fmt="|" if bound else "o", color=colour, markersize=7.0)
    where = axes.get_yaxis_transform()
    axes.text(0.0, row - 0.42, f"{label}: {number(e.value)}", transform=where, fontsize=9.8, va="center")
    drawing.tip(axes, at, row, f"{label}: {full(e, e.unit)}")


def _table(metrics: dict[str, Estimate], names: list[str]) -> Table:
    rows = []
    for name in names:
        metric = METRICS[name]
        unit = "" if metric.unit == "1" else metric.unit
        rows.append([title(name, metric.unit), metrics[name], unit, metrics[name].n, metric.summary])
    return Table(COLUMNS, rows, "sensor")
