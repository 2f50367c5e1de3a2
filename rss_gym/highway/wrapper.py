"""`RssRanging`: any environment of highway-env with the radio of rss_gym as its sensor."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import numpy as np

from rss_gym.core import SEED_LIMIT, SPLITS, checked_options, checked_seed
from rss_gym.highway.compiled_traffic.road import CompiledTraffic, take_over
from rss_gym.highway.config import check
from rss_gym.highway.observation import Writer
from rss_gym.highway.params import KEYWORDS, RoadParams
from rss_gym.highway.plan import Plan
from rss_gym.highway.sensor import Sensor
from rss_gym.params import ParamsError, refuse_keywords
from rss_gym.physics.random import episode_key

MADE_WITH = ("simulation_frequency", "policy_frequency", "controlled_vehicles")  # what sensor and clock rest on


class RssRanging(gym.Wrapper[np.ndarray, Any, Any, Any]):
    """Vehicles that range each other by radio: the observation becomes what a receiver of signal strength knows.

    At every step of the simulation the received signal strength of each vehicle in radio range is simulated and
    filtered by the world's own kernels, (2), (8), (12)-(21). While an estimated range is within the zone (40) the
    warning is open, and messages with the other's position and velocity come. Actions and reward stay highway-env's.

    Parameters
    ----------
    env : gymnasium.Env
        Of highway-env, with one controlled vehicle.
    params : RoadParams, optional
        Its parameters; default: those of a road of these frequencies.
    **keywords
        What differs, as `rss_gym.highway.params.RoadParams.of` takes it; scene, config and reward are highway-env's.

    Notes
    -----
    `reset(seed=s)` starts episode 0 of seed s, every later reset the next one; `reset(options={"split": "suite",
    "episode": k})` replays any. highway-env draws its traffic from a generator seeded by the episode's key: the same
    key gives the same traffic at the start and the same noise of every vehicle. Where vehicles are spawned on the way
    (intersection), whether one has room depends on the policy, and so does what is drawn after it.

    Raises
    ------
    ParamsError
        For an unknown name, with the nearest known one, or a value out of range.
    """

    def __init__(
        self,
        env: gym.Env[Any, Any],
        params: RoadParams | None = None,
        **keywords: Any,
    ) -> None:
        super().__init__(env)
        base: Any = env.unwrapped
        if not hasattr(base, "road") or not isinstance(getattr(base, "config", None), Mapping):
            raise ParamsError(f"RssRanging wraps environments of highway-env, got {type(base).__name__}")
        if base.config.get("controlled_vehicles", 1) != 1:
            raise ParamsError(f"RssRanging observes one controlled vehicle, got {base.config['controlled_vehicles']}")
        refuse_keywords(
            "RssRanging", keywords, [name for name in KEYWORDS if name not in ("scene", "config", "reward")]
        )
        frequencies = (base.config["simulation_frequency"], base.config["policy_frequency"])
        self.params = RoadParams.of(params, frequencies, **keywords)
        road = self.params.road
        self.sensor, self.driver, self.radio = Sensor(self.params, road.radio_range_m), road.driver, road.radio
        self._writer = Writer(self.params, self.radio)
        self.observation_space = gym.spaces.Box(self._writer.low, self._writer.high, dtype=np.float32)
        self.is_compiled = False  # whether the traffic is to be that of `take_over`
        self.traffic: CompiledTraffic | None = None
        self.plan: Plan | None = None
        self._seed, self._next = 0, 0  # of the episodes
        self._seeded = self._ended = False

    @property
    def base(self) -> Any:
        """The environment of highway-env."""
        return self.env.unwrapped

    @property
    def config(self) -> dict[str, Any]:
        """highway-env's configuration, as it is."""
        return dict(self.base.config)

    @property
    def road(self) -> Any:
        """highway-env's road, with its vehicles."""
        return self.base.road

    @property
    def vehicle(self) -> Any:
        """The agent's vehicle, of highway-env."""
        return self.base.vehicle

    @property
    def planned_m(self) -> np.ndarray:
        """Where the planned lane and speed would have led by now, (2,)."""
        assert self.plan is not None, "no episode has begun"
        return self.plan.position_m(self.sensor.now_s)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode; see the class for `seed` and `options`. `options["config"]` goes to highway-env.

        Raises
        ------
        ParamsError
            For a wrong seed or option, or a key of the configuration that is unknown or fixed by the making.
        """
        chosen = checked_options(options, 1, "config")
        if "config" in chosen:
            check(chosen["config"], self.base.config)
            for name in MADE_WITH:
                if name in chosen["config"]:
                    raise ParamsError(f"config[{name!r}] belongs to the environment's making; reset() cannot change it")
        if seed is not None:
            self._seed, self._next = checked_seed(seed), 0
        elif not self._seeded:
            self._seed, self._next = int(gym.utils.seeding.np_random()[0].integers(SEED_LIMIT)), 0
        self._seeded = True
        split, number = SPLITS[chosen.get("split", "train")], int(np.ravel(chosen.get("episode", self._next))[0])
        self._next = number + 1
        key = int(episode_key(split, np.uint64(self._seed), np.uint64(number)))
        inner = {"config": chosen["config"]} if "config" in chosen else None
        _, info = self.env.reset(seed=key, options=inner)
        base, self._ended = self.base, False
        self.plan = Plan(base.road, base.vehicle)
        if self.driver == "idm":
            hand_over(base, self.plan.speed_mps)
        self.sensor.start(base.road, base.vehicle, split, self._seed, number, key)
        base.road.step = functools.partial(_step, base.road, self.sensor)
        self.traffic = take_over(base, self.sensor, self.is_compiled)
        info.pop("action", None)  # a random one, of a generator without a seed
        info.pop("rewards", None)  # of that action
        return self._observe(), info | self._info()

    def step(self, action: Any) -> tuple[np.ndarray, Any, bool, bool, dict[str, Any]]:
        """Drive for one decision.

        Raises
        ------
        gymnasium.error.ResetNeeded
            Before the first reset, and after the end of an episode.
        """
        if self.plan is None or self._ended:
            raise gym.error.ResetNeeded("call reset() before step(): no episode is running")
        self.sensor.advance_slow_noise()
        _, reward, terminated, truncated, info = self.env.step(action)
        self._ended = bool(terminated or truncated)
        return self._observe(), reward, bool(terminated), bool(truncated), info | self._info()

    def _observe(self) -> np.ndarray:
        vehicle, plan = self.base.vehicle, self.plan
        assert plan is not None
        start, end, number = vehicle.lane_index
        count = len(plan.network.graph[start][end])
        along_m, offset_m = vehicle.lane.local_coordinates(vehicle.position)
        heading = vehicle.lane.heading_at(along_m)
        target = getattr(vehicle, "target_lane_index", vehicle.lane_index)
        known = {
            "speed_mps": vehicle.speed,
            "speed_error_mps": vehicle.speed - plan.speed_mps,
            "commanded_error_mps": getattr(vehicle, "target_speed", vehicle.speed) - plan.speed_mps,
            "plan_error_m": plan.error_m(vehicle),
            "plan_ahead_m": float(np.dot(vehicle.position - self.planned_m, (np.cos(heading), np.sin(heading)))),
            "lane_offset_m": offset_m,
            "lanes_left": number,
            "lanes_right": count - 1 - number,
            "changing": target[2] - number if target[:2] == (start, end) else 0,
        }
        return self._writer.write(known, (np.cos(heading), np.sin(heading)), *self.sensor.sense())

    def _info(self) -> dict[str, Any]:
        e, collision = self.sensor.episode, bool(self.base.vehicle.crashed)
        return {
            "collision": collision,
            "snmac": collision or bool(e["snmac"]),
            "zone": bool(e["zone"]),
            "min_separation_m": float(e["min_separation_m"]),
        }


def _step(road: Any, sensor: Sensor, dt: float) -> None:
    """A step of highway-env's simulation, then a tick of the radio; copies of an environment keep their own."""
    type(road).step(road, dt)
    sensor.tick(road)


def hand_over(base: Any, speed_mps: float) -> None:
    """Put highway-env's own driver into the agent's vehicle."""
    from highway_env.vehicle.behavior import IDMVehicle

    before = base.vehicle
    driver = IDMVehicle.create_from(before)
    driver.target_speed = speed_mps
    base.road.vehicles[base.road.vehicles.index(before)] = driver
    base.controlled_vehicles = [driver]
