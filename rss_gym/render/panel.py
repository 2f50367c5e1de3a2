"""The panel of words: clock, states, ranges."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from rss_gym.render.canvas import Canvas
from rss_gym.render.legend import legend
from rss_gym.render.scene import Intruder, Scene
from rss_gym.render.signs import badge, pair
from rss_gym.render.style import BLUE, FRAME, GREEN, INK, MUTED, RED, colour_of, state


def draw_panel(canvas: Canvas, scene: Scene) -> tuple[float, float]:
    """Words and legend; returns the rows [px] left free between them."""
    width, line, gap = canvas.size_px[0], 1.45 * canvas.text_px, canvas.gap
    left, right, y = float(gap), float(width - gap), float(gap)

    canvas.text(np.array([left, y]), f"{scene.time_s:.1f} s", INK, "lt", large=True)
    canvas.text(np.array([right, y]), f"of {scene.duration_s:.1f} s", MUTED, "rt")
    canvas.text(np.array([right, y + line]), f"{scene.playback_speed:g}x real time", MUTED, "rt", small=True)
    y += 2.2 * line
    share = min(max(scene.time_s / scene.duration_s, 0.0), 1.0) if scene.duration_s > 0 else 0.0
    canvas.bar((left, y, right, y + 4), FRAME)
    canvas.bar((left, y, left + share * (right - left), y + 4), BLUE)
    y += 0.7 * line

    warned = any(intruder.warning for intruder in scene.intruders)
    middle = (left + right) / 2
    badge(canvas, (left, y, middle - 3, y + 1.5 * line), *state(warned))
    name = scene.outcome or "in flight"
    fill = {"collision": RED, "complete": GREEN}.get(scene.outcome)
    badge(canvas, (middle + 3, y, right, y + 1.5 * line), name, fill)
    y += 2.0 * line

    close = scene.min_separation_m < scene.collision_radius_m
    pair(canvas, y, "min separation", _metres(scene.min_separation_m), RED if close else INK)
    y += line
    pair(canvas, y, "deviation", _metres(_distance(scene.own.position_m, scene.planned_m)), INK)
    y += line

    entries = legend(scene)
    foot = canvas.size_px[1] - gap - len(entries) * line
    if foot < y + 3.2 * line:  # no room for both
        entries, foot = [], canvas.size_px[1] - gap
    y = _draw_intruders(canvas, scene, y, foot)

    for index, (glyph, name) in enumerate(entries):
        row = foot + (index + 0.5) * line
        glyph(canvas, np.array([left + 1.1 * canvas.text_px, row]))
        canvas.text(np.array([left + 2.9 * canvas.text_px, row]), name, MUTED, "lm", small=True)
    return y + 0.3 * line, foot - 0.5 * line


def _draw_intruders(canvas: Canvas, scene: Scene, y: float, foot: float) -> float:
    """Separation, estimated range and state of each intruder from row `y` [px] on; returns the row below."""
    line, left, right = 1.45 * canvas.text_px, canvas.gap, canvas.size_px[0] - canvas.gap
    if len(scene.intruders) == 1:
        pair(canvas, y, "true separation", _metres(_distance(scene.own.position_m, scene.intruders[0].position_m)), INK)
        pair(canvas, y + line, "range estimate", _estimate(scene.intruders[0]), INK)
        return y + 2 * line
    if scene.intruders:
        canvas.text(np.array([left, y + 0.5 * canvas.text_px]), "intruder", MUTED, "lm", small=True)
        canvas.text(np.array([right, y + 0.5 * canvas.text_px]), "true / estimate", MUTED, "rm", small=True)
        y += 0.9 * line
    rows = max(1, int((foot - 0.6 * line - y) / line))
    hidden = max(0, len(scene.intruders) - rows)
    for number, intruder in enumerate(scene.intruders[: rows - (hidden > 0)], start=1):
        words = f"{_metres(_distance(scene.own.position_m, intruder.position_m), unit=False)} / {_estimate(intruder)}"
        box = (left, y + 1, left + 1.6 * canvas.text_px, y + line - 1)
        badge(canvas, box, str(number), colour_of(intruder), small=True)
        canvas.text(np.array([right, y + 0.5 * line]), words, RED if intruder.warning else INK, "rm", small=True)
        y += line
    if hidden:
        canvas.text(np.array([left, y + 0.5 * line]), f"and {hidden + 1} more", MUTED, "lm", small=True)
        y += line
    return y


def _distance(one_m: ArrayLike, two_m: ArrayLike) -> float:
    """Distance of two points [m]."""
    return math.dist(np.asarray(one_m).tolist(), np.asarray(two_m).tolist())


def _metres(value: float, unit: bool = True) -> str:
    if not math.isfinite(value):
        return "n/a"
    return f"{value:.1f}" + (" m" if unit else "")


def _estimate(intruder: Intruder) -> str:
    """The filter's range and standard deviation as words."""
    if not math.isfinite(intruder.range_m):
        return "n/a"
    return f"{intruder.range_m:.0f} ± {intruder.range_std_m:.0f} m"
