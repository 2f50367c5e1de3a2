"""Drawings of flights and bars of costs as inline SVG: coordinates and numbers only, no text from outside."""

from __future__ import annotations

from typing import Any

import numpy as np

from rss_gym.eval.report.flights import ReplayFlight

SIZE = 320.0  # of a drawing, in its own units
Points = list[tuple[float, float]]


def encounter(number: int, flight: ReplayFlight) -> dict[str, Any]:
    """The paths of one encounter from above."""
    axes = 2 if len(flight.own["position"]) == 2 * len(flight.times) else 3
    paths = {"own": flight.own["position"], "planned": flight.own["planned"]}
    shown = {name: _points(values, axes) for name, values in paths.items()}
    others = [_points(other["position"], axes) for other in flight.intruders]
    every = np.array([point for path in (*shown.values(), *others) for point in path])
    low, high = every.min(axis=0), every.max(axis=0)
    scale = (SIZE - 20.0) / max(float((high - low).max()), 1.0)
    middle_m = (low + high) / 2.0
    height = max(80.0, scale * float(high[1] - low[1]) + 20.0)  # a road is long and narrow

    def placed(points: Points) -> str:
        # North is up: an SVG counts downwards.
        centred = [
            (SIZE / 2.0 + scale * (x - middle_m[0]), height / 2.0 - scale * (y - middle_m[1])) for x, y in points
        ]
        return " ".join(f"{x:.1f},{y:.1f}" for x, y in centred)

    closest = int(np.argmin(flight.least)) if flight.least else 0
    return {
        "number": number,
        "height": height + 24.0,  # the scale stands below
        "least_m": min(flight.least) / 100.0,
        "time_s": flight.times[closest],
        "collision": flight.collision,
        "scale_m": 50.0,
        "scale_px": 50.0 * scale,
        "own": placed(shown["own"]),
        "planned": placed(shown["planned"]),
        "others": [placed(points) for points in others],
        "at": [placed([points[min(closest, len(points) - 1)]]) for points in (shown["own"], *others)],
    }


def _points(values: list[int | None], axes: int) -> Points:
    """Metres (east, north) of decimetres in rows of `axes`; what is not known is left out."""
    rows = [values[i : i + axes] for i in range(0, len(values), axes)]
    return [(row[0] / 10.0, row[1] / 10.0) for row in rows if row[0] is not None and row[1] is not None]


def bars(public: dict[str, Any], sealed: dict[str, Any]) -> list[dict[str, Any]]:
    """A bar of each family: the share of the largest cost, of public and sealed encounters."""
    names = list(dict.fromkeys([*public, *sealed]))
    most = max((part[name]["cost_m"] for part in (public, sealed) for name in part), default=0.0) or 1.0
    return [
        {
            "name": name,
            **{
                key: {"value": part[name]["cost_m"], "n": part[name]["n"], "px": 200.0 * part[name]["cost_m"] / most}
                for key, part in (("public", public), ("sealed", sealed))
                if name in part
            },
        }
        for name in names
    ]
