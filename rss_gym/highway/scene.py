"""The roads: highway-env's scenes at a pace that learning can bear."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rss_gym.params import ParamsError

EXTRA = "the roads need highway-env, which is not installed: pip install -e '.[highway]' in the clone"


@dataclass(frozen=True)
class Scene:
    """A road of highway-env.

    Parameters
    ----------
    module, name : str
        Where its class is: the module, and the name in it.
    summary : str
    speed_relative_max_mps : float
        |v| of (40): how fast two vehicles of this road can close.
    duration_s : float
        The length of an episode that no collision and no arrival ends earlier.
    config : dict
        What differs from highway-env's own configuration.
    """

    module: str
    name: str
    summary: str
    speed_relative_max_mps: float
    duration_s: float
    config: Mapping[str, Any]

    @property
    def is_timed(self) -> bool:
        """Whether the duration of the configuration ends an episode."""
        return "duration" in self.config

    @property
    def zone(self) -> dict[str, Any]:
        """What the safety zone of this road has of its own."""
        return {"speed_relative_max_mps": self.speed_relative_max_mps}

    @property
    def configuration(self) -> dict[str, Any]:
        """As highway-env takes it."""
        return {**COMMON, **self.config}


# highway-env makes 2 to 40 steps a second with its defaults. Ten ticks a second are the world's own rate of the radio;
# of highway-env's observation, which nobody sees, only the time is computed.
COMMON: Mapping[str, Any] = {
    "simulation_frequency": 10,
    "policy_frequency": 1,
    "observation": {"type": "AttributesObservation", "attributes": ["time"]},
    "neighbour_vehicles_connected_lanes": True,
}
SCENES: dict[str, Scene] = {
    "highway": Scene(
        "highway_env.envs.highway_env",
        "HighwayEnvFast",
        "three lanes, ten vehicles ahead that drive at 21-24 m/s, the agent at 25 m/s",
        10.0,
        20.0,
        {"lanes_count": 3, "vehicles_count": 10, "duration": 20},
    ),
    "merge": Scene(
        "highway_env.envs.merge_env",
        "MergeEnv",
        "two lanes and a ramp, from which a vehicle merges in front of the agent at 30 m/s",
        12.0,
        12.0,
        {},
    ),
    "intersection": Scene(
        "highway_env.envs.intersection_env",
        "IntersectionEnv",
        "a crossing of two roads; the agent keeps its way at 9 m/s, or brakes",
        19.0,
        13.0,
        {"duration": 13, "other_vehicles_type": "rss_gym.highway.traffic.CrossingVehicle"},
    ),
}


def scene_class(scene: Scene) -> Any:
    """highway-env's class of a scene.

    Raises
    ------
    ParamsError
        Naming the extra to install, where highway-env is missing.
    """
    try:
        return getattr(importlib.import_module(scene.module), scene.name)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "highway_env":
            raise
        raise ParamsError(EXTRA) from error
