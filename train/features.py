"""Features behind the observations, as the learner sees them."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper

from rss_gym import observation
from rss_gym.baselines.features import FEATURES, LIMIT, append, names
from rss_gym.baselines.features.masks import kept
from rss_gym.params import Params


class Features(VecEnvWrapper):
    """Appends features of the newest observation, which the columns of `venv` end with.

    Parameters
    ----------
    venv : VecEnv
    kind : str
        One of `rss_gym.baselines.features.FEATURES`.
    zeroed : str
        Fields that the learner goes without, one of `rss_gym.baselines.features.masks.MASKS`.
    world : Params
        Whose observations they are.
    """

    def __init__(self, venv: VecEnv, kind: str, world: Params, zeroed: str = "nothing") -> None:
        self.features = FEATURES[kind](world)
        space: Any = venv.observation_space
        limit = np.full(len(names(kind, world)), LIMIT, np.float32)
        low, high = np.concatenate([space.low, -limit]), np.concatenate([space.high, limit])
        self._kept = kept(zeroed, world, space.shape[0] // len(observation.fields(world)))
        self._memory = np.zeros((venv.num_envs, self.features.columns))
        super().__init__(venv, gym.spaces.Box(low, high, dtype=np.float32))

    def reset(self) -> np.ndarray:
        """Start an episode in every row."""
        self._memory[:] = 0.0
        return self._told(np.asarray(self.venv.reset()), self._memory)

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Fly one decision."""
        observations, rewards, dones, infos = self.venv.step_wait()
        ended = np.flatnonzero(dones)
        if len(ended):
            last = np.stack([infos[row]["terminal_observation"] for row in ended])
            for row, seen in zip(ended, self._told(last, self._memory[ended]), strict=True):
                infos[row]["terminal_observation"] = seen
        self._memory[ended] = 0.0
        return self._told(np.asarray(observations), self._memory), rewards, dones, infos

    def _told(self, observations: np.ndarray, memory: np.ndarray) -> np.ndarray:
        return append(self.features, observations * self._kept, memory)
