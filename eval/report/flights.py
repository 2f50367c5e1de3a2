"""The flights that a record keeps for the replays of its page, `flights.json`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from rss_gym.core import BaseBatch, Batch
from rss_gym.highway.batch import RoadBatch

FLIGHTS = "flights.json"
FORMAT = 1  # raised when its fields change


@dataclass(frozen=True)
class Flown:
    """Flights that a record keeps.

    Parameters
    ----------
    flights : dict
        (name of the policy, number of the encounter) -> `ReplayFlight.to_dict`, with `same`: whether it came out as
        scored.
    failed : tuple of str
        One sentence for each policy that failed when it was flown again.
    """

    flights: dict[tuple[str, int], dict[str, Any]]
    failed: tuple[str, ...] = ()

    def document(self) -> dict[str, Any]:
        """`flights.json` as a dict; the flights stand in the order in which they were flown."""
        listed = [{"policy": name, "episode": number} | flight for (name, number), flight in self.flights.items()]
        return {"format": FORMAT, "flights": listed, "failed": list(self.failed)}


class ReplayFlight:
    """The samples of one flight, one a decision: call it with the batch of one, as `fly` does.

    Lengths are whole decimetres and the least separation whole centimetres, which keeps the page small.
    """

    def __init__(self) -> None:
        self.own: dict[str, list[int | None]] = {"position": [], "planned": [], "way_point": []}
        self.intruders: list[dict[str, list[int | None]]] = []
        self.least: list[int] = []
        self.times: list[float] = []
        self.collision = False

    def __call__(self, batch: BaseBatch) -> None:
        """Take the present moment of row 0."""
        episode = batch.episode[0]
        if isinstance(batch, RoadBatch):
            own, others = _road(batch)
        else:
            assert isinstance(batch, Batch)
            own, others = _air(batch)
        for name, values in own.items():
            self.own[name] += scaled(values)
        for k, (position_m, other, is_heard) in enumerate(others):
            if k == len(self.intruders):  # on a road one may come later: until then it stands where it will appear
                self.intruders.append({name: [] for name in ("position", "message", "range", "std", "zone", "warning")})
                for _ in self.times:
                    self._add(self.intruders[k], position_m, other, False)
            self._add(self.intruders[k], position_m, other, is_heard)
        self.least.append(round(100.0 * float(episode["min_separation_m"])))
        self.times.append(round(float(episode["tick"]) * batch.params.clock.tick_s, 3))
        self.collision = bool(episode["collision"])

    @staticmethod
    def _add(into: dict[str, list[int | None]], position_m: np.ndarray, other: Any, is_heard: bool) -> None:
        into["position"] += scaled(position_m)
        message = other["position_m"] + other["age_s"] * other["velocity_mps"]
        into["message"] += scaled((message if is_heard and other["valid"] else np.full(3, np.nan))[: len(position_m)])
        for name, column in (("range", "range_m"), ("std", "range_std_m"), ("zone", "radius_m")):
            into[name] += scaled(other[column] if is_heard else np.nan)
        into["warning"].append(int(is_heard and other["warning"]))

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON types."""
        return {
            "own": self.own,
            "intruders": self.intruders,
            "least": self.least,
            "times": self.times,
            "collision": self.collision,
        }


Moment = tuple[dict[str, np.ndarray], list[tuple[np.ndarray, Any, bool]]]


def _air(batch: Batch) -> Moment:
    """The agent's vectors, and of each intruder its position, what is sensed of it, and whether it is."""
    params, own, aircraft = batch.params, batch.seen.own[0], batch.state.aircraft[0]
    axes = 2 if params.encounter.planar else 3
    others = batch.seen.others[0].copy()
    others["valid"] &= params.interface.information != "ranges"
    vectors = {"position": aircraft[0]["position_m"], "planned": own["planned_m"], "way_point": own["way_point_m"]}
    present = range(int(batch.episode[0]["intruders"]))
    return (
        {name: values[:axes] for name, values in vectors.items()},
        [(aircraft[1 + k]["position_m"][:axes], others[k], True) for k in present],
    )


def _road(batch: RoadBatch) -> Moment:
    """The same of a drive, with what highway-env has to the right as south."""
    env, north = batch.environments[0], np.array([1.0, -1.0])
    planned_m = env.plan.position_m(float(batch.episode[0]["tick"]) * batch.params.clock.tick_s)
    own = {"position": env.vehicle.position, "planned": planned_m, "way_point": env.vehicle.position}
    vehicles, others = env.ranging.sensor.vehicles[1:], env.ranging.sensor.sense_all().copy()
    others["position_m"][:, 1] *= -1.0
    others["velocity_mps"][:, 1] *= -1.0
    return (
        {name: values * north for name, values in own.items()},
        [(v["position_m"][:2] * north, o, bool(o["present"])) for v, o in zip(vehicles, others, strict=True)],
    )


def scaled(values: Any) -> list[int | None]:
    """Metres as whole decimetres; None for what is not finite."""
    return [round(10.0 * value) if math.isfinite(value) else None for value in np.atleast_1d(values).tolist()]
