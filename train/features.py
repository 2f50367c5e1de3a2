"""Features behind the observations, as the learner sees them."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper

from rss_gym.baselines.features import LIMIT, append, names
from rss_gym.params import Params


class Features(VecEnvWrapper):
    """Appends features of the newest observation, which the columns of `venv` end with.

    Parameters
    ----------
    venv : VecEnv
    kind : str
        One of `rss_gym.baselines.features.FEATURES`.
    world : Params
        Whose observations they are.
    """

    def __init__(self, venv: VecEnv, kind: str, world: Params) -> None:
        self.kind, self.world = kind, world
        space: Any = venv.observation_space
        limit = np.full(len(names(kind, world)), LIMIT, np.float32)
        low, high = np.concatenate([space.low, -limit]), np.concatenate([space.high, limit])
        super().__init__(venv, gym.spaces.Box(low, high, dtype=np.float32))

    def reset(self) -> np.ndarray:
        """Start an episode in every row."""
        return self._appended(self.venv.reset())

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Fly one decision."""
        observations, rewards, dones, infos = self.venv.step_wait()
        for row in np.flatnonzero(dones):
            infos[row]["terminal_observation"] = self._appended(infos[row]["terminal_observation"][None])[0]
        return self._appended(observations), rewards, dones, infos

    def _appended(self, observations: Any) -> np.ndarray:
        return append(self.kind, observations, self.world)
