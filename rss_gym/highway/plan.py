"""The plan that is kept or left: the lane and the speed with which an episode of highway-env begins."""

from __future__ import annotations

from typing import Any

import numpy as np


class Plan:
    """Planned lane and speed of a vehicle, and where it would be by now.

    Parameters
    ----------
    road : Road
        Of highway-env.
    vehicle : Vehicle
        At the start of its episode.
    """

    def __init__(self, road: Any, vehicle: Any) -> None:
        self.network, self.lane_index = road.network, vehicle.lane_index
        self.speed_mps = float(getattr(vehicle, "target_speed", vehicle.speed))
        self._start_m = float(vehicle.lane.local_coordinates(vehicle.position)[0])
        self._route = list(getattr(vehicle, "route", None) or [self.lane_index])  # highway-env shortens its own

    def position_m(self, time_s: float) -> np.ndarray:
        """u^d: the planned position (2,), along the route at the planned speed."""
        along_m = self._start_m + self.speed_mps * time_s
        position, _ = self.network.position_heading_along_route(self._route, along_m, 0.0, self.lane_index)
        return np.asarray(position)

    def error_m(self, vehicle: Any) -> float:
        """How far a vehicle is to the right of the planned lane on the road where it is."""
        start, end, _ = vehicle.lane_index
        number = min(self.lane_index[2], len(self.network.graph[start][end]) - 1)
        return float(self.network.get_lane((start, end, number)).local_coordinates(vehicle.position)[1])
