"""The signs of a picture, drawn at a point of a canvas."""

from __future__ import annotations

import math

import numpy as np

from rss_gym.render.canvas import Box, Canvas, circle_points
from rss_gym.render.style import FRAME, INK, MUTED, PANEL, PAPER, WHITE, Colour, Points


def label(canvas: Canvas, spot: Points, words: str) -> None:
    """Words beside the sign at `spot`, on whichever side has room."""
    shown = canvas.inside(spot)
    side = np.where(canvas.inside(shown + canvas.px(20, -20)) == shown + canvas.px(20, -20), 1, -1)
    canvas.text(shown + canvas.px(13, -13) * side, words, INK, "mm", halo=PAPER)


def disc(canvas: Canvas, centre: Points, radius: float, colour: Colour, hollow: bool = False) -> None:
    """Filled circle with a light rim, or its outline."""
    canvas.polygon(circle_points(centre, (radius + 1.2) * canvas.unit), WHITE)
    canvas.polygon(circle_points(centre, radius * canvas.unit), colour)
    if hollow:
        canvas.polygon(circle_points(centre, (radius - 1.6) * canvas.unit), WHITE)


def hoop(canvas: Canvas, centre: Points, colour: Colour) -> None:
    """Small hollow circle."""
    disc(canvas, centre, 4.5, colour, hollow=True)


def dart(
    canvas: Canvas, centre: Points, heading: Points, colour: Colour, hollow: bool = False, size: float = 10.0
) -> None:
    """Arrow head along `heading` (pixels, y down), which is not zero."""
    ahead = np.asarray(heading) / np.hypot(*heading)
    shape = np.array([(1.15, 0.0), (-0.85, 0.8), (-0.45, 0.0), (-0.85, -0.8)]) * size * canvas.unit
    turned = shape[:, :1] * ahead + shape[:, 1:] * np.array([-ahead[1], ahead[0]])
    canvas.line(centre + turned[[0, 1, 2, 3, 0, 1]], WHITE, 3.2)
    canvas.polygon(centre + turned, WHITE if hollow else colour)
    if hollow:
        canvas.line(centre + turned[[0, 1, 2, 3, 0, 1]], colour, 1.4)


def cross(canvas: Canvas, centre: Points, colour: Colour) -> None:
    """Draw a saltire, 10 px wide, at a pixel (2,)."""
    arm = canvas.px(5, 5)
    for rim, width in ((WHITE, 4.0), (colour, 2.0)):
        for way in ((1, 1), (1, -1)):
            canvas.line(np.array([centre - arm * way, centre + arm * way]), rim, width)


def diamond(canvas: Canvas, centre: Points, colour: Colour) -> None:
    """Small hollow diamond."""
    corners = np.array([(0, -1), (1, 0), (0, 1), (-1, 0)]) * canvas.unit
    for size, fill in ((8.5, WHITE), (7.0, colour), (4.2, WHITE)):
        canvas.polygon(centre + size * corners, fill)


def burst(canvas: Canvas, centre: Points, colour: Colour) -> None:
    """Rays round a point."""
    for angle in np.arange(8) * (math.pi / 4) + math.pi / 8:
        ray = np.array([math.cos(angle), math.sin(angle)]) * canvas.unit
        canvas.line(np.array([centre + 17 * ray, centre + 27 * ray]), colour, 2.6)


def badge(canvas: Canvas, box: Box, name: str, fill: Colour | None, small: bool = False) -> None:
    """Word on a coloured ground, or in a frame when `fill` is None."""
    left, top, right, bottom = box
    corner = 4 * canvas.unit
    canvas.bar(box, fill or FRAME, corner)
    if fill is None:
        canvas.bar((left + 1, top + 1, right - 1, bottom - 1), PANEL, corner - 1)
    middle = np.array([left + right, top + bottom]) / 2
    canvas.text(middle, name, MUTED if fill is None else WHITE, "mm", small=small)


def pair(canvas: Canvas, y: float, name: str, value: str, colour: Colour) -> None:
    """A name on the left and its value on the right of one row."""
    middle = y + 0.5 * canvas.text_px
    canvas.text(np.array([canvas.gap, middle]), name, MUTED, "lm", small=True)
    canvas.text(np.array([canvas.size_px[0] - canvas.gap, middle]), value, colour, "rm")
