"""The base of the scripted drivers, and the two that do not look at the observation."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rss_gym.baselines.policy import Scripted
from rss_gym.highway.observation import split
from rss_gym.highway.params import RoadParams, actions
from rss_gym.params import Params, ParamsError


@dataclass(frozen=True, kw_only=True)
class Driver(Scripted):
    """Base of the scripted drivers, which remember nothing: a subclass writes `choose`."""

    params: RoadParams = field(default_factory=RoadParams.of)

    def choose(self, seen: dict[str, np.ndarray]) -> str:
        """Name of the action for one observation in SI units, own fields (), those of the vehicles (K,)."""
        raise NotImplementedError

    def predict(
        self, observation_: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        """SB3's `predict`, on one observation (d,) or a batch (n, d)."""
        values, names = np.asarray(observation_), actions(self.params)
        if not names:
            raise ParamsError(f"drivers choose highway-env's meta-actions, got {self.params.road.config['action']!r}")
        chosen = [names.index(self.choose(split(row, self.params))) for row in np.atleast_2d(values)]
        return (np.array(chosen) if values.ndim > 1 else np.int64(chosen[0])), state


@dataclass(frozen=True, kw_only=True)
class Nothing(Driver):
    """Keeps lane and speed: the denominator of every risk ratio."""

    def choose(self, seen: dict[str, np.ndarray]) -> str:
        """Idle."""
        return "IDLE"


@dataclass(frozen=True, kw_only=True)
class Idm(Nothing):
    """highway-env's own driver on true states: IDM for the speed, MOBIL for the lane."""

    @classmethod
    def home(cls, params: Params) -> Params:
        """The road with that driver in the agent's vehicle."""
        return Params.of(params, driver="idm", information="oracle")
