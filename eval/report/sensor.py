"""What the radio does, whoever flies: range errors, missed detections beside the paper's bound (36), false alerts."""

from __future__ import annotations

import math
from typing import Any

from markupsafe import Markup

from rss_gym.eval.evaluate import NOMINAL, Result
from rss_gym.eval.metrics import METRICS, Estimate
from rss_gym.eval.report.charts import ARROW_PX, SIZES, Size, height
from rss_gym.eval.report.scales import Decades
from rss_gym.eval.report.tables import title
from rss_gym.pages.markup import renderer
from rss_gym.pages.numbers import full, number
from rss_gym.pages.table import Column, Table

BOUND, FLOWN = "missed_detection_bound", "missed_detection_encounter_rate"
ROW_PX, TYPE_PX = 46.0, 7.0
COLUMNS = ("figure", Column("value", form=number), Column("unit", words=True), Column("n", form=","),
           Column("meaning", words=True))  # fmt: skip
render = renderer(__file__)


def section(result: Result) -> Markup:
    """The chart of the bound, and the table of all sensor metrics."""
    metrics = result[NOMINAL]
    names = [name for name, metric in METRICS.items() if metric.sensor and name in metrics]
    charts = [chart for size in SIZES if (chart := _chart(metrics, size))]
    return render("sensor.html", charts=charts, table=_table(metrics, names))


def _chart(metrics: dict[str, Estimate], size: Size) -> dict[str, Any]:
    """What the template draws of one size; nothing where there is nothing to see."""
    rows = [
        ("bound (36), independent errors", metrics.get(BOUND), "nominal"),
        ("flown, per zone entry", metrics.get(FLOWN), "c0"),
    ]
    shown = [(label, estimate, class_) for label, estimate, class_ in rows if estimate and estimate.value is not None]
    seen = [value for _, e, _ in shown for value in (height(e), e.low, e.high) if value]
    if not seen:
        return {}
    width = min(size.width, 720)
    x = Decades(min(-2, math.floor(math.log10(min(seen)) - 0.3)), 0, 12.0, width - 22.0)
    return {
        "class": size.class_,
        "width": width,
        "floor": 16.0 + ROW_PX * len(shown),
        "start": x.start_px,
        "end": x.end_px,
        "across": [(x(value), tick) for value, tick in x.ticks(size.ticks)],
        "rows": [_row(label, e, class_, x, 40.0 + ROW_PX * k) for k, (label, e, class_) in enumerate(shown)],
    }


def _row(label: str, e: Estimate, class_: str, x: Decades, y: float) -> dict[str, Any]:
    spot = x(height(e))
    # The text stands where its row has most room.
    left = spot < (x.start_px + x.end_px) / 2.0
    return {
        "class": class_,
        "tip": f"{label}: {full(e, e.unit)}",
        "label": f"{label}: {number(e.value)}",
        "x": spot,
        "y": y,
        "arrow": spot - ARROW_PX if e.value == 0.0 else None,
        "ends": None if e.low is None or e.high is None else (x(e.low), y, x(e.high), y),
        "edge": max(spot - TYPE_PX, x.start_px) if left else min(spot + TYPE_PX, x.end_px),
        "anchor": "start" if left else "end",
    }


def _table(metrics: dict[str, Estimate], names: list[str]) -> Table:
    rows = []
    for name in names:
        metric = METRICS[name]
        unit = "" if metric.unit == "1" else metric.unit
        rows.append([title(name, metric.unit), metrics[name], unit, metrics[name].n, metric.summary])
    return Table(COLUMNS, rows, "sensor")
