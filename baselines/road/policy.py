"""The base of the scripted drivers, and the two that do not look at the observation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from rss_gym.highway import observation
from rss_gym.params import Group, Params


@dataclass(frozen=True)
class World:
    """What a driver must know of its road.

    Parameters
    ----------
    params : Params
        Of the sensor, which decide the fields of the observation.
    actions : tuple of str
        highway-env's names of the discrete actions, in their order: LANE_LEFT, IDLE, LANE_RIGHT, FASTER, SLOWER.
    radio : bool
        Whether the vehicles' fields are written.
    """

    params: Params
    actions: tuple[str, ...]
    radio: bool = True

    @classmethod
    def of(cls, env: Any) -> World:
        """Of a `RoadEnv`."""
        kinds = getattr(env.road.action_type, "actions", {})
        return cls(env.params, tuple(kinds[index] for index in sorted(kinds)), env.ranging.radio)


@dataclass(frozen=True, kw_only=True)
class Driver(Group):
    """Base of the scripted drivers: options as fields; a subclass writes `act`."""

    world: World

    keywords: ClassVar[dict[str, Any]] = {}  # what the environment must be made with
    information: ClassVar[str | None] = None  # what it is told if that is not what the observation holds

    def act(self, seen: dict[str, np.ndarray]) -> str:
        """The action for one observation in SI units, own fields (), those of the vehicles (K,)."""
        raise NotImplementedError

    def predict(
        self, observation_: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        """SB3's `predict`, on one observation (d,) or a batch (n, d); nothing is remembered."""
        values = np.asarray(observation_)
        actions = [
            self.world.actions.index(self.act(observation.split(row, self.world.params)))
            for row in np.atleast_2d(values)
        ]
        return (np.array(actions) if values.ndim > 1 else np.int64(actions[0])), state


@dataclass(frozen=True, kw_only=True)
class Nothing(Driver):
    """Keeps lane and speed: the denominator of every risk ratio."""

    def act(self, seen: dict[str, np.ndarray]) -> str:
        """Idle."""
        return "IDLE"


@dataclass(frozen=True, kw_only=True)
class Idm(Nothing):
    """highway-env's own driver on true states: IDM for the speed, MOBIL for the lane."""

    keywords: ClassVar[dict[str, Any]] = {"driver": "idm"}
    information: ClassVar[str | None] = "oracle"
