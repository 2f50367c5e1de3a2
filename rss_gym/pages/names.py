"""Names beside the points of a figure, placed by adjustText, and shortened where they are long."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from rss_gym.pages.figure import FRAME

ROUNDS = 200  # of moving the names; a limit of time would make the figure depend on the machine


@dataclass(frozen=True)
class Name:
    """A text that belongs to a point of the axes."""

    text: str
    x: float
    y: float
    colour: str
    weight: str = "normal"


def shortened(text: str, length: int) -> str:
    """The text, with its middle left out where it is longer; what UTF-8 has no bytes for is a question mark."""
    text = text.encode("utf-8", "replace").decode()
    if len(text) <= length:
        return text
    head = (length - 1) * 2 // 3
    return f"{text[:head]}…{text[len(text) - (length - 1 - head) :]}"


def place(axes: Any, names: Sequence[Name], points: Iterable[tuple[float, float]]) -> list[int]:
    """Write the names beside their points, away from each other and from all `points`.

    Called when the axes have their limits and hold everything else.

    Returns
    -------
    list of int
        The indices of names without room, which are not written.
    """
    from adjustText import adjust_text

    axes.figure.draw_without_rendering()
    axes.figure.set_layout_engine("none")  # the axes stay where they are now
    texts = [
        axes.text(n.x, n.y, n.text, color=n.colour, fontweight=n.weight, fontsize=9.5, parse_math=False) for n in names
    ]
    x, y = zip(*points, strict=True)
    arrow = {"arrowstyle": "-", "color": FRAME, "linewidth": 0.7}
    _, lines = adjust_text(texts, x=x, y=y, ax=axes, expand=(1.25, 1.6), iter_lim=ROUNDS, arrowprops=arrow)
    boxes = [text.get_window_extent() for text in texts]
    hidden = [k for k, box in enumerate(boxes) if box.count_overlaps(boxes[:k])]
    for k in hidden:
        texts[k].set_visible(False)
    for line in lines:
        line.set_visible(line.patchA.get_visible())
    return hidden
