"""The drawings of an entry's page: flights from above, and its cost by family."""

from __future__ import annotations

from typing import Any

import numpy as np
from markupsafe import Markup

from rss_gym.eval.report.flights import ReplayFlight
from rss_gym.pages.figure import COLOURS, INK, MUTED, figure
from rss_gym.pages.numbers import figures

SIDE_IN, EDGE_IN = 3.3, 0.15  # of a drawing, and round the paths
SCALE_M = 50.0  # the bar below
PUBLIC, SEALED = COLOURS[7], COLOURS[0]
Points = list[tuple[float, float]]


def encounter(number: int, flight: ReplayFlight) -> dict[str, Any]:
    """One encounter: its paths from above, north up, and what the line below says of it."""
    axes_count = 2 if len(flight.own["position"]) == 2 * len(flight.times) else 3
    own, planned = (_points(flight.own[name], axes_count) for name in ("position", "planned"))
    others = [_points(other["position"], axes_count) for other in flight.intruders]
    every = np.array([point for path in (own, planned, *others) for point in path])
    low, high = every.min(axis=0), every.max(axis=0)
    inch = max(float((high - low).max()), SCALE_M) / (SIDE_IN - 2.0 * EDGE_IN)  # in metres
    height_in = max(0.6, float(high[1] - low[1]) / inch) + 2.0 * EDGE_IN + 0.3  # a road is long and narrow
    closest = int(np.argmin(flight.least)) if flight.least else 0
    with figure("Paths from above", width_in=SIDE_IN, height_in=height_in) as drawing:
        axes = drawing.axes
        axes.figure.set_layout_engine("none")
        axes.set_position((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        corner = (low[0] + high[0] - SIDE_IN * inch) / 2.0, high[1] + EDGE_IN * inch - height_in * inch
        axes.set(xlim=(corner[0], corner[0] + SIDE_IN * inch), ylim=(corner[1], corner[1] + height_in * inch))
        axes.plot(*np.transpose(planned), color=MUTED, linestyle="--", linewidth=0.8)
        for path, colour in ((own, COLOURS[0]), *((path, COLOURS[1]) for path in others)):
            axes.plot(*np.transpose(path), color=colour)
            axes.plot(*path[min(closest, len(path) - 1)], "o", color=colour, markersize=6.0, markerfacecolor="none")
        left, floor = corner[0] + 0.1 * inch, corner[1] + 0.1 * inch
        axes.plot([left, left + SCALE_M], [floor, floor], color=INK, linewidth=0.8)
        axes.text(left, floor + 0.05 * inch, f"{SCALE_M:g} m")
    return {
        "number": number,
        "figure": drawing.html,
        "least_m": min(flight.least) / 100.0,
        "time_s": flight.times[closest],
        "collision": flight.collision,
    }


def _points(values: list[int | None], axes: int) -> Points:
    """Metres (east, north) of decimetres in rows of `axes`; what is not known is left out."""
    rows = [values[i : i + axes] for i in range(0, len(values), axes)]
    return [(row[0] / 10.0, row[1] / 10.0) for row in rows if row[0] is not None and row[1] is not None]


def bars(public: dict[str, Any], sealed: dict[str, Any]) -> Markup:
    """The mean cost by family, a bar of the public encounters above one of the sealed."""
    names = list(dict.fromkeys([*public, *sealed]))
    with figure("Cost by family", width_in=4.4, height_in=0.2 + 0.36 * len(names)) as drawing:
        axes = drawing.axes
        for costs, shift, colour in ((public, -0.2, PUBLIC), (sealed, 0.2, SEALED)):
            found = [(row, costs[name]["cost_m"]) for row, name in enumerate(names) if name in costs]
            drawn = axes.barh([row + shift for row, _ in found], [cost for _, cost in found], 0.36, color=colour)
            axes.bar_label(drawn, [figures(cost) for _, cost in found], padding=3.0, fontsize=9.0)
        axes.set_yticks(range(len(names)), names)
        axes.set_ylim(len(names) - 0.5, -0.5)
        axes.margins(x=0.15)
        axes.grid(visible=False)
        axes.tick_params(left=False)
        axes.xaxis.set_visible(False)
        axes.spines[["left", "bottom"]].set_visible(False)
    return drawing.html
