"""The training environment: the batch, what is recorded of its episodes, and the change of its world on the way."""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np
from stable_baselines3.common.vec_env import VecEnvWrapper

from rss_gym.params import Params
from rss_gym.sb3 import EncounterVecEnv


class TrainingVecEnv(VecEnvWrapper):
    """Rows of encounters whose episodes are numbered on through the training, whatever world they are flown in.

    Parameters
    ----------
    params : Params
        The first world.
    n_envs : int
        Number of rows.
    seed : int
        Row i has seed + i.

    Attributes
    ----------
    spent_s : float
        Wall time of the steps so far.

    Notes
    -----
    `info` of a step that ends an episode holds `episode`: its return `r` and length `l`, as SB3's monitor has them,
    `collision`, and `deviation_m`, the mean distance from the predefined trajectory while it was flown.
    """

    venv: EncounterVecEnv

    def __init__(self, params: Params, n_envs: int, seed: int) -> None:
        super().__init__(EncounterVecEnv(n_envs, params))
        self.first_seed, self.spent_s = seed, 0.0
        self._returns, self._lengths = np.zeros((2, n_envs))
        self.venv.batch.is_training = True
        self.begin(np.zeros(n_envs, np.uint64))

    @property
    def numbers(self) -> np.ndarray:
        """Number of each row's next episode, shape (n,)."""
        return self.venv.batch.numbers.copy()

    def begin(self, numbers: np.ndarray) -> None:
        """Let the rows fly these episodes after the next reset."""
        self.venv.batch.numbers[:] = numbers
        self.venv.seed(self.first_seed)
        self.venv.set_options([{"episode": int(number)} for number in numbers])

    def move(self, params: Params) -> None:
        """Change the world, which takes effect with the next reset; it must have the same spaces."""
        numbers = self.numbers
        self.venv = EncounterVecEnv(self.num_envs, params)
        self.venv.batch.is_training = True
        self.begin(numbers)

    def reset(self) -> np.ndarray:
        """Start an episode in every row; (n, d) float32."""
        for total in (self._returns, self._lengths):
            total[:] = 0.0
        return self.venv.reset()

    def step_async(self, actions: np.ndarray) -> None:
        """Take the actions, (n, axes)."""
        start = perf_counter()
        self.venv.step_async(actions)
        self.spent_s += perf_counter() - start

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Fly one decision."""
        start = perf_counter()
        observations, rewards, dones, infos = self.venv.step_wait()
        self.spent_s += perf_counter() - start
        ended = np.flatnonzero(dones)
        self._returns += rewards
        self._lengths += 1.0
        for row in ended:
            infos[row]["episode"] = {
                "r": float(self._returns[row]),
                "l": int(self._lengths[row]),
                "collision": infos[row]["collision"],
                "deviation_m": infos[row]["deviation_mean_m"],
            }
        for total in (self._returns, self._lengths):
            total[ended] = 0.0
        return observations, rewards, dones, infos
