"""A drawing surface on Pillow, which is imported when something is drawn, not when this module is."""

from __future__ import annotations

import math
from functools import lru_cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rss_gym.render.style import GRID, Colour, Points

Box = tuple[float, float, float, float]  # left, top, right and bottom [px]
Sector = tuple[float, float]  # first and last angle, from right to down [rad]
WHOLE: Sector = (0.0, 2 * math.pi)

OVERSAMPLING = 3  # lines are drawn this many times larger, then averaged


class Canvas:
    """A rectangle drawn in its own final pixels: fills at that size, then lines oversampled, then sharp text."""

    def __init__(self, size_px: tuple[int, int], unit: float, background: Colour) -> None:
        self.size_px = size_px
        self.unit = max(unit, 0.7)  # strokes and signs
        self.text_px = max(11.5, 14.5 * unit)
        self.gap = round(14 * self.unit)
        self._image = pillow("Image").new("RGB", size_px, background)
        self._pen = pillow("ImageDraw").Draw(self._image, "RGBA")
        self._large = False
        self._texts: list[tuple[Any, ...]] = []

    def px(self, x: float, y: float) -> Points:
        """A length given for a picture of 960 by 720, in pixels of this one."""
        return np.array([x, y]) * self.unit

    def inside(self, spot: Points) -> Points:
        """The nearest point at least a sign away from the edge."""
        margin = 10 * self.unit
        return np.clip(spot, margin, np.array(self.size_px) - margin)

    def holds(self, spot: Points) -> bool:
        """Whether a point lies on the canvas."""
        return bool((spot >= 0).all() and (spot < self.size_px).all())

    def fill_ring(
        self, centre: Points, inner: float, outer: float, colour: Colour, opacity: float, sector: Sector = WHOLE
    ) -> None:
        """Translucent ring or sector of one. Fills and rules come before lines, which enlarge the picture."""
        far = self._far(centre)
        inner, outer = min(max(inner, 0.0), far), min(outer, far)
        if outer > inner:
            outline = circle_points(centre, outer, sector)
            if inner > 0 or sector != WHOLE:
                outline = np.concatenate([outline, circle_points(centre, inner, sector)[::-1]])
            self._pen.polygon(outline.ravel().tolist(), fill=(*colour, round(255 * opacity)))

    def rule(self, at: float, axis: int) -> None:
        """Grid line one pixel wide across the whole canvas: upright for axis 0, level for axis 1."""
        at = math.floor(at)
        end = (at, self.size_px[1]) if axis == 0 else (self.size_px[0], at)
        self._pen.line([(at, 0) if axis == 0 else (0, at), end], fill=GRID)

    def polygon(self, points: Points, colour: Colour) -> None:
        """Filled polygon."""
        self._scaled().polygon(self._ink(points), fill=colour)

    def line(self, points: Points, colour: Colour, width: float) -> None:
        """Draw a polyline through pixels (p, 2)."""
        if len(points) > 1:
            wide = max(1, round(width * self.unit * OVERSAMPLING))
            joint = "curve" if 2 < len(points) else None
            self._scaled().line(self._ink(points), fill=colour, width=wide, joint=joint)

    def dashes(self, points: Points, colour: Colour, width: float, dash: float = 8.0, space: float = 6.0) -> None:
        """Dashed polyline."""
        if len(points) < 2:
            return
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        period = (dash + space) * self.unit
        starts = np.arange(0.0, along[-1], max(period, along[-1] / 1000)) if along[-1] > 0 else np.empty(0)
        ends = np.minimum(starts + dash * self.unit, along[-1])
        for start, end in zip(starts, ends, strict=True):
            stops = np.concatenate([[start], along[(along > start) & (along < end)], [end]])
            piece = np.stack([np.interp(stops, along, points[:, axis]) for axis in (0, 1)], axis=1)
            if (piece.max(0) > 0).all() and (piece.min(0) < self.size_px).all():
                self.line(piece, colour, width)

    def circle(
        self,
        centre: Points,
        radius: float,
        colour: Colour,
        width: float,
        dashed: bool = False,
        sector: Sector = WHOLE,
    ) -> None:
        """Outline of a circle or an arc of it, left out where none of the circle can be seen."""
        beyond = np.maximum(np.maximum(-centre, centre - self.size_px), 0.0)
        if radius > 0 and math.hypot(*beyond) <= radius <= self._far(centre):
            outline = circle_points(centre, radius, sector)
            if dashed:
                self.dashes(outline, colour, width, 6.0, 4.0)
            else:  # a whole circle goes on to its second point, for a joint at the first
                self.line(np.concatenate([outline, outline[1:2]]) if sector == WHOLE else outline, colour, width)

    def bar(self, box: Box, colour: Colour, radius: float = 2.0) -> None:
        """Rectangle with round corners."""
        left, top, right, bottom = (round(value * OVERSAMPLING) for value in box)
        if right > left and bottom > top:
            self._scaled().rounded_rectangle((left, top, right - 1, bottom - 1), radius * OVERSAMPLING, fill=colour)

    def text(
        self,
        at: Points,
        words: str,
        colour: Colour,
        anchor: str,
        halo: Colour | None = None,
        small: bool = False,
        large: bool = False,
    ) -> None:
        """Words, written on top of everything else; `anchor` as in Pillow."""
        size = round(self.text_px * (0.88 if small else 1.9 if large else 1.0))
        if size < 12:  # hinting makes the spaces of small print too narrow
            words = words.replace(" ", "  ")
        self._texts.append((tuple(np.round(at).tolist()), words, colour, anchor, halo, size))

    def place(self, image: Any, corner_px: tuple[int, int], border: Colour | None = None) -> None:
        """Bring the drawing to its final size and put it into `image`."""
        self._scaled()
        final = self._image.reduce(OVERSAMPLING)
        pen = pillow("ImageDraw").Draw(final)
        for at, words, colour, anchor, halo, size in self._texts:
            rim = {} if halo is None else {"stroke_width": 2, "stroke_fill": halo}
            pen.text(at, words, fill=colour, anchor=anchor, font=_font(size), **rim)
        if border is not None:
            pen.rectangle((0, 0, self.size_px[0] - 1, self.size_px[1] - 1), outline=border)
        image.paste(final, corner_px)

    def _scaled(self) -> Any:
        """The pen for lines; the first call enlarges the picture."""
        if not self._large:
            pil = pillow("Image")
            width, height = self.size_px
            self._image = self._image.resize((width * OVERSAMPLING, height * OVERSAMPLING), pil.Resampling.NEAREST)
            self._pen = pillow("ImageDraw").Draw(self._image)
            self._large = True
        return self._pen

    def _far(self, centre: Points) -> float:
        """Distance [px] from `centre` to the farthest corner, and a little more."""
        return math.hypot(*np.maximum(np.abs(centre), np.abs(np.array(self.size_px) - centre))) + 4.0

    @staticmethod
    def _ink(points: ArrayLike) -> list[int]:
        """Coordinates of the enlarged picture, kept within what Pillow can hold."""
        return np.rint(np.clip(points, -20_000, 20_000) * OVERSAMPLING).astype(np.int64).ravel().tolist()


def circle_points(centre: Points, radius: float, sector: Sector = WHOLE) -> Points:
    """Points (n, 2) on a circle or an arc [px], both ends included."""
    first, last = sector
    count = math.ceil(min(max(radius * 1.2, 24), 360) * (last - first) / (2 * math.pi))
    angle = np.linspace(first, last, count + 1)
    return np.asarray(centre) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def pillow(name: str) -> ModuleType:
    """A module of Pillow, imported when first needed."""
    from importlib import import_module

    try:
        return import_module(f"PIL.{name}")
    except ImportError as error:
        from gymnasium.error import DependencyNotInstalled

        raise DependencyNotInstalled("Drawing needs Pillow: pip install -e '.[render]' in the clone") from error


@lru_cache(maxsize=32)
def _font(size_px: int) -> Any:
    """The font that comes with Pillow, so that no machine draws with another."""
    module = pillow("ImageFont")
    font = module.load_default(size_px)
    return font.font_variant(layout_engine=module.Layout.BASIC)
