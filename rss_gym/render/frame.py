"""One frame: how the parts are laid out, and the call that draws them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rss_gym.render.altitude import draw_altitudes
from rss_gym.render.canvas import Canvas, pillow
from rss_gym.render.map import View, draw_map
from rss_gym.render.panel import draw_panel
from rss_gym.render.scene import Scene
from rss_gym.render.style import FRAME, PANEL, PAPER, finite

SMALLEST_PX = (400, 300)


def map_view(scene: Scene, size_px: tuple[int, int] = (960, 720)) -> View:
    """View of the map in the upper left of `draw(scene, size_px)`.

    It holds the zone round every intruder on its predefined trajectory, and the agent's trajectory with half a zone to
    spare. It follows from those alone, hence stays still during an episode.

    Parameters
    ----------
    scene : Scene
    size_px : tuple of int
        Width and height of the whole picture [px].

    Returns
    -------
    View
    """
    layout = Layout.of(size_px, scene.planar)
    corners = [finite(scene.own.predefined_m) + side * scene.zone_radius_m / 2 for side in (-1, 1)]
    for intruder in scene.intruders:
        corners += [finite(intruder.predefined_m) + side * scene.zone_radius_m for side in (-1, 1)]
    every = np.concatenate(corners)[:, :2]
    low, high = (every.min(0), every.max(0)) if len(every) else (np.zeros(2), np.zeros(2))
    extent = np.maximum(high - low, 40.0)
    scale = float(min(np.array(layout.map_px) / (1.04 * extent)))
    east, north = ((low + high) / 2).tolist()
    return View((east, north), (scale, scale), layout.map_px)


def draw(scene: Scene, size_px: tuple[int, int] = (960, 720)) -> NDArray[np.uint8]:
    """Draw a scene: map from above, panel on the right and, off the plane, a strip of altitudes.

    Parameters
    ----------
    scene : Scene
    size_px : tuple of int
        Width and height [px], at least 400 by 300.

    Returns
    -------
    array (height, width, 3) of uint8
        The same scene gives the same array.
    """
    layout = Layout.of(size_px, scene.planar)
    image = pillow("Image").new("RGB", layout.size_px, FRAME)

    chart = Canvas(layout.map_px, layout.unit, PAPER)
    draw_map(chart, map_view(scene, size_px), scene)
    chart.place(image, (0, 0))

    if not scene.planar:
        strip = Canvas((layout.map_px[0], layout.strip_px), layout.unit, PAPER)
        draw_altitudes(strip, scene)
        strip.place(image, (0, layout.map_px[1] + 1))

    panel = Canvas((layout.panel_px, layout.size_px[1]), layout.unit, PANEL)
    free = draw_panel(panel, scene)
    panel.place(image, (layout.map_px[0] + 1, 0))

    top, bottom = free
    side = int(min(layout.panel_px - 2 * panel.gap, bottom - top))
    if side >= 7 * panel.text_px:
        inset = Canvas((side, side), layout.unit, PAPER)
        reach = max(40.0, 6 * scene.collision_radius_m)
        east, north = np.asarray(scene.own.position_m, dtype=np.float64)[:2].tolist()
        draw_map(inset, View((east, north), (side / 2 / reach,) * 2, (side, side)), scene, close_up=True)
        inset.place(image, (int(layout.map_px[0] + 1 + panel.gap), int(top)), border=FRAME)
    return np.array(image, dtype=np.uint8)


@dataclass(frozen=True, slots=True)
class Layout:
    """Sizes [px] of the parts; `unit` is 1 in a picture of 960 by 720."""

    size_px: tuple[int, int]
    map_px: tuple[int, int]
    panel_px: int
    strip_px: int
    unit: float

    @classmethod
    def of(cls, size_px: tuple[int, int], planar: bool) -> Layout:
        """Sizes of the parts of a picture of `size_px`."""
        width, height = (int(side) for side in size_px)
        if width < SMALLEST_PX[0] or height < SMALLEST_PX[1]:
            raise ValueError(f"size_px is {size_px}; the smallest picture is {SMALLEST_PX}")
        unit = min(width / 960, height / 720)
        panel = round(max(236 * unit, min(188, 0.44 * width)))
        strip = 0 if planar else round(0.22 * height)
        return cls((width, height), (width - panel - 1, height - strip - (not planar)), panel, strip, unit)
