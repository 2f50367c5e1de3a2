"""The registered roads: highway-env's scenes at a pace that learning can bear, as plain environments."""

from __future__ import annotations

import importlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec

from rss_gym.core import checked_seed
from rss_gym.highway.config import check
from rss_gym.highway.cost import Cost
from rss_gym.highway.settings import mapping, prices
from rss_gym.highway.wrapper import RssRanging
from rss_gym.ids import bounded
from rss_gym.params import ParamsError, Zone, refuse_keywords, suggestion

EXTRA = 'the roads need highway-env, which is not installed: pip install "rss-gym[highway]"'


@dataclass(frozen=True)
class Scene:
    """A road of highway-env.

    Parameters
    ----------
    module, name : str
        Of its class.
    summary : str
    speed_relative_max_mps : float
        |v| of (40): how fast two vehicles of this road can close.
    duration_s : float
        Of an episode that no collision and no arrival ends earlier.
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


class RoadEnv(gym.Env[np.ndarray, Any]):
    """A vehicle on a road of highway-env that ranges the others by radio signal strength.

    ## Description

    The agent has a lane and a speed to keep and vehicles to give way to. What it knows of them is what the radio tells,
    as in `rss_gym/Encounter-v0`: ranges by the augmented Kalman filter of received signal strength, and positions and
    velocities by messages while the warning of the safety zone is open. Own lane, speed and plan are known.

    ## Action space

    highway-env's meta-actions: on `Highway` and `Merge` `Discrete(5)`: lane left, idle, lane right, faster, slower; on
    `Intersection` `Discrete(3)`: slower, idle, faster. Another action of highway-env can be configured.

    ## Observation space

    A flat `Box` of named fields, float32; `rss_gym.highway.observation.fields(env.unwrapped.params)` is the table, and
    `split` there the way back to SI units.

    ## Rewards

    Minus what the cost of the drive rises by, so that the undiscounted return is minus `info["cost_m"]` at the end. The
    cost is in metres, as in the air: the mean over the decisions of the distance from where the planned lane and speed
    would have led by then (behind, ahead and beside), `deviation_mean_m`, plus 100 m for a near miss and 10,000 m for a
    collision, which is a near miss too. The near miss takes the place of the air's sNMAC, with its name: at a tick a
    vehicle would touch the agent within 1.5 s if both went straight on. `info` has the terms of the last decision,
    `reward_deviation`, `reward_snmac` and `reward_collision`.

    ## Episode end

    As in highway-env: a collision, the end of the time (`Highway`, `Intersection`), of the road (`Merge`), or arrival.

    ## Arguments

    `config` changes highway-env's configuration, `reward` the prices (`deviation_price`, `snmac_price_m`,
    `collision_price_m`); all else is as for
    `rss_gym.highway.RssRanging`, which has also what seeds do.
    """

    metadata = {"render_modes": ["rgb_array", "human"], "render_fps": 10}  # noqa: RUF012
    _spec: EnvSpec | None = None

    def __init__(
        self,
        scene: str = "highway",
        config: Mapping[str, Any] | None = None,
        reward: Mapping[str, Any] | None = None,
        render_mode: str | None = None,
        zone: Zone | Mapping[str, Any] | None = None,
        **keywords: Any,
    ) -> None:
        if scene not in SCENES:
            raise ParamsError(f"scene {scene!r} is unknown{suggestion(str(scene), SCENES)}")
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ParamsError(f"render_mode must be one of {self.metadata['render_modes']}, got {render_mode!r}")
        known = set(RssRanging.__init__.__annotations__) - {"env", "return"}
        refuse_keywords("a road", keywords, {*known, "config", "reward"})
        self.scene = SCENES[scene]
        kind = scene_class(self.scene)
        changes = {} if config is None else config
        check(changes, kind.default_config())
        priced = prices(reward)
        if not isinstance(zone, Zone):
            zone = {**self.scene.zone, **mapping("zone", {} if zone is None else zone)}
        road = kind(config={**self.scene.configuration, **changes}, render_mode=render_mode)
        self.ranging = RssRanging(road, zone=zone, **keywords)
        self.params = self.ranging.params.replace(reward=priced)
        self.observation_space, self.action_space = self.ranging.observation_space, self.ranging.action_space
        self.render_mode = render_mode

    @property
    def spec(self) -> EnvSpec | None:
        """What `gymnasium.make` made this of; where the road has a duration, no episode exceeds `max_episode_steps`."""
        return self._spec

    @spec.setter
    def spec(self, value: EnvSpec | None) -> None:
        config = self.road.config
        longest = config["duration"] * config["policy_frequency"] if self.scene.is_timed else None
        self._spec = value if longest is None else bounded(value, math.ceil(longest))

    @property
    def road(self) -> Any:
        """highway-env's own environment."""
        return self.ranging.base

    @property
    def config(self) -> dict[str, Any]:
        """highway-env's configuration of the road, as it is."""
        return dict(self.road.config)

    @property
    def vehicle(self) -> Any:
        """The agent's vehicle, of highway-env."""
        return self.road.vehicle

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode; see `RssRanging` for `seed` and `options`."""
        seed = None if seed is None else checked_seed(seed)
        super().reset(seed=seed)
        if seed is None and self.ranging.plan is None:
            seed = int(self.np_random.integers(2**62))
        observation, info = self.ranging.reset(seed=seed, options=options)
        self._cost = Cost(self.params.reward)
        return observation, self._info(info)

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Drive for one decision.

        Raises
        ------
        gymnasium.error.ResetNeeded
            Before the first reset, and after the end of an episode.
        ValueError
            For an action that is not in the space.
        """
        if not self.action_space.contains(action):
            raise ValueError(f"action must be in {self.action_space}, got {action!r}")
        observation, _, terminated, truncated, found = self.ranging.step(action)
        reward = self._cost.decided(self._deviation_m(), found["snmac"], found["collision"])
        return observation, reward, terminated, truncated, self._info(found, terminated or truncated)

    def render(self) -> Any:
        """highway-env's picture."""
        return self.road.render()

    def close(self) -> None:
        """Close highway-env's window, if there is one."""
        self.ranging.close()

    def _deviation_m(self) -> float:
        """Distance from where the planned lane and speed would have led by now."""
        plan, ticks = self.ranging.plan, float(self.ranging.sensor.episode["tick"])
        assert plan is not None
        return float(np.hypot(*(self.vehicle.position - plan.position_m(ticks * self.params.clock.tick_s))))

    def _info(self, info: dict[str, Any], ended: bool = False) -> dict[str, Any]:
        plan, cost = self.ranging.plan, self._cost
        assert plan is not None
        values = {
            **{name: info[name] for name in ("collision", "snmac", "zone", "min_separation_m")},
            "deviation_m": self._deviation_m(),
            "deviation_mean_m": cost.deviation_mean_m,
            "lane_error_m": abs(plan.error_m(self.vehicle)),
            "speed_error_mps": abs(float(self.vehicle.speed) - plan.speed_mps),
            "cost_m": cost.total_m,
            **{f"reward_{name}": 0.0 - change for name, change in cost.changes.items()},
            "is_success": ended and not info["collision"],
        }
        return {name: np.array(value) for name, value in values.items()}


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
