"""Places the labels of a chart so that none covers another one, and few cover a mark or a line."""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

Box = tuple[float, float, float, float]  # left, top, right, bottom

HEIGHT_EM, WIDE_EM, NARROW_EM = 1.2, 1.0, 0.58
DISTANCES_PX = (8.0, 14.0, 22.0, 34.0, 50.0, 70.0)
DIRECTIONS = tuple((math.cos(k * math.pi / 8), math.sin(k * math.pi / 8)) for k in range(16))
ROUNDS = 3
LABEL_COST, MARK_COST, LINE_COST = 50.0, 4.0, 1.0  # per square pixel covered, and per pixel of line


@dataclass(frozen=True)
class Label:
    """A text that belongs to one of several spots.

    Parameters
    ----------
    text : str
    spots : tuple of (float, float)
        Places in pixels, any of which it may stand beside.
    size_px : float
        Size of the type.
    """

    text: str
    spots: tuple[tuple[float, float], ...]
    size_px: float = 12.0


@dataclass(frozen=True)
class Placed:
    """Where a label stands: its box, and the spot that it belongs to."""

    box: Box
    spot: tuple[float, float]

    @property
    def distance_px(self) -> float:
        """From the spot to the nearest edge of the box."""
        left, top, right, bottom = self.box
        x, y = self.spot
        return math.hypot(max(left - x, 0.0, x - right), max(top - y, 0.0, y - bottom))


def width_px(text: str, size_px: float) -> float:
    """Width of a text in a common sans-serif type, rather too much than too little."""
    wide = sum(unicodedata.east_asian_width(character) in "WF" for character in text)
    return size_px * (WIDE_EM * wide + NARROW_EM * (len(text) - wide))


def shortened(text: str, length: int) -> str:
    """The text, with its middle left out where it is longer."""
    if len(text) <= length:
        return text
    head = (length - 1) * 2 // 3
    return f"{text[:head]}…{text[len(text) - (length - 1 - head) :]}"


def along(points: Sequence[tuple[float, float]], step_px: float = 4.0) -> list[Box]:
    """Small boxes along a line, for labels to keep off."""
    boxes = []
    for (x0, y0), (x1, y1) in pairwise(points):
        count = max(1, math.ceil(math.hypot(x1 - x0, y1 - y0) / step_px))
        for k in range(count + 1):
            x, y = x0 + (x1 - x0) * k / count, y0 + (y1 - y0) * k / count
            boxes.append((x - 1.0, y - 1.0, x + 1.0, y + 1.0))
    return boxes


def place(labels: Sequence[Label], marks: Sequence[Box], lines: Sequence[Box], bounds: Box) -> list[Placed | None]:
    """A place for each label, in a few rounds of moving one at a time; None for one that finds no free place."""
    choices = [_choices(label, bounds) for label in labels]
    fixed = [
        MARK_COST * _overlap(boxes, np.array(marks).reshape(-1, 4))
        + LINE_COST * _overlap(boxes, np.array(lines).reshape(-1, 4))
        + away
        for boxes, _, away in choices
    ]
    taken = np.full((len(labels), 4), np.nan)
    chosen = [0] * len(labels)
    for _ in range(ROUNDS):
        for i, (boxes, _, _) in enumerate(choices):
            if len(boxes):
                others = np.delete(taken, i, axis=0)
                others = others[~np.isnan(others[:, 0])]
                chosen[i] = int(np.argmin(fixed[i] + LABEL_COST * _overlap(boxes, others)))
                taken[i] = boxes[chosen[i]]
    out: list[Placed | None] = []
    kept: list[Box] = []
    for i, (boxes, spots, _) in enumerate(choices):
        if not len(boxes) or float(_overlap(boxes[chosen[i]][None], np.array(kept).reshape(-1, 4))[0]) > 0.0:
            out.append(None)
            continue
        left, top, right, bottom = (float(edge) for edge in boxes[chosen[i]])
        kept.append((left, top, right, bottom))
        out.append(Placed(kept[-1], spots[chosen[i]]))
    return out


def _choices(label: Label, bounds: Box) -> tuple[np.ndarray, list[tuple[float, float]], np.ndarray]:
    """Boxes round every spot that lie inside the bounds, their spots, and a cost that grows with the distance."""
    half_x, half_y = width_px(label.text, label.size_px) / 2.0, label.size_px * HEIGHT_EM / 2.0
    boxes, spots, away = [], [], []
    for spot in label.spots:
        for distance in DISTANCES_PX:
            for dx, dy in DIRECTIONS:
                # The nearest edge, not the centre, lies at that distance.
                x = spot[0] + dx * distance + half_x * max(-1.0, min(1.0, 2.0 * dx))
                y = spot[1] + dy * distance + half_y * max(-1.0, min(1.0, 2.0 * dy))
                box = (x - half_x, y - half_y, x + half_x, y + half_y)
                if box[0] >= bounds[0] and box[1] >= bounds[1] and box[2] <= bounds[2] and box[3] <= bounds[3]:
                    boxes.append(box)
                    spots.append(spot)
                    away.append(2.0 * distance)
    return np.array(boxes).reshape(-1, 4), spots, np.array(away)


def _overlap(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Area of each box (n, 4) that others (m, 4) cover, summed over them."""
    if not len(others):
        return np.zeros(len(boxes))
    a, b = boxes[:, None], others[None]
    wide = np.minimum(a[..., 2], b[..., 2]) - np.maximum(a[..., 0], b[..., 0])
    high = np.minimum(a[..., 3], b[..., 3]) - np.maximum(a[..., 1], b[..., 1])
    return (np.clip(wide, 0.0, None) * np.clip(high, 0.0, None)).sum(axis=1)
