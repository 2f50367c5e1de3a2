"""The chart of safety against deviation: collisions per encounter over the mean distance from the predefined path."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from rss_gym.eval.evaluate import Result
from rss_gym.eval.metrics import Estimate
from rss_gym.eval.report import labels, series
from rss_gym.eval.report.curves import Curve
from rss_gym.eval.report.labels import Box, Label, Placed
from rss_gym.eval.report.numbers import full
from rss_gym.eval.report.series import Series
from rss_gym.eval.report.svg import Decades, Linear, element, line, picture, words
from rss_gym.eval.report.tables import ordered
from rss_gym.pages.page import text

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


def safety(result: Result) -> str:
    """The chart in every size, each with a line on what it leaves out."""
    found = series.of(result)
    points, missing = _points(result, found)
    if not points:
        return '<p class="note">No policy has both a collision rate and a mean deviation.</p>'
    return "".join(_figure(points, missing, found, size) for size in SIZES)


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


def _figure(points: dict[int, Point], missing: list[str], found: Series, size: Size) -> str:
    x, y = axes(list(points.values()), size)
    at = {index: (x(_value(p.across)), y(height(p.up))) for index, p in points.items()}
    paths = [[at[index] for index, _ in curve.members if index in at] for curve in found.curves]
    curve_labels = [
        Label(_curve_text(curve, size), (*path, *_middles(path)), size.type_px + 0.5)
        for curve, path in zip(found.curves, paths, strict=True)
        if path
    ]
    point_labels = [
        Label(labels.shortened(p.text, size.label_length), (at[index],), size.type_px) for index, p in points.items()
    ]
    marks, lines = _obstacles(points, at, paths, x, y)
    bounds = (size.left, size.top - 16.0, float(size.width), size.height - size.bottom)
    wanted = [*curve_labels, *point_labels]
    placed = labels.place(wanted, marks, lines, bounds)
    curve_classes = [
        found.classes[curve.members[0][0]] for curve, path in zip(found.curves, paths, strict=True) if path
    ]
    classes = [f"name {class_}" for class_ in curve_classes] + [p.class_ for p in points.values()]
    content = _grid(x, y, size)
    for curve, path in zip(found.curves, paths, strict=True):
        steps = " ".join(f"{a:.1f},{b:.1f}" for a, b in path)
        content += element("polyline", class_=f"curve {found.classes[curve.members[0][0]]}", points=steps)
    content += "".join(_point(p, at[index], x, y) for index, p in points.items())
    content += "".join(
        _label(label, spot, class_) for label, spot, class_ in zip(wanted, placed, classes, strict=True) if spot
    )
    bare = [p.name for p, spot in zip(points.values(), placed[len(curve_labels) :], strict=True) if spot is None]
    notes = _note("Points without room for a label", bare) + _note("Not on the chart, without both figures", missing)
    svg = picture(content, size.width, size.height, "chart", "Collisions per encounter against mean deviation")
    return f'<div class="figure {size.class_}">{svg}{notes}</div>\n'


def _curve_text(curve: Curve, size: Size) -> str:
    return labels.shortened(curve.label if len(curve.label) <= size.label_length else curve.short, size.label_length)


def _note(words_: str, names: list[str]) -> str:
    return f'<p class="note">{words_}: {text(", ".join(names))}.</p>' if names else ""


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


def _grid(x: Linear, y: Decades, size: Size) -> str:
    floor, right = size.height - size.bottom, size.width - size.right
    content = ""
    for value, shown in y.ticks():
        content += line(size.left, y(value), right, y(value), "grid")
        content += words(shown, size.left - 8.0, y(value) + 4.0, "tick", "end")
    for value, shown in x.ticks(size.ticks):
        content += line(x(value), floor, x(value), floor + 5.0, "axis")
        content += words(shown, x(value), floor + 18.0, "tick", "middle")
    content += line(size.left, floor, right, floor, "axis")
    content += words("collisions per encounter (best is lower left)", 2.0, 14.0, "title")
    return content + words("mean deviation from the predefined path, m", right, size.height - 6.0, "title", "end")


def _point(p: Point, at: tuple[float, float], x: Linear, y: Decades) -> str:
    tip = element("title", text(f"{p.name}\ncollision rate {full(p.up)}\nmean deviation {full(p.across)}"))
    lines = "".join(line(*start, *end, "whisker") for start, end in _whiskers(p, at, x, y))
    a, b = at
    if p.up.value == 0.0:
        head = f"M{a - 4:.1f} {b + ARROW_PX - 6:.1f}L{a:.1f} {b + ARROW_PX:.1f}L{a + 4:.1f} {b + ARROW_PX - 6:.1f}"
        mark = line(a - 6.0, b, a + 6.0, b, "bound") + element("path", class_="whisker", d=head)
    elif p.class_ == "nominal":
        side = 2.0 * RADIUS_PX
        mark = element("rect", class_="mark", x=a - RADIUS_PX, y=b - RADIUS_PX, width=side, height=side)
    else:
        mark = element("circle", class_="mark", cx=a, cy=b, r=RADIUS_PX)
    if p.front:
        mark += element("circle", class_="front", cx=a, cy=b, r=RADIUS_PX + 3.0)
    hover = element("circle", class_="hover", cx=a, cy=b, r=12.0)
    return element("g", tip + lines + mark + hover, class_=f"point {p.class_}")


def _label(label: Label, spot: Placed, class_: str) -> str:
    left, top, right, bottom = spot.box
    leader = ""
    if spot.distance_px > 12.0:
        a, b = spot.spot
        leader = line(a, b, min(max(a, left), right), min(max(b, top), bottom), f"leader {class_}")
    base = (top + bottom) / 2.0 + 0.35 * label.size_px
    return leader + element(
        "text", text(label.text), x=(left + right) / 2.0, y=base, class_=f"label {class_}", text_anchor="middle",
        font_size=label.size_px,
    )  # fmt: skip


CAPTION = (
    '<p class="note">Best is lower left: down is safer, left is nearer to the predefined path; the scale of collisions '
    "is logarithmic. A ring marks the front: no other policy of its level of information has both fewer collisions and "
    "less deviation. Red: a policy with faults, which is not ranked. "
    "Lines through the points are 95 % intervals. A bar with an arrow: no collision was seen, and the rate lies below "
    "the bar, the upper end of its interval.</p>\n"
)
