"""highway-env's traffic between two decisions, by the compiled kernel: what goes in, and what comes back."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from rss_gym.highway.compiled_traffic.records import CONNECTED_MAX, CONTROLLED, IDM, LANE, OBSTACLE, VEHICLE
from rss_gym.highway.compiled_traffic.step import drive
from rss_gym.highway.sensor import Sensor


class CompiledTraffic:
    """The vehicles and lanes of one road of highway-env, which begins an episode.

    Parameters
    ----------
    road : Road
        Of highway-env.
    """

    def __init__(self, road: Any) -> None:
        self.road = road
        lanes = road.network.lanes_dict()
        self._indices, self._lanes = list(lanes), list(lanes.values())
        self._numbers = {index: number for number, index in enumerate(self._indices)}
        self._table = self._lane_table(road)
        self._rows = np.array([self._row(vehicle) for vehicle in [*road.vehicles, *road.objects]], VEHICLE)

    def run(self, agent: Any, ticks: int, tick_s: float) -> tuple[np.ndarray, np.ndarray]:
        """Drive for some ticks; the agent of highway-env is then where it would be, the others after `write_back`.

        Returns
        -------
        states : (ticks, n, 4) array
            Position (m), heading (rad) and speed (m/s) of the road's vehicles after each tick.
        roads : (ticks, 3) array
            Direction of the agent's lane, and how far (m) the agent is to the right of its centre.
        """
        vehicles, rows = self.road.vehicles, self._rows
        states, roads = np.empty((ticks, len(rows), 4)), np.empty((ticks, 3))
        number = vehicles.index(agent)
        rows[number] = self._row(agent)  # what its driver has commanded
        drive(rows, number, self._table, ticks, tick_s, states, roads)
        self._write(agent, rows[number].tolist())
        return states[:, : len(vehicles)], roads

    def write_back(self) -> None:
        """Put all vehicles of highway-env where the kernel has them."""
        for vehicle, row in zip(self.road.vehicles, self._rows.tolist(), strict=False):
            self._write(vehicle, row)

    def _row(self, vehicle: Any) -> tuple[Any, ...]:
        """A vehicle, or an object, as the kernel has it."""
        moves = hasattr(vehicle, "target_lane_index")
        kind = OBSTACLE if not moves else IDM if hasattr(vehicle, "timer") else CONTROLLED
        lane = self._numbers[vehicle.lane_index]
        action = getattr(vehicle, "action", {"steering": 0.0, "acceleration": 0.0})
        return (
            tuple(vehicle.position), vehicle.heading, vehicle.speed, vehicle.LENGTH, vehicle.WIDTH, kind, lane,
            self._numbers[vehicle.target_lane_index] if moves else lane, getattr(vehicle, "target_speed", 0.0),
            getattr(vehicle, "DELTA", 0.0), getattr(vehicle, "timer", 0.0), action["steering"],
            action["acceleration"], vehicle.crashed, vehicle.check_collisions, moves and vehicle.impact is not None,
            (0.0, 0.0) if vehicle.impact is None else tuple(vehicle.impact),
        )  # fmt: skip

    def _write(self, vehicle: Any, row: tuple[Any, ...]) -> None:
        """Put a vehicle where the kernel has it."""
        (
            position_m, vehicle.heading, vehicle.speed, _, _, kind, lane, target_lane, _, _, timer_s, steering,
            acceleration, vehicle.crashed, _, hit, impact_m,
        ) = row  # fmt: skip
        vehicle.position = np.array(position_m)
        vehicle.lane_index, vehicle.lane = self._indices[lane], self._lanes[lane]
        vehicle.target_lane_index = self._indices[target_lane]
        vehicle.action = {"steering": steering, "acceleration": acceleration}
        vehicle.impact = np.array(impact_m) if hit else None
        if kind == IDM:
            vehicle.timer = timer_s

    def _lane_table(self, road: Any) -> np.ndarray:
        """The lanes of the network, and which lead to which, as `RoadNetwork.next_lane` and `Road` find them."""
        graph, table = road.network.graph, np.zeros(len(self._lanes), LANE)
        for index, lane, row in zip(self._indices, self._lanes, table, strict=True):
            start, end, number = index
            row["start_m"], row["direction"], row["heading"] = lane.start, lane.direction, lane.heading
            row["length_m"], row["width_m"], row["forbidden"] = lane.length, lane.width, lane.forbidden
            row["speed_limit_mps"] = np.inf if lane.speed_limit is None else lane.speed_limit
            for name in ("amplitude", "pulsation", "phase"):
                row[f"{name}_m" if name == "amplitude" else name] = getattr(lane, name, 0.0)
            row["left"] = self._numbers.get((start, end, number - 1), -1)
            row["right"] = self._numbers.get((start, end, number + 1), -1)
            following: list[Any] = []
            connected = [(index, 0.0)]
            for then, ids in graph.get(end, {}).items():
                same = len(ids) == len(graph[start][end])
                following += [(end, then, number)] if same else [(end, then, k) for k in range(len(ids))]
                connected.append(((end, then, number if number < len(ids) else 0), lane.length))
            for before, ends in graph.items():
                if start in ends:
                    k = number if number < len(ends[start]) else 0
                    connected.append(((before, start, k), -ends[start][k].length))
            if not road.neighbour_vehicles_connected_lanes:
                connected = connected[:1]
            for name, found in (("next", following), ("connected", [which for which, _ in connected])):
                row[name][: len(found)] = [self._numbers[which] for which in found]
                row[f"{name}_count"] = len(found)
            row["offset_m"][: len(connected)] = [offset_m for _, offset_m in connected]
        return table


def take_over(base: Any, sensor: Sensor, is_compiled: bool) -> CompiledTraffic | None:
    """Drive the episode that has begun by the kernel if that is wanted and it can; else None, and highway-env drives.

    highway-env's reward and info, which are not looked at in trainings, are then empty.
    """
    for name in ("_simulate", "_reward", "_info"):
        vars(base).pop(name, None)
    if not (is_compiled and can_compile(base.road)):
        return None
    traffic = CompiledTraffic(base.road)
    base._simulate = functools.partial(_simulate, base, traffic, sensor)
    base._reward, base._info = _no_reward, _no_info
    return traffic


def _simulate(base: Any, traffic: CompiledTraffic, sensor: Sensor, action: Any) -> None:
    """What highway-env's method of this name does in a decision."""
    ticks, tick_s = sensor.params.clock.ticks_per_decision, sensor.params.clock.tick_s
    base.action_type.act(action)
    sensor.log(base.road.vehicles, *traffic.run(base.vehicle, ticks, tick_s))
    base.steps += ticks


def _no_reward(action: Any) -> float:
    return 0.0


def _no_info(observation: Any, action: Any = None) -> dict[str, Any]:
    return {}


def can_compile(road: Any) -> bool:
    """Whether the kernel knows all that is on a road: its lanes, its vehicles and its objects."""
    from highway_env.road.lane import SineLane, StraightLane
    from highway_env.road.road import Road
    from highway_env.vehicle.behavior import IDMVehicle
    from highway_env.vehicle.controller import MDPVehicle
    from highway_env.vehicle.objects import Obstacle

    lanes = road.network.lanes_dict().values()
    plain = all(type(lane) in (StraightLane, SineLane) for lane in lanes) and not road.record_history
    known = all(type(v) in (IDMVehicle, MDPVehicle) and not v.route for v in road.vehicles)
    inert = all(type(item) is Obstacle for item in road.objects)
    few = all(
        sum(len(ids) for ids in road.network.graph.get(end, {}).values()) < CONNECTED_MAX
        for _, end, _ in road.network.lanes_dict()
    )
    return type(road) is Road and plain and known and inert and few
