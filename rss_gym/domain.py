"""The two domains, air and road, behind one protocol: what an evaluator or a trainer has to know of a world.

A world is its parameters: `domain_of(params)` says whose they are. The suites of both are in `rss_gym.eval.suites`, the
policies in `rss_gym.baselines` (`policies(params)`), the recipes in `rss_gym.train`; `rss_gym.eval.table` has the
columns of each, `rss_gym.eval.metrics` the scores.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import gymnasium as gym
import numpy as np

from rss_gym import core, encounters, observation
from rss_gym.highway import batch as road_batch
from rss_gym.highway import observation as road_observation
from rss_gym.highway.params import RoadParams
from rss_gym.highway.scene import SCENES
from rss_gym.ids import IDS, ROADS
from rss_gym.params import Params

WORLD_VERSION, ROAD_VERSION = 0, 0  # raised whenever the same parameters give other numbers


class Domain(Protocol):
    """A kind of world."""

    name: str
    ids: Mapping[str, Mapping[str, Any]]  # registered id -> the keywords that set it apart
    packages: tuple[str, ...]  # that the numbers depend on beside those of every world

    def params(self, keywords: Mapping[str, Any]) -> Params:
        """The parameters that these keywords of an environment set."""
        ...

    def commanded(self, params: Params) -> Params:
        """The same world with the actions that the policies of the package command."""
        ...

    def families(self, params: Params) -> list[str]:
        """Names of what episodes are drawn from; the episode table holds indices into this list."""
        ...

    def definition(self, params: Params) -> dict[str, Any]:
        """What decides the episodes beside the parameters, in plain JSON types."""
        ...

    def fields(self, params: Params) -> list[observation.Field]:
        """The table of the observation."""
        ...

    def spaces(self, params: Params) -> tuple[gym.spaces.Box, gym.Space[Any]]:
        """Observation and action space of one environment."""
        ...

    def decode(self, actions: Any, params: Params, n: int) -> np.ndarray:
        """The actions that a policy has returned for n rows as `step` takes them; refuses all else."""
        ...

    def make_batch(self, params: Params, n: int) -> core.BaseBatch:
        """N environments side by side."""
        ...


class Air:
    """Encounters of aircraft."""

    name = "air"
    ids: Mapping[str, Mapping[str, Any]] = IDS
    packages: tuple[str, ...] = ()

    params: Any = staticmethod(lambda keywords: Params.of(**keywords))
    commanded: Any = staticmethod(lambda params: Params.of(params, action="velocity"))
    families: Any = staticmethod(lambda params: encounters.chosen(params.encounter))
    fields: Any = staticmethod(observation.fields)
    spaces: Any = staticmethod(core.spaces)
    decode: Any = staticmethod(core.decode)
    make_batch: Any = staticmethod(core.Batch)

    def definition(self, params: Params) -> dict[str, Any]:
        """Version of the world, and the families."""
        families = {name: encounters.FAMILIES[name].definition for name in self.families(params)}
        return {"world_version": WORLD_VERSION, "families": families}


class Road:
    """Drives on the roads of highway-env, extra `highway`."""

    name = "road"
    ids: Mapping[str, Mapping[str, Any]] = ROADS
    packages: tuple[str, ...] = ("highway-env",)

    params: Any = staticmethod(lambda keywords: RoadParams.of(**keywords))
    commanded: Any = staticmethod(lambda params: params)
    families: Any = staticmethod(lambda params: [params.road.scene])
    fields: Any = staticmethod(road_observation.fields)
    decode: Any = staticmethod(road_batch.decode)
    make_batch: Any = staticmethod(road_batch.RoadBatch)

    def definition(self, params: Any) -> dict[str, Any]:
        """Version of the roads, and the scene."""
        config = params.road.configuration
        return {"road_version": ROAD_VERSION, "scene": SCENES[params.road.scene].name, "config": config}

    def spaces(self, params: Any) -> tuple[gym.spaces.Box, gym.Space[Any]]:
        """Observation and action space of one environment."""
        low, high = (np.array([getattr(f, end) for f in self.fields(params)], np.float32) for end in ("low", "high"))
        return gym.spaces.Box(low, high, dtype=np.float32), road_batch.action_space(params)


AIR: Domain = Air()
ROAD: Domain = Road()


def domain_of(params: Params) -> Domain:
    """The domain of a world."""
    return ROAD if isinstance(params, RoadParams) else AIR


def domain_of_id(name: str) -> Domain:
    """The domain of a registered id."""
    return ROAD if name in ROADS else AIR


def from_dict(table: Mapping[str, Any]) -> Params:
    """The parameters that `to_dict` wrote, of whichever domain."""
    return (RoadParams if "road" in table else Params).from_dict(table)
