"""The closest approach that the message held predicts."""

from __future__ import annotations

from typing import Any

import numpy as np

from rss_gym.baselines.features.feature_set import FeatureSet
from rss_gym.baselines.located import vectors

AXES = ("along", "right", "up")
TIME_S, MISS_M, AWAY_M, SPEED_MPS = 20.0, 30.0, 60.0, 10.0  # scales
NEAR_M = 10.0  # half of what a soft distance can say is said within this
TIME_MAX_S = 60.0
SLOW_MPS = 0.1  # a relative velocity below this counts as this


class Approach(FeatureSet):
    """The closest approach of straight flight by the message held, as flown now and as planned; zero without a message.

    `flown` starts at the own position with the own velocity, `planned` on the predefined trajectory with its velocity.
    The intruder's position is that of the message, moved on by its velocity over its age. The soft distance of x is
    x / (|x| + 10 m), which tells small ones apart. Vectors have the components along, right and, in space, up.

    | track | feature, of each intruder | divided by |
    |---|---|---|
    | all | `speed`, relative, against the planned velocity (`range`: against the own) | 10 m/s |
    | | `direction`, unit vector of that velocity | 1 |
    | with positions | `excess`: estimated range minus distance of the position | 30 m |
    | | `position`, relative to the own | 60 m |
    | | `flown.time`, `planned.time` of the closest approach, 0 to 60 s from now | 20 s |
    | | `flown.miss`, `planned.miss`: relative position then | 30 m |
    | | `flown.distance`, `planned.distance` then | 30 m |
    | | `flown.side`, `planned.side`: how far the intruder is to the right of the start along `direction` | 30 m |
    | | the last three also soft | 1 |
    | `range` | `closing`: cosine between relative velocity and bearing, from the range's rate | 1 |
    | | `time` and `distance` of the closest approach by it | 20 s, 30 m |
    | | `distance` also soft | 1 |
    """

    def table(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> dict[str, np.ndarray]:
        """Of every intruder."""
        axes = AXES[:2] if self.world.encounter.planar else AXES
        found = located(seen, axes) if "message_position_along_m" in seen else _ranged(seen, axes)
        return known_only(seen, found)


def known_only(seen: dict[str, np.ndarray], table: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Zero without a message."""
    known = seen["message_valid"] > 0.5
    return {name: np.where(known, values, 0.0) for name, values in table.items()}


def located(seen: dict[str, Any], axes: tuple[str, ...]) -> dict[str, np.ndarray]:
    """The features where positions are known."""
    velocity, error = vectors(seen, "velocity", "mps")[:, None], vectors(seen, "track_error", "m")[:, None]
    announced = vectors(seen, "message_velocity", "mps")
    position = vectors(seen, "message_position", "m") + announced * seen["message_age_s"][..., None]
    planned = announced.copy()
    planned[..., 0] -= seen["cruise_mps"][:, None]
    table, direction = _heading(planned, axes)
    table["excess"] = (seen["range_m"] - _size(position)) / MISS_M
    table |= _components("position", position / AWAY_M, axes)
    for way, start, relative in (("flown", position, announced - velocity), ("planned", position + error, planned)):
        time, miss = _closest(start, relative)
        table[f"{way}.time"] = time / TIME_S
        table |= _both(f"{way}.distance", _size(miss))
        for axis, name in enumerate(axes):
            table |= _both(f"{way}.miss_{name}", miss[..., axis])
        table |= _both(f"{way}.side", direction[..., 0] * start[..., 1] - direction[..., 1] * start[..., 0])
    return table


def _ranged(seen: dict[str, Any], axes: tuple[str, ...]) -> dict[str, np.ndarray]:
    relative = vectors(seen, "message_velocity", "mps") - vectors(seen, "velocity", "mps")[:, None]
    table, _ = _heading(relative, axes)
    speed, distance = np.maximum(_size(relative), SLOW_MPS), seen["range_m"]
    closing = np.clip(-seen["range_rate_mps"] / speed, -1.0, 1.0)
    table["closing"] = closing
    table["time"] = np.clip(distance * closing / speed, 0.0, TIME_MAX_S) / TIME_S
    return table | _both("distance", distance * np.sqrt(1.0 - closing * closing))


def _heading(relative: np.ndarray, axes: tuple[str, ...]) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Speed and direction as features, and the direction."""
    speed = _size(relative)
    direction = relative / np.maximum(speed, SLOW_MPS)[..., None]
    return {"speed": speed / SPEED_MPS} | _components("direction", direction, axes), direction


def _closest(position: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Time of the closest approach of straight flight, and the relative position then."""
    square = np.maximum(_dot(velocity, velocity), SLOW_MPS * SLOW_MPS)
    time = np.clip(-_dot(position, velocity) / square, 0.0, TIME_MAX_S)
    return time, position + velocity * time[..., None]


def _dot(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Scalar product, its sum in this order everywhere."""
    return one[..., 0] * two[..., 0] + one[..., 1] * two[..., 1] + one[..., 2] * two[..., 2]


def _size(vector: np.ndarray) -> np.ndarray:
    return np.sqrt(_dot(vector, vector))


def _components(name: str, vector: np.ndarray, axes: tuple[str, ...]) -> dict[str, np.ndarray]:
    return {f"{name}_{axis}": vector[..., index] for index, axis in enumerate(axes)}


def _both(name: str, distance_m: np.ndarray) -> dict[str, np.ndarray]:
    """A distance by its scale, and soft."""
    return {name: distance_m / MISS_M, f"{name}.soft": distance_m / (np.abs(distance_m) + NEAR_M)}
