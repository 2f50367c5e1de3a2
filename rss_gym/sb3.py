"""The batch as a `VecEnv` of Stable-Baselines3: `make_vec_env("rss_gym/Encounter-v0", n_envs=256, seed=0)`.

Needs the extra `train`; nothing else imports this module.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import gymnasium as gym
import numpy as np

from rss_gym.core import INFO, SEED_LIMIT, Batch, checked_options, checked_seed, decode, spaces
from rss_gym.ids import IDS
from rss_gym.params import Params, ParamsError, suggestion
from rss_gym.render.painter import RENDER_FPS, Painter

try:
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as error:
    raise ImportError("rss_gym.sb3 needs Stable-Baselines3: pip install 'rss-gym[train]'") from error

_INFO = (*INFO, "is_success")


def make_vec_env(id: str, n_envs: int = 256, seed: int | None = None, **keywords: Any) -> EncounterVecEnv:
    """A `VecEnv` of `n_envs` encounters on one batch.

    Parameters
    ----------
    id : str
        A registered id, such as `rss_gym/Encounter-v0`.
    n_envs : int
        Number of rows, at least 1.
    seed : int, optional
        Row i gets seed + i at its first reset, as in `gymnasium.make_vec`; None draws them.
    **keywords
        As in `gymnasium.make`: `params`, `render_mode`, any field of the parameters; and `every_info` of the class.

    Raises
    ------
    ParamsError
        For an unknown id or parameter.
    """
    if id not in IDS:
        raise ParamsError(f"environment {id!r} is unknown{suggestion(str(id), IDS)}")
    environment = EncounterVecEnv(n_envs, **{**IDS[id], **keywords})
    if seed is not None:
        environment.seed(checked_seed(seed))
    return environment


class EnvRow:
    """One environment of the batch, as `get_attr`, `set_attr` and `env_method` address it."""

    def __init__(self, owner: EncounterVecEnv, index: int) -> None:
        """Row `index` of `owner`."""
        self._owner, self._index = owner, index
        self.params, self.render_mode = owner.params, owner.painter.mode
        self.observation_space, self.action_space = owner.observation_space, owner.action_space
        self.spec: Any = None

    def info(self) -> dict[str, Any]:
        """What `info` of a step holds, of the episode that runs."""
        return {name: self._owner.batch.info(name)[self._index].item() for name in _INFO}

    def render(self) -> Any:
        """The row's frame (H, W, 3), or None without a render mode."""
        frames = self._owner.painter.render_all(self._owner.batch)
        return None if frames is None else frames[self._index]


