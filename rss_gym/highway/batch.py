"""Drives side by side: the rows of `RoadEnv` behind the interface of the air's batch."""

from __future__ import annotations

from functools import cache
from typing import Any

import gymnasium as gym
import numpy as np

from rss_gym import state
from rss_gym.core import SPLITS, BaseBatch, decode_discrete
from rss_gym.highway import observation
from rss_gym.highway.env import RoadEnv
from rss_gym.highway.params import RoadParams, actions

# The episode's record, and what only a road has: means over the decisions driven.
EPISODE = np.dtype([*state.EPISODE.descr, ("lane_deviation_m", "<f8"), ("speed_deviation_mps", "<f8")])
_SPLITS = list(SPLITS)


class RoadBatch(BaseBatch):
    """n drives side by side, one environment of highway-env each.

    Parameters
    ----------
    params : RoadParams
    n : int
        Number of rows.

    Attributes
    ----------
    environments : list of RoadEnv
    """

    def __init__(self, params: RoadParams, n: int) -> None:
        super().__init__(params, n, len(observation.fields(params)))
        self.environments = [RoadEnv(params=params) for _ in range(n)]
        self.episode = np.zeros(n, EPISODE)
        self._errors: list[list[tuple[float, float]]] = [[] for _ in range(n)]  # off lane and speed, a decision each
        self._moved = np.zeros(n, bool)  # in the last decision

    def reset(self, mask: np.ndarray) -> None:
        """Start the next episode in the rows of `mask`, shape (n,)."""
        for row in np.flatnonzero(mask).tolist():
            self.environments[row].is_training = self.is_training
            number = int(self.numbers[row])
            options = {"split": _SPLITS[self.split[row]], "episode": number}
            self.observations[row], info = self.environments[row].reset(seed=int(self.seeds[row]), options=options)
            self.numbers[row], self.rewards[row] = number + 1, 0.0
            self._errors[row].clear()
            self.episode[row] = np.zeros(1, EPISODE)[0]
            self._write(row, info)
        self.started |= mask
        self._moved = mask.copy()

    def step(self, actions: np.ndarray, mask: np.ndarray) -> None:
        """Drive for one decision in the rows of `mask`."""
        for row in np.flatnonzero(mask).tolist():
            env, e = self.environments[row], self.episode[row]
            before = env.vehicle.position.copy()
            self.observations[row], self.rewards[row], terminated, truncated, info = env.step(actions[row])
            e["terminated"], e["truncated"] = terminated, truncated
            e["flown_m"] += np.hypot(*(env.vehicle.position - before))
            e["deviation_max_m"] = max(e["deviation_max_m"], info["deviation_m"])
            self._errors[row].append((info["lane_error_m"], info["speed_error_mps"]))
            e["lane_deviation_m"], e["speed_deviation_mps"] = (
                np.mean(part) for part in zip(*self._errors[row], strict=True)
            )
            self._write(row, info)
        self._moved = mask.copy()

    def _write(self, row: int, info: dict[str, Any]) -> None:
        """The episode's record: what the sensor has of it, and what the decision came to."""
        env, e = self.environments[row], self.episode[row]
        sensed = env.ranging.sensor.episode
        for name in ("seed", "number", "split", "key", "channel", "tick", "zone", "min_separation_m", "closest_s"):
            e[name] = sensed[name]
        for name in ("warned_s", "false_alerts", "missed"):
            e[name] = sensed[name]
        for name in info:
            if name in (state.EPISODE.names or ()):
                e[name] = info[name]
        # A drive ends with the time, at the end of the road or on arrival; a collision ends it before its time.
        ended = (e["terminated"] or e["truncated"]) and not e["collision"]
        duration = round(env.scene.duration_s / self.params.clock.tick_s)
        e["ticks"] = e["tick"] if ended else max(duration, e["tick"])

    @property
    def positions_m(self) -> np.ndarray:
        """The agents' positions (n, 2); NaN in rows that the last step left out: drives end at times of their own."""
        positions = np.array([env.vehicle.position for env in self.environments])
        positions[~self._moved] = np.nan
        return positions

    @property
    def planned_mps(self) -> np.ndarray:
        """The agents' planned speeds, shape (n,)."""
        return np.array([env.plan.speed_mps for env in self.environments])

    def sample(self) -> tuple[np.ndarray, np.ndarray]:
        """True and estimated range of the nearest vehicle that is heard, shape (n,) each; zeros without one."""
        found = np.zeros((2, self.n))
        for row, env in enumerate(self.environments):
            vehicles = env.ranging.sensor.vehicles
            gap = vehicles["position_m"][1:] - vehicles["position_m"][0]
            separation_m = np.where(vehicles["heard"][1:], np.hypot(gap[:, 0], gap[:, 1]), np.inf)
            if np.isfinite(separation_m).any():
                nearest = int(np.argmin(separation_m))
                found[:, row] = separation_m[nearest], env.ranging.sensor.range_m[nearest]
        return found[0], found[1]


@cache
def action_space(params: RoadParams) -> gym.Space[Any]:
    """highway-env's, of one environment."""
    names = actions(params)
    return gym.spaces.Discrete(len(names)) if names else RoadEnv(params=params).action_space


def decode(values: Any, params: RoadParams, n: int) -> np.ndarray:
    """The policy's actions, one a row.

    Raises
    ------
    ValueError, TypeError
        If one is not in the action space.
    """
    found, space = np.asarray(values), action_space(params)
    if isinstance(space, gym.spaces.Discrete):
        return decode_discrete(found, int(space.n), n)
    wrong = [row for row in found if not space.contains(row)] if found.ndim and len(found) == n else [found]
    if wrong:
        raise ValueError(f"actions must be {n} of {space}, got {wrong[0]!r}")
    return found
