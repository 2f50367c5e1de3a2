"""The signs of the map and what they mean."""

from __future__ import annotations

from typing import Any

import numpy as np

from rss_gym.render.canvas import Canvas
from rss_gym.render.scene import Scene
from rss_gym.render.signs import cross, dart, diamond, disc, hoop
from rss_gym.render.style import BLUE, INK, ORANGE, RED, RING, Points, tint


def legend(scene: Scene) -> list[tuple[Any, str]]:
    """Glyph and name of each sign in use."""
    east = np.array([1.0, 0.0])

    def path(canvas: Canvas, at: Points) -> None:
        canvas.line(at + canvas.px(1, 1) * [(-14, -3), (14, -3)], tint(BLUE, 0.8), 2.0)
        canvas.dashes(at + canvas.px(1, 1) * [(-14, 4), (14, 4)], tint(BLUE, 0.6), 1.4)

    def solution(canvas: Canvas, at: Points) -> None:
        canvas.line(at + canvas.px(1, 1) * [(-10, 0), (6, 0)], BLUE, 1.0)
        disc(canvas, at + canvas.px(-10, 0), 3, BLUE)
        cross(canvas, at + canvas.px(7, 0), BLUE)

    def zone(canvas: Canvas, at: Points) -> None:
        canvas.circle(at - canvas.px(8, 0), canvas.px(7, 0)[0], ORANGE, 1.2, dashed=True)
        canvas.circle(at + canvas.px(9, 0), canvas.px(7, 0)[0], RED, 1.8)

    def ranging(canvas: Canvas, at: Points) -> None:
        canvas.line(at + canvas.px(1, 1) * [(-14, 0), (14, 0)], tint(RING, 0.25), 11.0)
        canvas.line(at + canvas.px(1, 1) * [(-14, 0), (14, 0)], RING, 1.4)

    def crafts(canvas: Canvas, at: Points) -> None:
        for shift, colour in ((-13, BLUE), (1, ORANGE), (14, RED)):
            dart(canvas, at + canvas.px(shift, 0), east * (1, -1), colour, size=6.5)

    def contact(canvas: Canvas, at: Points) -> None:
        canvas.circle(at, canvas.px(6, 0)[0], INK, 1.2)

    def plan(canvas: Canvas, at: Points) -> None:
        canvas.line(at + canvas.px(1, 1) * [(-8, 0), (8, 0)], BLUE, 1.0)
        dart(canvas, at - canvas.px(8, 0), east, BLUE, size=6.5)
        hoop(canvas, at + canvas.px(9, 0), BLUE)

    radii = {intruder.zone_radius_m for intruder in scene.intruders} or {scene.zone_radius_m}
    zone_size = f" {min(radii):.0f} m" if len(radii) == 1 else ""
    return [
        (crafts, "agent, intruder, warned of"),
        (path, "flown, predefined path"),
        (plan, "planned position now"),
        (solution, "true, estimated position"),
        (lambda canvas, at: diamond(canvas, at, BLUE), "commanded way point"),
        (ranging, "range estimate ± 1 std"),
        (zone, f"safety zone{zone_size}, warning"),
        (contact, f"collision {scene.collision_radius_m:g} m"),
    ]
