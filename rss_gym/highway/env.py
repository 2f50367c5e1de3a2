"""The registered roads: highway-env's scenes at a pace that learning can bear, as plain environments."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec

from rss_gym.core import checked_seed
from rss_gym.highway.config import check
from rss_gym.highway.cost import Cost
from rss_gym.highway.params import RoadParams
from rss_gym.highway.plan import Plan
from rss_gym.highway.scene import SCENES, scene_class
from rss_gym.highway.wrapper import RssRanging
from rss_gym.ids import bounded
from rss_gym.params import ParamsError


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

    `params` is a `rss_gym.highway.params.RoadParams` or its dict, and any keyword of `RoadParams.of` changes it:
    `config` highway-env's configuration, `reward` the prices, the others the sensor. `rss_gym.highway.RssRanging` says
    what seeds do.

    ## Version history

    * v0: first version.
    """

    metadata = {"render_modes": ["rgb_array", "human"], "render_fps": 10}  # noqa: RUF012
    _spec: EnvSpec | None = None

    def __init__(
        self,
        scene: str | None = None,
        render_mode: str | None = None,
        params: RoadParams | Mapping[str, Any] | None = None,
        **keywords: Any,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ParamsError(f"render_mode must be one of {self.metadata['render_modes']}, got {render_mode!r}")
        self.params = RoadParams.of(params, **(keywords if scene is None else {"scene": scene, **keywords}))
        self.scene, config = SCENES[self.params.road.scene], self.params.road.config
        kind = scene_class(self.scene)
        check(config, kind.default_config())
        road = kind(config={**self.scene.configuration, **config}, render_mode=render_mode)
        self.ranging = RssRanging(road, self.params)
        self.observation_space, self.action_space = self.ranging.observation_space, self.ranging.action_space
        self.render_mode = render_mode
        self.is_training = False  # whether the traffic is compiled, and the deviation charged evenly

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
    def plan(self) -> Plan:
        """Lane and speed with which the episode began."""
        assert self.ranging.plan is not None, "no episode has begun"
        return self.ranging.plan

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
        self.ranging.is_compiled = self.is_training
        observation, info = self.ranging.reset(seed=seed, options=options)
        decisions = round(self.scene.duration_s / self.params.clock.decision_s)
        self._cost = Cost(self.params.reward, decisions if self.is_training else None)
        return observation, self._info(info, self._deviation_m())

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
        deviation_m = self._deviation_m()
        reward = self._cost.decided(deviation_m, found["snmac"], found["collision"])
        return observation, reward, terminated, truncated, self._info(found, deviation_m, terminated or truncated)

    def render(self) -> Any:
        """highway-env's picture."""
        return self.road.render()

    def close(self) -> None:
        """Close highway-env's window, if there is one."""
        self.ranging.close()

    def _deviation_m(self) -> float:
        """Distance from where the planned lane and speed would have led by now."""
        return float(np.hypot(*(self.vehicle.position - self.ranging.planned_m)))

    def _info(self, info: dict[str, Any], deviation_m: float, ended: bool = False) -> dict[str, Any]:
        plan, cost = self.plan, self._cost
        values = {
            **{name: info[name] for name in ("collision", "snmac", "zone", "min_separation_m")},
            "deviation_m": deviation_m,
            "deviation_mean_m": cost.deviation_mean_m,
            "lane_error_m": abs(plan.error_m(self.vehicle)),
            "speed_error_mps": abs(float(self.vehicle.speed) - plan.speed_mps),
            "cost_m": cost.total_m,
            **{f"reward_{name}": 0.0 - change for name, change in cost.changes.items()},
            "is_success": ended and not info["collision"],
        }
        return {name: np.array(value) for name, value in values.items()}
