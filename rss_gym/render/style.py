"""Colours, and small helpers shared by the parts of a picture."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rss_gym.render.scene import Intruder

Colour = tuple[int, int, int]
Points = NDArray[np.float64]

PAPER, PANEL, GRID, FRAME = (251, 252, 253), (242, 244, 247), (229, 233, 238), (203, 210, 218)
INK, MUTED, WHITE = (31, 41, 51), (98, 110, 123), (255, 255, 255)
BLUE, ORANGE, RED, GREEN = (0, 98, 168), (230, 146, 0), (186, 16, 40), (0, 128, 96)
RING = (66, 146, 198)  # the agent's range estimate


def tint(colour: Colour, strength: float) -> Colour:
    """The colour mixed with the background: 1 leaves it, 0 removes it."""
    red, green, blue = (round(p + strength * (c - p)) for c, p in zip(colour, PAPER, strict=True))
    return red, green, blue


def colour_of(intruder: Intruder) -> Colour:
    """Colour of an intruder and of its zone."""
    return RED if intruder.warning else ORANGE


def state(warning: bool) -> tuple[str, Colour | None]:
    """Word and ground of a badge."""
    return ("WARNING", RED) if warning else ("no warning", None)


def finite(points_m: ArrayLike) -> Points:
    """Points as an array (n, 3) [m], without those that are not finite."""
    points = np.asarray(points_m, dtype=np.float64).reshape(-1, 3)
    return points[np.isfinite(points).all(axis=1)]


def thinned(path_px: Points, spot_px: Points) -> Points:
    """The path with vertices about 3 pixels apart, ended at the spot; vertices once drawn stay."""
    if len(path_px):
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path_px, axis=0).T))])
        path_px = path_px[np.unique(np.floor(along / 3.0), return_index=True)[1]]
    return np.concatenate([path_px, spot_px[None]]) if np.isfinite(spot_px).all() else path_px


def nice_step(length: float) -> float:
    """The smallest of 1, 2, 5, 10, 20, 50, ... that is not below `length`."""
    decade = 10.0 ** math.floor(math.log10(max(length, 1e-9)))
    return next(step * decade for step in (1, 2, 5, 10) if step * decade >= length * (1 - 1e-9))
