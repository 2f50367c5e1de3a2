"""The chart of safety against deviation: collisions per encounter over the mean distance from the predefined path."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from markupsafe import Markup

from rss_gym.eval.evaluate import Result
from rss_gym.eval.metrics import Estimate
from rss_gym.eval.report import series
from rss_gym.eval.report.curves import Curve
from rss_gym.eval.report.series import Series
from rss_gym.eval.report.tables import ordered
from rss_gym.pages import names
from rss_gym.pages.colours import NOMINAL
from rss_gym.pages.figure import CLASSES, INK, MUTED, PAPER, Drawing, figure
from rss_gym.pages.markup import renderer
from rss_gym.pages.names import Name, shortened
from rss_gym.pages.numbers import full

render = renderer(__file__)
ACROSS, UP = "path_deviation_mean_m", "collision_rate"
UNITS = {"_mps": "m/s", "_m": "m", "_s": "s"}
FALL = 0.3  # of a value, along the arrow of one that is an upper bound


@dataclass(frozen=True)
class Size:
    """One size of a chart; the style sheet shows the one that fits the window, so that letters never shrink."""

    class_: str
    width_in: float
    height_in: float
    name_length: int  # of a policy, longest shown


SIZES = (Size("wide", 11.0, 5.4, 44), Size("medium", 6.4, 4.6, 34), Size("narrow", 3.55, 4.2, 24))


@dataclass(frozen=True)
class Point:
    """One policy on the chart."""

    name: str
    across: Estimate
    up: Estimate
    class_: str
    text: str  # of its label
    front: bool = False

    @property
    def x(self) -> float:
        """Where it is drawn."""
        assert self.across.value is not None
        return self.across.value

    @property
    def y(self) -> float:
        """Where it is drawn."""
        return height(self.up)

    @property
    def tip(self) -> str:
        """Its numbers."""
        up, across = full(self.up, self.up.unit), full(self.across, self.across.unit)
        return f"{self.name}\ncollision rate {up}\nmean deviation {across}"


def safety(result: Result, caption: bool = True) -> Markup:
    """The chart in every size, each with a line on what it leaves out; with `caption` how to read it."""
    found = series.of(result)
    points, missing = _points(result, found)
    charts = [_chart(points, found, size) for size in SIZES] if points else []
    return render("safety.html", charts=charts, missing=missing, caption=caption)


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


def ends(estimate: Estimate, at: float) -> list[list[float]]:
    """The interval as distances below and above what is drawn; none where an end is missing."""
    low, high = estimate.low, estimate.high
    return [[0.0], [0.0]] if low is None or high is None else [[max(at - low, 0.0)], [max(high - at, 0.0)]]


def limits(points: Sequence[Point]) -> dict[str, tuple[float, float]]:
    """Whole decades and metres that hold every point; long lower whiskers may leave at the bottom."""
    far = max(value for p in points for value in (p.x, p.across.high) if value is not None)
    top = max(value for p in points for value in (p.y, p.up.high) if value is not None)
    least = min((p.y for p in points if p.y > 0.0), default=0.1)
    high = min(0, math.ceil(math.log10(top) - 1e-9)) if top > 0.0 else 0
    low = min(math.floor(math.log10(least) - 0.3), high - 2)
    return {"xlim": (-0.01 * far, 1.05 * far) if far > 0.0 else (0.0, 1.0), "ylim": (10.0**low, 10.0**high)}


def _chart(points: dict[int, Point], found: Series, size: Size) -> dict[str, Any]:
    """One size, and the names without room on it."""
    label = "Collisions per encounter against mean deviation"
    with figure(label, width_in=size.width_in, height_in=size.height_in, class_=size.class_) as drawing:
        axes = drawing.axes
        axes.set(yscale="log", **limits([*points.values()]))
        axes.minorticks_off()
        axes.yaxis.set_major_formatter("{x:g}")
        axes.grid(axis="x", visible=False)
        axes.set_title("collisions per encounter (best is lower left)", loc="left", color=MUTED)
        axes.set_xlabel("mean deviation from the predefined path, m", loc="right")
        between: list[tuple[float, float]] = []
        for curve in found.curves:
            path = [(points[index].x, points[index].y) for index, _ in curve.members if index in points]
            axes.plot([x for x, _ in path], [y for _, y in path], color=CLASSES[_class(curve, found)], alpha=0.55)
            between += [spot for one, other in pairwise(path) for spot in _along(one, other)]
        for number, p in points.items():
            _mark(drawing, number, p)
        written = [*_curve_names(points, found, size)]
        written += [Name(shortened(p.text, size.name_length), p.x, p.y, CLASSES[p.class_]) for p in points.values()]
        hidden = names.place(axes, written, [*((p.x, p.y) for p in points.values()), *between])
    return {"class": size.class_, "figure": drawing.html, "bare": [written[k].text for k in hidden]}


def _mark(drawing: Drawing, number: int, p: Point) -> None:
    """A point with its intervals; a bar with an arrow where no event was seen."""
    axes, colour = drawing.axes, CLASSES[p.class_]
    bound = p.up.value == 0.0
    style = {"color": colour, "elinewidth": 1.0, "markeredgecolor": colour if bound else PAPER}
    style |= {"markeredgewidth": 2.5 if bound else 0.9}
    drawn = axes.errorbar(
        [p.x], [p.y], [[FALL * p.y], [0.0]] if bound else ends(p.up, p.y), ends(p.across, p.x), uplims=bound,
        fmt="_" if bound else "s" if p.class_ == NOMINAL else "o", markersize=9.0 if bound else 7.0, **style,
    )  # fmt: skip
    drawn[0].set_gid(f"{'bound' if bound else 'mark'}-{number}")
    if p.front:
        axes.plot(p.x, p.y, "o", markersize=11.5, markerfacecolor="none", markeredgecolor=INK, gid=f"front-{number}")
    drawing.tip(axes, p.x, p.y, p.tip)


def _class(curve: Curve, found: Series) -> str:
    return found.classes[curve.members[0][0]]


def _along(one: tuple[float, float], other: tuple[float, float]) -> list[tuple[float, float]]:
    """Spots between two points of a curve, for names to keep off."""
    shares = [k / 6.0 for k in range(1, 6)]
    return [(one[0] + s * (other[0] - one[0]), one[1] ** (1.0 - s) * other[1] ** s) for s in shares]


def _curve_names(points: dict[int, Point], found: Series, size: Size) -> Iterator[Name]:
    """The name of each curve, beside its middle member."""
    for curve in found.curves:
        members = [points[index] for index, _ in curve.members if index in points]
        if members:
            middle, text = members[len(members) // 2], curve.label
            text = shortened(text if len(text) <= size.name_length else curve.short, size.name_length)
            yield Name(text, middle.x, middle.y, CLASSES[_class(curve, found)], "bold")
