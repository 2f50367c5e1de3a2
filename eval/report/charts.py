"""The chart of safety against deviation: collisions per encounter over the mean distance from the predefined path."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from markupsafe import Markup

from rss_gym.eval.evaluate import Result
from rss_gym.eval.metrics import Estimate
from rss_gym.eval.report import labels, series
from rss_gym.eval.report.curves import Curve
from rss_gym.eval.report.labels import Box, Label, Placed
from rss_gym.eval.report.scales import Decades, Linear
from rss_gym.eval.report.series import Series
from rss_gym.eval.report.tables import ordered
from rss_gym.pages.markup import renderer
from rss_gym.pages.numbers import full

render = renderer(__file__)
ACROSS, UP = "path_deviation_mean_m", "collision_rate"
UNITS = {"_mps": "m/s", "_m": "m", "_s": "s"}
RADIUS_PX, ARROW_PX = 4.5, 20.0


@dataclass(frozen=True)
class Size:
    """One size of the chart; the style sheet shows the one that fits the window."""

    class_: str
    width: int
    height: int
    type_px: float
    label_length: int
    ticks: int
    left: float = 46.0
    top: float = 34.0
    right: float = 14.0
    bottom: float = 44.0


SIZES = (
    Size("wide", 1060, 520, 12.5, 44, 10),
    Size("medium", 620, 440, 12.5, 34, 7),
    Size("narrow", 340, 400, 11.5, 24, 5),
)


@dataclass(frozen=True)
class Point:
    """One policy on the chart."""

    name: str
    across: Estimate
    up: Estimate
    class_: str
    text: str  # of its label
    front: bool = False


def safety(result: Result, caption: bool = True) -> Markup:
    """The chart in every size, each with a line on what it leaves out; with `caption` how to read it."""
    found = series.of(result)
    points, missing = _points(result, found)
    charts = [_figure(points, missing, found, size) for size in SIZES] if points else []
    return render("safety.html", charts=charts, caption=caption)


def _points(result: Result, found: Series) -> tuple[dict[int, Point], list[str]]:
    """Points by the index of their policy, and the names of policies without one."""
    texts = {scored.entry.name: scored.entry.name for scored in result.policies}
    for curve in reversed(found.curves):
        unit = next((f" {unit}" for suffix, unit in UNITS.items() if curve.option.endswith(suffix)), "")
        texts.update({result.policies[index].entry.name: f"{value:g}{unit}" for index, value in curve.members})
    front = {place.name for _, place in ordered(result) if place.front}
    points, missing = {}, []
    for index, scored in enumerate(result.policies):
        name, across, up = scored.entry.name, scored.metrics.get(ACROSS), scored.metrics.get(UP)
        if across is None or across.value is None or up is None or up.value is None:
            missing.append(name)
        else:
            points[index] = Point(name, across, up, found.classes[index], texts[name], name in front)
    return points, missing


def height(up: Estimate) -> float:
    """What is drawn of a rate: itself, or the upper end of its interval where there was no event."""
    assert up.value is not None
    return up.value if up.value > 0.0 or up.high is None else up.high


def axes(points: list[Point], size: Size) -> tuple[Linear, Decades]:
    """Scales that hold every point; long lower whiskers may leave at the bottom."""
    far = max(value for p in points for value in (p.across.value, p.across.high) if value is not None)
    top = max(value for p in points for value in (height(p.up), p.up.high) if value is not None)
    least = min((height(p.up) for p in points if height(p.up) > 0.0), default=0.1)
    high = min(0, math.ceil(math.log10(top) - 1e-9)) if top > 0.0 else 0
    low = min(math.floor(math.log10(least) - 0.3), high - 2)
    across = Linear(0.0, 1.05 * far if far > 0.0 else 1.0, size.left + 6.0, size.width - size.right)
    return across, Decades(low, high, size.height - size.bottom, size.top)


def _figure(points: dict[int, Point], missing: list[str], found: Series, size: Size) -> dict[str, Any]:
    """What the template draws of one size."""
    x, y = axes(list(points.values()), size)
    at = {index: (x(_value(p.across)), y(height(p.up))) for index, p in points.items()}
    curves = [(curve, [at[index] for index, _ in curve.members if index in at]) for curve in found.curves]
    curves = [(curve, path) for curve, path in curves if path]
    classes = [found.classes[curve.members[0][0]] for curve, _ in curves]
    wanted = [Label(_curve_text(curve, size), (*path, *_middles(path)), size.type_px + 0.5) for curve, path in curves]
    wanted += [
        Label(labels.shortened(p.text, size.label_length), (at[index],), size.type_px) for index, p in points.items()
    ]
    marks, lines = _obstacles(points, at, [path for _, path in curves], x, y)
    bounds = (size.left, size.top - 16.0, float(size.width), size.height - size.bottom)
    placed = labels.place(wanted, marks, lines, bounds)
    of_labels = [f"name {class_}" for class_ in classes] + [p.class_ for p in points.values()]
    bare = [p.name for p, spot in zip(points.values(), placed[len(curves) :], strict=True) if spot is None]
    return {
        "class": size.class_,
        "radius": RADIUS_PX,
        **{name: getattr(size, name) for name in ("width", "height", "left", "right", "bottom")},
        "across": [(x(value), shown) for value, shown in x.ticks(size.ticks)],
        "up": [(y(value), shown) for value, shown in y.ticks()],
        "curves": [{"class": class_, "points": path} for class_, (_, path) in zip(classes, curves, strict=True)],
        "points": [_point(p, at[index], x, y) for index, p in points.items()],
        "labels": [
            _label(label, spot, class_) for label, spot, class_ in zip(wanted, placed, of_labels, strict=True) if spot
        ],
        "notes": {"Points without room for a label": bare, "Not on the chart, without both figures": missing},
    }


def _curve_text(curve: Curve, size: Size) -> str:
    return labels.shortened(curve.label if len(curve.label) <= size.label_length else curve.short, size.label_length)


def _value(estimate: Estimate) -> float:
    assert estimate.value is not None
    return estimate.value


def _middles(path: list[tuple[float, float]]) -> list[tuple[float, float]]:
    return [((a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0) for a, b in pairwise(path)]


def _obstacles(
    points: dict[int, Point],
    at: dict[int, tuple[float, float]],
    paths: list[list[tuple[float, float]]],
    x: Linear,
    y: Decades,
) -> tuple[list[Box], list[Box]]:
    """Boxes of the marks, and small ones along curves and whiskers."""
    reach = RADIUS_PX + 2.0
    marks = [(a - reach, b - reach, a + reach, b + reach) for a, b in at.values()]
    lines = [box for path in paths for box in labels.along(path)]
    for index, p in points.items():
        for ends in _whiskers(p, at[index], x, y):
            lines += labels.along(ends)
    return marks, lines


def _whiskers(p: Point, at: tuple[float, float], x: Linear, y: Decades) -> list[list[tuple[float, float]]]:
    """Ends of the intervals as lines; the arrow's shaft where there was no event."""
    out = []
    if p.across.low is not None and p.across.high is not None:
        out.append([(x(p.across.low), at[1]), (x(p.across.high), at[1])])
    if p.up.value == 0.0 and p.up.high is not None:
        out.append([at, (at[0], at[1] + ARROW_PX)])
    elif p.up.low is not None and p.up.high is not None:
        out.append([(at[0], y(p.up.low)), (at[0], y(p.up.high))])
    return out


def _point(p: Point, at: tuple[float, float], x: Linear, y: Decades) -> dict[str, Any]:
    tip = f"{p.name}\ncollision rate {full(p.up, p.up.unit)}\nmean deviation {full(p.across, p.across.unit)}"
    arrow = at[1] + ARROW_PX if p.up.value == 0.0 else None
    whiskers = [(*start, *end) for start, end in _whiskers(p, at, x, y)]
    return {
        "class": p.class_,
        "front": p.front,
        "tip": tip,
        "x": at[0],
        "y": at[1],
        "arrow": arrow,
        "whiskers": whiskers,
    }


def _label(label: Label, spot: Placed, class_: str) -> dict[str, Any]:
    left, top, right, bottom = spot.box
    a, b = spot.spot
    far = spot.distance_px > 12.0
    return {
        "class": class_,
        "text": label.text,
        "size": label.size_px,
        "x": (left + right) / 2.0,
        "y": (top + bottom) / 2.0 + 0.35 * label.size_px,
        "leader": (a, b, min(max(a, left), right), min(max(b, top), bottom)) if far else None,
    }
