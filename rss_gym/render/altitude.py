"""The strip of altitude against time, for flights off the plane."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from rss_gym.render.canvas import Canvas
from rss_gym.render.scene import Scene
from rss_gym.render.signs import cross, diamond, disc
from rss_gym.render.style import BLUE, FRAME, GRID, MUTED, PAPER, Points, colour_of, finite, nice_step, thinned, tint


def draw_altitudes(canvas: Canvas, scene: Scene) -> None:
    """Altitude against time: flown (solid), true now (dot), estimate now (cross), commanded (diamond)."""
    width, height = canvas.size_px
    heights = np.concatenate([finite(aircraft.predefined_m)[:, 2] for aircraft in (scene.own, *scene.intruders)])
    low, high = (heights.min() - 30.0, heights.max() + 30.0) if len(heights) else (-30.0, 30.0)
    margin, foot = 3.4 * canvas.text_px, 1.5 * canvas.text_px
    duration = max(scene.duration_s, scene.time_s, 1e-9)
    across, up = (width - margin - 4 * canvas.gap) / duration, (height - foot - 0.4 * canvas.text_px) / (high - low)

    def to_px(time_s: ArrayLike, altitude_m: ArrayLike) -> Points:
        top = height - foot - (np.asarray(altitude_m, dtype=np.float64) - low) * up
        return np.stack(np.broadcast_arrays(margin + np.asarray(time_s, dtype=np.float64) * across, top), axis=-1)

    step = nice_step((high - low) / 4)
    for index in range(math.ceil(low / step), math.floor(high / step) + 1):
        canvas.line(to_px([0, duration], index * step), GRID, 1.0)
        canvas.text(to_px(0, index * step) - canvas.px(5, 0), f"{index * step:g}", MUTED, "rm", small=True)
    step = nice_step(duration / 6)
    for index in range(math.floor(duration / step) + 1):
        canvas.line(to_px(index * step, [low, high]), GRID, 1.0)
        name = f"{index * step:g} s" if index else "0"
        canvas.text(to_px(index * step, low) + canvas.px(0, 3), name, MUTED, "mt", small=True)
    canvas.line(to_px(scene.time_s, [low, high]), FRAME, 1.4)
    canvas.text(to_px(0, high) + canvas.px(6, 3), "altitude [m]", MUTED, "lt", halo=PAPER, small=True)

    for aircraft, colour in [(intruder, colour_of(intruder)) for intruder in scene.intruders] + [(scene.own, BLUE)]:
        if aircraft is scene.own and np.isfinite(scene.planned_m[2]):
            canvas.dashes(to_px([0, duration], scene.planned_m[2]), tint(BLUE, 0.6), 1.4)  # its legs are level
        flown = finite(aircraft.flown_m)[:, 2]
        now = to_px(scene.time_s, aircraft.position_m[2])
        curve = to_px(np.linspace(0.0, scene.time_s, len(flown)), flown)
        canvas.line(thinned(curve, now), tint(colour, 0.8), 2.0)
        if aircraft.estimate_m is not None and np.isfinite(guess := to_px(scene.time_s, aircraft.estimate_m[2])).all():
            aside = guess + canvas.px(14, 0)
            if np.isfinite(now).all():
                canvas.line(np.array([now, aside]), colour, 1.0)
            cross(canvas, aside, colour)
        if aircraft is scene.own and np.isfinite(way_point := to_px(scene.time_s, scene.way_point_m[2])).all():
            diamond(canvas, way_point + canvas.px(28, 0), BLUE)
        if np.isfinite(now).all():
            disc(canvas, now, 4.5, colour)
