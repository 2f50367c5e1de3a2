"""Observations without some of their fields, as the learner sees them."""

from __future__ import annotations

from typing import Any

import numpy as np
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper

from rss_gym.baselines.masks import kept
from rss_gym.domain import domain_of
from rss_gym.params import Params


class Masked(VecEnvWrapper):
    """Sets fields of every observation to zero.

    Parameters
    ----------
    venv : VecEnv
    zeroed : str
        Fields that the learner goes without, one of `rss_gym.baselines.masks.MASKS`.
    params : Params
        Whose observations they are, one or several side by side.
    """

    def __init__(self, venv: VecEnv, zeroed: str, params: Params) -> None:
        super().__init__(venv)
        width: Any = venv.observation_space.shape
        self.kept = kept(zeroed, params, width[0] // len(domain_of(params).fields(params)))

    def reset(self) -> np.ndarray:
        """Start an episode in every row."""
        return np.asarray(self.venv.reset()) * self.kept

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Fly one decision."""
        observations, rewards, dones, infos = self.venv.step_wait()
        for row in np.flatnonzero(dones):
            infos[row]["terminal_observation"] = infos[row]["terminal_observation"] * self.kept
        return np.asarray(observations) * self.kept, rewards, dones, infos
