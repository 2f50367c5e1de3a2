"""What the radio does, whoever flies: range errors, missed detections beside the paper's bound (36), false alerts."""

from __future__ import annotations

import math

from rss_gym.eval.evaluate import NOMINAL, Result
from rss_gym.eval.metrics import METRICS, Estimate
from rss_gym.eval.report.charts import ARROW_PX, SIZES, Size, height
from rss_gym.eval.report.numbers import full, number
from rss_gym.eval.report.svg import Decades, element, line, picture, words
from rss_gym.eval.report.tables import cell, scrolled, title
from rss_gym.pages.page import text

BOUND, FLOWN = "missed_detection_bound", "missed_detection_encounter_rate"
ROW_PX, TYPE_PX = 46.0, 7.0


def section(result: Result) -> str:
    """The chart of the bound, and the table of all sensor metrics."""
    metrics = result[NOMINAL]
    names = [name for name, metric in METRICS.items() if metric.sensor and name in metrics]
    return (
        '<p class="text">Measured on the flights of <code>none</code>, so the same for every policy. The bound (36) '
        "of the paper, (1 − P(δ))<sup>n</sup> with n = n<sub>d</sub> of (37), assumes that successive range errors "
        "are independent and that a share P(δ) of them is within δ. Beside it is what was flown: the share of zone "
        "entries that n<sub>d</sub> successive estimates all missed.</p>\n"
        + "".join(_chart(metrics, size) for size in SIZES)
        + _table(metrics, names)
    )


def _chart(metrics: dict[str, Estimate], size: Size) -> str:
    rows = [
        ("bound (36), independent errors", metrics.get(BOUND), "nominal"),
        ("flown, per zone entry", metrics.get(FLOWN), "c0"),
    ]
    shown = [(label, estimate, class_) for label, estimate, class_ in rows if estimate and estimate.value is not None]
    seen = [value for _, e, _ in shown for value in (height(e), e.low, e.high) if value]
    if not shown or not seen:
        return ""
    width, right, floor = min(size.width, 720), 22.0, 16.0 + ROW_PX * len(shown)
    x = Decades(min(-2, math.floor(math.log10(min(seen)) - 0.3)), 0, 12.0, width - right)
    content = ""
    for value, tick in x.ticks(size.ticks):
        content += line(x(value), 8.0, x(value), floor, "grid") + words(tick, x(value), floor + 17.0, "tick", "middle")
    content += line(x.start_px, floor, x.end_px, floor, "axis")
    for k, (label, e, class_) in enumerate(shown):
        base, at = 24.0 + ROW_PX * k, 40.0 + ROW_PX * k
        tip, spot, lines = element("title", text(f"{label}: {full(e)}")), x(height(e)), ""
        if e.value == 0.0:
            end = spot - ARROW_PX
            head = element(
                "path", class_="whisker", d=f"M{end + 6:.1f} {at - 4:.1f}L{end:.1f} {at:.1f}L{end + 6:.1f} {at + 4:.1f}"
            )
            lines = line(spot, at, end, at, "whisker") + head + line(spot, at - 6.0, spot, at + 6.0, "bound")
        else:
            if e.low is not None and e.high is not None:
                lines = line(x(e.low), at, x(e.high), at, "whisker")
            lines += element("circle", class_="mark", cx=spot, cy=at, r=4.5)
        # The text stands where its row has most room.
        left = spot < (x.start_px + x.end_px) / 2.0
        edge = max(spot - TYPE_PX, x.start_px) if left else min(spot + TYPE_PX, x.end_px)
        content += element("g", tip + lines, class_=f"point {class_}")
        content += words(f"{label}: {number(e.value)}", edge, base, "label plain", "start" if left else "end")
    svg = picture(content, width, int(floor + 28), "chart", "Bound (36) beside the flown miss probability")
    return f'<div class="figure {size.class_}">{svg}</div>\n'


def _table(metrics: dict[str, Estimate], names: list[str]) -> str:
    rows = ""
    for name in names:
        metric = METRICS[name]
        unit = "" if metric.unit == "1" else text(metric.unit)
        rows += (
            f'<tr><th scope="row">{text(title(name, metric.unit))}</th>{cell(metrics[name])}'
            f'<td class="words">{unit}</td><td>{metrics[name].n:,}</td>'
            f'<td class="words">{text(metric.summary)}</td></tr>\n'
        )
    heads = ("figure", "value", "unit", "n", "meaning")
    classes = ("", "", ' class="words"', "", ' class="words"')
    headings = "".join(f'<th scope="col"{c}>{h}</th>' for h, c in zip(heads, classes, strict=True))
    return scrolled(f'<table class="sensor"><thead><tr>{headings}</tr></thead>\n<tbody>\n{rows}</tbody></table>')
