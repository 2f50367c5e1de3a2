"""The map from above, and the close-up round the agent."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rss_gym.render.canvas import Canvas
from rss_gym.render.scene import Aircraft, Scene
from rss_gym.render.signs import burst, cross, dart, diamond, label
from rss_gym.render.style import (
    BLUE,
    INK,
    MUTED,
    PAPER,
    RED,
    RING,
    Colour,
    Points,
    colour_of,
    finite,
    nice_step,
    thinned,
    tint,
)


@dataclass(frozen=True, slots=True)
class View:
    """Map from metres to pixels, with separate scales for the two axes of a chart and equal ones for a map.

    Attributes
    ----------
    centre_m : tuple of float
        What is shown in the middle, (east, north) [m].
    px_per_m : tuple of float
        Scales to the right and up [px/m].
    size_px : tuple of int
        Width and height [px].
    """

    centre_m: tuple[float, float]
    px_per_m: tuple[float, float]
    size_px: tuple[int, int]

    def to_px(self, points_m: ArrayLike) -> Points:
        """Pixels (x right, y down) of points (..., 2 or more) [m]; only the first two coordinates count."""
        points = np.asarray(points_m, dtype=np.float64)[..., :2]
        middle = np.array(self.size_px) / 2.0
        return middle + (points - np.array(self.centre_m)) * np.array([self.px_per_m[0], -self.px_per_m[1]])


def draw_map(canvas: Canvas, view: View, scene: Scene, paths: bool = True) -> None:
    """Everything seen from above; `paths=False` is the close-up, without predefined paths and north arrow."""
    own = view.to_px(scene.own.position_m)
    scale = view.px_per_m[0]
    spots = [(intruder, view.to_px(intruder.position_m)) for intruder in scene.intruders]
    seen = [(intruder, spot) for intruder, spot in spots if np.isfinite(spot).all()]

    cell = nice_step(max(view.size_px) / scale / 8)
    _draw_grid(canvas, view, cell)
    share = 1 / max(1.0, math.sqrt(len(seen)))  # overlapping fills must not add up to a solid ground
    for intruder, spot in seen:
        opacity = 0.10 if intruder.warning else 0.06
        canvas.fill_ring(spot, 0.0, intruder.zone_radius_m * scale, colour_of(intruder), opacity * share)
    for intruder, _ in seen:
        low, high = intruder.range_m - intruder.range_std_m, intruder.range_m + intruder.range_std_m
        if math.isfinite(intruder.range_m) and not math.isnan(low):
            canvas.fill_ring(own, low * scale, high * scale, RING, 0.22 * share)

    for intruder, spot in seen:
        radius = intruder.zone_radius_m * scale
        canvas.circle(spot, radius, colour_of(intruder), 1.8 if intruder.warning else 1.2, dashed=not intruder.warning)
    for intruder, _ in seen:
        if math.isfinite(intruder.range_m):
            canvas.circle(own, intruder.range_m * scale, RING, 1.4)

    for craft, colour in [(intruder, colour_of(intruder)) for intruder, _ in seen] + [(scene.own, BLUE)]:
        if paths:
            canvas.dashes(view.to_px(finite(craft.predefined_m)), tint(colour, 0.6), 1.4)
        flown = thinned(view.to_px(finite(craft.flown_m)), view.to_px(craft.position_m))
        canvas.line(flown, tint(colour, 0.8), 2.0)

    for intruder, spot in seen:
        if not paths and not canvas.holds(spot):
            continue  # the map shows it
        canvas.circle(spot, scene.collision_radius_m * scale, INK, 1.2)
        _draw_craft(canvas, view, intruder, colour_of(intruder))
        if len(scene.intruders) > 1:
            label(canvas, spot, str(next(n for n, other in enumerate(scene.intruders, 1) if other is intruder)))
    if np.isfinite(way_point := view.to_px(scene.way_point_m)).all():
        diamond(canvas, way_point, BLUE)
    _draw_craft(canvas, view, scene.own, BLUE)
    if scene.outcome == "collision":
        burst(canvas, own, RED)
    _draw_scale(canvas, view, cell, north=paths)
    if not paths:
        canvas.text(canvas.px(7, 6), "close-up", MUTED, "lt", halo=PAPER, small=True)


def _draw_grid(canvas: Canvas, view: View, cell: float) -> None:
    """Lines every `cell` metres, at multiples of it."""
    for axis in (0, 1):
        half = view.size_px[axis] / view.px_per_m[axis] / 2
        first, last = view.centre_m[axis] - half, view.centre_m[axis] + half
        for index in range(math.ceil(first / cell), math.floor(last / cell) + 1):
            canvas.rule(view.to_px([index * cell, index * cell])[axis], axis)


def _draw_scale(canvas: Canvas, view: View, cell: float, north: bool) -> None:
    """Scale bar of one grid cell, lower left; north arrow, upper left."""
    left, base = canvas.px(14, 0)[0], canvas.size_px[1] - canvas.px(0, 14)[1]
    length, tick = cell * view.px_per_m[0], canvas.px(0, 4)[1]
    bar = [(left, base - tick), (left, base), (left + length, base), (left + length, base - tick)]
    canvas.line(np.array(bar), INK, 1.6)
    canvas.text(np.array([left + length / 2, base - 1.5 * tick]), f"{cell:g} m", INK, "mb", halo=PAPER)
    if north:
        tip = canvas.px(22, 14)
        canvas.polygon(tip + canvas.px(1, 1) * [(0, 0), (6, 15), (0, 11), (-6, 15)], MUTED)
        canvas.text(tip + canvas.px(0, 26), "N", MUTED, "mm", halo=PAPER)


def _draw_craft(canvas: Canvas, view: View, craft: Aircraft, colour: Colour) -> None:
    """Filled dart at the true position, cross at the estimate, a thin line between; hollow at the edge when outside."""
    spot = view.to_px(craft.position_m)
    if not np.isfinite(spot).all():
        return
    if craft.estimate_m is not None and np.isfinite(guess := view.to_px(craft.estimate_m)).all():
        if math.dist(spot, guess) > canvas.px(9, 0)[0]:  # otherwise the dart covers it
            canvas.line(np.array([spot, guess]), colour, 1.0)
            cross(canvas, guess, colour)
    shown = canvas.inside(spot)
    velocity = np.asarray(craft.velocity_mps, dtype=np.float64)[:2] * (1, -1)
    dart(canvas, shown, velocity, colour, hollow=bool(np.abs(shown - spot).max() > 0))