class EncounterVecEnv(VecEnv):
    """Encounters side by side, equal bit for bit to the Gymnasium vector environment in mode `SameStep`.

    Parameters
    ----------
    n_envs : int
        Number of rows.
    params, render_mode, **keywords
        As in `rss_gym.env.EncounterEnv`; render mode `rgb_array` or None.
    every_info : bool
        Fill `infos` of every row at every step. By default only the rows that end have them, which is what monitors
        and learners read; a dictionary a row and step costs more than the step.

    Notes
    -----
    A row that ends is reset in the same step; its info holds `terminal_observation`, taken before the reset, and
    `TimeLimit.truncated`, true where the clock ran out without a collision.
    """

    def __init__(
        self,
        n_envs: int = 256,
        params: Params | dict[str, Any] | None = None,
        render_mode: str | None = None,
        every_info: bool = False,
        **keywords: Any,
    ) -> None:
        if isinstance(n_envs, bool) or not isinstance(n_envs, (int, np.integer)) or n_envs < 1:
            raise ParamsError(f"n_envs must be a whole number >= 1, got {n_envs!r}")
        self.params, self.every_info = Params.of(params, **keywords), every_info
        self.batch = Batch(self.params, int(n_envs))
        self.painter = Painter(render_mode, {"render_modes": ["rgb_array"]}, int(n_envs))
        self.observation_space, self.action_space = spaces(self.params)
        self.rows = [EnvRow(self, index) for index in range(int(n_envs))]
        super().__init__(int(n_envs), self.observation_space, self.action_space)
        self.metadata: dict[str, Any] = {**self.metadata, "render_fps": RENDER_FPS}
        self._none, self._all = np.zeros(self.num_envs, bool), np.ones(self.num_envs, bool)
        self._actions: np.ndarray | None = None

    def reset(self) -> np.ndarray:
        """Start an episode in every row, with the seeds and options set since the last reset; (n, d) float32."""
        fresh = np.array([seed is None for seed in self._seeds]) & ~self.batch.started
        if fresh.any():
            # Unseeded, as SB3 does: NumPy's global generator, which `set_random_seed` fixes.
            self.batch.seed(np.random.randint(0, SEED_LIMIT, int(fresh.sum())).astype(np.uint64), fresh)  # noqa: NPY002
        for index, (seed, options) in enumerate(zip(self._seeds, self._options, strict=True)):
            row = slice(index, index + 1)
            if seed is not None:
                self.batch.seed(np.array([checked_seed(seed)], np.uint64), row)
            if options:
                mask = self._none.copy()
                mask[row] = True
                self.batch.apply_options(checked_options(options, 1), mask)
        self._reset_seeds()
        self._reset_options()
        self._actions = None
        self.batch.reset(self._all)
        self.painter.restart(self.batch, self._all)
        self.reset_infos = self._infos(self._all)
        return self.batch.observations.copy()

    def step_async(self, actions: np.ndarray) -> None:
        """Take the actions, (n, axes), that `step_wait` will fly.

        Raises
        ------
        ValueError, TypeError
            For actions of the wrong shape or type, or non-finite ones.
        gymnasium.error.ResetNeeded
            Before the first reset.
        """
        if not self.batch.started.all():
            raise gym.error.ResetNeeded("call reset() before step(): no episode is running")
        self._actions = decode(actions, self.params, self.num_envs)

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Fly one decision: observations (n, d), rewards (n,) float32, dones (n,), infos."""
        if self._actions is None:
            raise gym.error.ResetNeeded("call step_async() before step_wait()")
        batch, episode = self.batch, self.batch.episode
        batch.step(self._actions, self._all)
        self._actions = None
        self.painter.follow(batch, self._all)
        rewards = batch.rewards.astype(np.float32)
        terminated, truncated = episode["terminated"].copy(), episode["truncated"].copy()
        dones = terminated | truncated
        infos = self._infos(self._all if self.every_info else dones)
        if dones.any():
            for row in np.flatnonzero(dones):
                infos[row]["terminal_observation"] = batch.observations[row].copy()
                infos[row]["TimeLimit.truncated"] = bool(truncated[row] and not terminated[row])
            batch.reset(dones)
            self.painter.restart(batch, dones)
        return batch.observations.copy(), rewards, dones, infos

    def close(self) -> None:
        """Close what rendering holds."""
        self.painter.close()

    def get_images(self) -> Sequence[np.ndarray | None]:
        """One frame (H, W, 3) a row, or None without a render mode."""
        return self.painter.render_all(self.batch) or [None] * self.num_envs

    def get_attr(self, attr_name: str, indices: int | Iterable[int] | None = None) -> list[Any]:
        """An attribute of each of the chosen rows; `params` is the world's."""
        return [getattr(self.rows[index], attr_name) for index in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: int | Iterable[int] | None = None) -> None:
        """Set an attribute of the chosen rows.

        Raises
        ------
        ParamsError
            For `params`: rows share one world, so another one needs another environment.
        """
        if attr_name == "params":
            raise ParamsError("params of a running environment cannot be set; make another one with the new params")
        for index in self._get_indices(indices):
            setattr(self.rows[index], attr_name, value)

    def env_method(
        self, method_name: str, *arguments: Any, indices: int | Iterable[int] | None = None, **keywords: Any
    ) -> list[Any]:
        """Call a method of each of the chosen rows, such as `info`."""
        return [getattr(self.rows[index], method_name)(*arguments, **keywords) for index in self._get_indices(indices)]

    def env_is_wrapped(
        self, wrapper_class: type[gym.Wrapper[Any, Any, Any, Any]], indices: int | Iterable[int] | None = None
    ) -> list[bool]:
        """No row is wrapped."""
        return [False for _ in self._get_indices(indices)]

    def _infos(self, mask: np.ndarray) -> list[dict[str, Any]]:
        """A dictionary of its own for each row, as wrappers write into them; empty outside `mask`."""
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        if mask.any():
            columns = {name: self.batch.info(name)[mask].tolist() for name in _INFO}
            for position, row in enumerate(np.flatnonzero(mask)):
                infos[row] = {name: values[position] for name, values in columns.items()}
        return infos
