"""The closest approach that the message held predicts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

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

    def table(self, seen: Mapping[str, Any], xp: Any) -> dict[str, Any]:
        """Of every intruder."""
        axes = AXES[:2] if self.world.encounter.planar else AXES
        has_positions = "message_position_along_m" in seen
        return known_only(seen, located(seen, axes, xp) if has_positions else _ranged(seen, axes, xp), xp)


def known_only(seen: Mapping[str, Any], table: dict[str, Any], xp: Any) -> dict[str, Any]:
    """Zero without a message."""
    known = seen["message_valid"] > 0.5
    return {name: xp.where(known, values, xp.zeros_like(values)) for name, values in table.items()}


def located(seen: Mapping[str, Any], axes: tuple[str, ...], xp: Any) -> dict[str, Any]:
    """The features where positions are known, of arrays of the namespace `xp`: numpy, or torch for their gradients."""
    velocity, error = vectors(seen, "velocity", "mps", xp)[:, None], vectors(seen, "track_error", "m", xp)[:, None]
    announced = vectors(seen, "message_velocity", "mps", xp)
    position = vectors(seen, "message_position", "m", xp) + announced * seen["message_age_s"][..., None]
    cruise = seen["cruise_mps"][:, None]
    planned = xp.stack([announced[..., 0] - cruise, announced[..., 1], announced[..., 2]], -1)
    table, direction = _heading(planned, axes, xp)
    table["excess"] = (seen["range_m"] - _size(position, xp)) / MISS_M
    table |= _components("position", position / AWAY_M, axes)
    for way, start, relative in (("flown", position, announced - velocity), ("planned", position + error, planned)):
        time, miss = _closest(start, relative, xp)
        table[f"{way}.time"] = time / TIME_S
        table |= _both(f"{way}.distance", _size(miss, xp), xp)
        for axis, name in enumerate(axes):
            table |= _both(f"{way}.miss_{name}", miss[..., axis], xp)
        table |= _both(f"{way}.side", direction[..., 0] * start[..., 1] - direction[..., 1] * start[..., 0], xp)
    return table


def _ranged(seen: Mapping[str, Any], axes: tuple[str, ...], xp: Any) -> dict[str, Any]:
    relative = vectors(seen, "message_velocity", "mps", xp) - vectors(seen, "velocity", "mps", xp)[:, None]
    table, _ = _heading(relative, axes, xp)
    speed, distance = xp.clip(_size(relative, xp), SLOW_MPS, None), seen["range_m"]
    closing = xp.clip(-seen["range_rate_mps"] / speed, -1.0, 1.0)
    table["closing"] = closing
    table["time"] = xp.clip(distance * closing / speed, 0.0, TIME_MAX_S) / TIME_S
    return table | _both("distance", distance * xp.sqrt(1.0 - closing * closing), xp)


def _heading(relative: Any, axes: tuple[str, ...], xp: Any) -> tuple[dict[str, Any], Any]:
    """Speed and direction as features, and the direction."""
    speed = _size(relative, xp)
    direction = relative / xp.clip(speed, SLOW_MPS, None)[..., None]
    return {"speed": speed / SPEED_MPS} | _components("direction", direction, axes), direction


def _closest(position: Any, velocity: Any, xp: Any) -> tuple[Any, Any]:
    """Time of the closest approach of straight flight, and the relative position then."""
    square = xp.clip(_dot(velocity, velocity), SLOW_MPS * SLOW_MPS, None)
    time = xp.clip(-_dot(position, velocity) / square, 0.0, TIME_MAX_S)
    return time, position + velocity * time[..., None]


def _dot(one: Any, two: Any) -> Any:
    """Scalar product, its sum in this order everywhere."""
    return one[..., 0] * two[..., 0] + one[..., 1] * two[..., 1] + one[..., 2] * two[..., 2]


def _size(vector: Any, xp: Any) -> Any:
    return xp.sqrt(_dot(vector, vector))


def _components(name: str, vector: Any, axes: tuple[str, ...]) -> dict[str, Any]:
    return {f"{name}_{axis}": vector[..., index] for index, axis in enumerate(axes)}


def _both(name: str, distance_m: Any, xp: Any) -> dict[str, Any]:
    """A distance by its scale, and soft."""
    return {name: distance_m / MISS_M, f"{name}.soft": distance_m / (xp.abs(distance_m) + NEAR_M)}
