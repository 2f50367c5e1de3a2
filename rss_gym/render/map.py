"""The map from above, and the close-up round the agent."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rss_gym.render.canvas import WHOLE, Canvas
from rss_gym.render.scene import Aircraft, Intruder, Scene
from rss_gym.render.signs import burst, cross, dart, diamond, disc, hoop, label
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

HOVER_MPS = 0.5  # below this speed, gusts turn the velocity in any direction
SECTOR_RAD = math.radians(20)  # half the angle of a range estimate drawn towards one of several intruders


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


def draw_map(canvas: Canvas, view: View, scene: Scene, close_up: bool = False) -> None:
    """Everything seen from above. The close-up has smaller aircraft, and only those inside it."""
    own, scale = view.to_px(scene.own.position_m), view.px_per_m[0]
    numbered = [(n, intruder, view.to_px(intruder.position_m)) for n, intruder in enumerate(scene.intruders, start=1)]
    seen = [(n, intruder, spot) for n, intruder, spot in numbered if np.isfinite(spot).all()]

    cell = nice_step(max(view.size_px) / scale / 8)
    _draw_grid(canvas, view, cell)
    _draw_rings(canvas, own, scale, [(intruder, spot) for _, intruder, spot in seen])

    for aircraft, colour in [(intruder, colour_of(intruder)) for _, intruder, _ in seen] + [(scene.own, BLUE)]:
        canvas.dashes(view.to_px(finite(aircraft.predefined_m)), tint(colour, 0.6), 1.4)
        flown = thinned(view.to_px(finite(aircraft.flown_m)), view.to_px(aircraft.position_m))
        canvas.line(flown, tint(colour, 0.8), 2.0)

    size = 7.5 if close_up else 10.0
    for number, intruder, spot in seen:
        if close_up and not canvas.holds(spot):
            continue  # the map shows it
        _draw_aircraft(canvas, view, intruder, colour_of(intruder), size)
        if scene.collision_radius_m * scale > canvas.px(1.2 * size, 0)[0]:  # otherwise the dart covers it
            canvas.circle(spot, scene.collision_radius_m * scale, INK, 1.2)
        if len(scene.intruders) > 1:
            label(canvas, spot, str(number))
    for place_m, sign in ((scene.planned_m, hoop), (scene.way_point_m, diamond)):
        place = view.to_px(place_m)
        if np.isfinite([own, place]).all() and math.dist(own, place) > canvas.px(size, 0)[0]:
            if sign is hoop:
                canvas.line(np.array([own, place]), BLUE, 1.0)
            sign(canvas, place, BLUE)
    _draw_aircraft(canvas, view, scene.own, BLUE, size)
    if scene.outcome == "collision":
        burst(canvas, own, RED)
    _draw_scale(canvas, view, cell, north=not close_up)
    if close_up:
        canvas.text(canvas.px(7, 6), "close-up", MUTED, "lt", halo=PAPER, small=True)


def _draw_rings(canvas: Canvas, own: Points, scale: float, seen: list[tuple[Intruder, Points]]) -> None:
    """Zones round the intruders, range estimates round the agent: with several intruders, bold only towards each."""
    share = 1 / max(1.0, math.sqrt(len(seen)))  # overlapping fills must not add up to a solid ground
    for intruder, spot in seen:
        opacity = 0.10 if intruder.warning else 0.06
        canvas.fill_ring(spot, 0.0, intruder.zone_radius_m * scale, colour_of(intruder), opacity * share)
    bands = []
    for intruder, spot in seen:
        if math.isfinite(intruder.range_m) and np.isfinite(own).all():
            towards = math.atan2(*(spot - own)[::-1])
            sector = (towards - SECTOR_RAD, towards + SECTOR_RAD) if len(seen) > 1 else WHOLE
            bands.append((intruder.range_m * scale, intruder.range_std_m * scale, sector))
    for radius, std, sector in bands:
        if not math.isnan(std):
            canvas.fill_ring(own, radius - std, radius + std, RING, 0.22, sector)
    for intruder, spot in seen:
        width = 1.8 if intruder.warning and len(seen) == 1 else 1.2
        canvas.circle(spot, intruder.zone_radius_m * scale, colour_of(intruder), width, dashed=not intruder.warning)
    for radius, _, sector in bands:
        if sector != WHOLE:
            canvas.circle(own, radius, tint(RING, 0.4), 1.0)
    for radius, _, sector in bands:
        canvas.circle(own, radius, RING, 1.4 if sector == WHOLE else 2.0, sector=sector)


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


def _draw_aircraft(canvas: Canvas, view: View, aircraft: Aircraft, colour: Colour, size: float) -> None:
    """Dart at the true position, cross at the estimate, a thin line between; a hollow dart at the edge when outside.

    A disc stands for an aircraft that hovers.
    """
    spot = view.to_px(aircraft.position_m)
    if not np.isfinite(spot).all():
        return
    if aircraft.estimate_m is not None and np.isfinite(guess := view.to_px(aircraft.estimate_m)).all():
        if math.dist(spot, guess) > canvas.px(size + 5, 0)[0]:  # otherwise they cover each other
            canvas.line(np.array([spot, guess]), colour, 1.0)
            cross(canvas, guess, colour)
    shown = canvas.inside(spot)
    velocity = np.asarray(aircraft.velocity_mps, dtype=np.float64)[:2] * (1, -1)
    outside = bool(np.abs(shown - spot).max() > 0)
    if math.hypot(*velocity) > HOVER_MPS:
        dart(canvas, shown, velocity, colour, hollow=outside, size=size)
    else:
        disc(canvas, shown, 0.7 * size, colour, hollow=outside)
