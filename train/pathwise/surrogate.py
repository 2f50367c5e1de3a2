"""The flights again, in PyTorch: where the agent would have been, and what it would have seen, had it acted otherwise.

The equations are those of `rss_gym.flight` and `rss_gym.observation`. Messages, ranging errors, gusts and the intruder
are as recorded; the gradient runs through the agent's motion and through what of its observations depends on it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import torch

from rss_gym import observation
from rss_gym.baselines.features import FEATURES, LIMIT
from rss_gym.baselines.features.approach import AXES
from rss_gym.baselines.features.masks import kept as kept_columns
from rss_gym.params import Params
from rss_gym.train.pathwise.flights import Flights

FAR_M = 1e6  # no separation yet; that of infinity has no gradient
SMALL = 1e-6  # under a root, whose slope at zero is not finite


class Surrogate:
    """The differentiable flight in one world.

    Parameters
    ----------
    world : Params
        With one intruder, commanding velocities.
    features : str
        Of the policy, one of `FEATURES`.
    zeroed : str
        What is taken from it, one of `MASKS`.
    """

    def __init__(self, world: Params, features: str, zeroed: str) -> None:
        self.world, self.features = world, FEATURES[features](world)
        table = observation.fields(world)
        self._names = [field.name.partition(".")[2] or field.name for field in table]
        self._scale = torch.tensor([field.scale for field in table])
        low, high = observation.bounds(world)
        self._low, self._high = torch.as_tensor(low), torch.as_tensor(high)
        self._kept = torch.as_tensor(kept_columns(zeroed, world))
        self._axes = AXES[:2] if world.encounter.planar else AXES

    def fly(
        self,
        flights: Flights,
        actor: Callable[[torch.Tensor], torch.Tensor],
        decay: float,
        largest: float,
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Fly all decisions kept.

        Parameters
        ----------
        flights : Flights
        actor : callable
            Inputs (n, d) -> mean actions (n, axes), not clipped.
        decay : float
            Factor on the gradient with respect to the agent's state, a decision: later events count less.
        largest : float
            Norm that such a gradient of one encounter is cut to.

        Returns
        -------
        separation, deviation
            Least true separation (n,) of every other tick, and mean of |u - u^d| over the whole flight, both in metres.
        """
        clock, craft = self.world.clock, self.world.aircraft
        position, velocity, way_point = flights.position[0], flights.velocity[0], flights.way_point[0]
        nearest, deviation = torch.full((len(flights),), FAR_M), torch.zeros(len(flights))
        hook = partial(_tame, decay=decay, largest=largest)
        for t in range(len(flights.kept) - 1):
            if t and torch.is_grad_enabled():
                for state in (position, velocity, way_point):
                    state.register_hook(hook)
            actions = actor(self.inputs(flights, t, position, velocity, way_point)).clip(-1.0, 1.0)
            commanded = self._commanded(flights, t, actions)
            flown = flights.kept[t] > 0.5  # also the decision in which it collided
            for tick in range(1, clock.ticks_per_decision + 1):
                way_point = self._held(way_point + commanded * clock.tick_s, flights, t, tick)
                wanted = craft.position_gain_ps2 * (way_point - position) + craft.velocity_gain_ps * (
                    commanded - velocity
                )
                most = craft.acceleration_max_mps2
                velocity = velocity + self._limited(wanted, most, most) * clock.tick_s
                velocity = self._limited(velocity, craft.speed_max_mps, craft.vertical_speed_max_mps)
                position = position + (velocity + flights.gust[t]) * clock.tick_s
                if tick % 2:
                    there = flights.intruder[t] + flights.intruder_velocity[t] * (tick * clock.tick_s)
                    nearest = torch.minimum(nearest, torch.where(flown, _size(there - position), FAR_M))
            deviation = deviation + flights.kept[t + 1] * _size(position - flights.planned[t + 1])
        return nearest, deviation / flights.decisions

    def inputs(
        self,
        flights: Flights,
        t: int,
        position: torch.Tensor,
        velocity: torch.Tensor,
        way_point: torch.Tensor,
    ) -> torch.Tensor:
        """What the network sees before decision t in this state, (n, d): observation and features."""
        solution = position + flights.position_error[t]
        moved = self._in_axes(position - flights.position[t], flights, t)
        told = {name: values[t] for name, values in flights.seen.items()}
        known = told["message_valid"] > 0.5
        own = {
            ("track_error", "m"): solution - flights.planned[t],
            ("way_point", "m"): way_point - flights.planned[t],
            ("velocity", "mps"): velocity + flights.velocity_error[t],
        }
        for (stem, unit), vector in own.items():
            for axis, values in self._in_axes(vector, flights, t).items():
                told[f"{stem}_{axis}_{unit}"] = values
        for name in told:
            stem, _, axis = name.removesuffix("_m").rpartition("_")
            if stem.endswith("_position") or stem == "message_way_point":
                told[name] = torch.where(known, told[name] - moved[axis][:, None], 0.0)
        farther = _size(flights.intruder[t] - position) - _size(flights.intruder[t] - flights.position[t])
        for name in ("range_m", "margin_m"):
            told[name] = told[name] + farther[:, None]
        table = [told[name] if told[name].ndim == 1 else told[name][:, 0] for name in self._names]
        rows = torch.stack(table, dim=1) / self._scale
        rows = torch.minimum(torch.maximum(rows, self._low), self._high) * self._kept
        seen = dict(told)
        for name, values in zip(self._names, (rows * self._scale).unbind(dim=1), strict=True):
            seen[name] = values if told[name].ndim == 1 else values[:, None]
        for name in seen:  # a position of zero has no direction, whose gradient would not be finite
            if "_position_along" in name:
                seen[name] = torch.where(known, seen[name], 1.0)
        features = list(self.features.table(seen, torch).values())
        if not features:
            return rows
        return torch.cat([rows, torch.cat(features, dim=1).clip(-LIMIT, LIMIT)], dim=1)

    def _in_axes(self, vector: torch.Tensor, flights: Flights, t: int) -> dict[str, torch.Tensor]:
        """Components in the axes of the leg."""
        x, y, z = vector.unbind(dim=1)
        ax, ay, _ = flights.along[t].unbind(dim=1)
        return dict(zip(self._axes, (x * ax + y * ay, x * ay - y * ax, z), strict=False))

    def _commanded(self, flights: Flights, t: int, actions: torch.Tensor) -> torch.Tensor:
        """Velocity of the way point, (n, 3)."""
        craft = self.world.aircraft
        ax, ay, _ = flights.along[t].unbind(dim=1)
        forth, right = craft.speed_max_mps * actions[:, 0], craft.speed_max_mps * actions[:, 1]
        up = torch.zeros_like(forth) if self.world.encounter.planar else craft.vertical_speed_max_mps * actions[:, 2]
        change = torch.stack([forth * ax + right * ay, forth * ay - right * ax, up], dim=1)
        return self._limited(flights.planned_velocity[t] + change, craft.speed_max_mps, craft.vertical_speed_max_mps)

    def _held(self, way_point: torch.Tensor, flights: Flights, t: int, tick: int) -> torch.Tensor:
        """The way point, held in the band of altitudes round the predefined one."""
        if self.world.encounter.planar:
            return way_point
        time_s, band = tick * self.world.clock.tick_s, self.world.encounter.altitude_band_m
        middle = flights.planned[t][:, 2] + flights.planned_velocity[t][:, 2] * time_s
        height = torch.minimum(torch.maximum(way_point[:, 2], middle - band), middle + band)
        return torch.cat([way_point[:, :2], height[:, None]], dim=1)

    def _limited(self, vector: torch.Tensor, largest: float, largest_z: float) -> torch.Tensor:
        """As `rss_gym.physics.motion.limit`."""
        if not self.world.encounter.planar:
            vector = torch.cat([vector[:, :2], vector[:, 2:].clip(-largest_z, largest_z)], dim=1)
        return vector * (largest / _size(vector)).clip(max=1.0)[:, None]


def _size(vector: torch.Tensor) -> torch.Tensor:
    return ((vector * vector).sum(dim=1) + SMALL).sqrt()


def _tame(gradient: torch.Tensor, decay: float, largest: float) -> torch.Tensor:
    """Decay, and the cut of each encounter's norm: a few that turn on a hair's breadth would drown all others.

    A vector of no length has no direction, and the features' gradient there is not finite: it counts as none.
    """
    gradient = torch.nan_to_num(gradient * decay, nan=0.0, posinf=0.0, neginf=0.0)
    return gradient * (largest / (gradient.square().sum(dim=1, keepdim=True) + 1e-30).sqrt()).clip(max=1.0)
