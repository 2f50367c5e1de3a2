"""The vector environment: a thin shell round a batch of n, row for row equal to n single environments."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from rss_gym.core import INFO, SEED_LIMIT, Batch, checked_options, checked_seed, decode, is_row_list, spaces
from rss_gym.params import Params, ParamsError, suggestion
from rss_gym.render.painter import RENDER_FPS, Painter

_MODES = {mode.value: mode for mode in AutoresetMode}


class EncounterVectorEnv(gym.vector.VectorEnv[np.ndarray, Any, np.ndarray]):
    """`num_envs` encounters side by side; see `rss_gym.env.EncounterEnv` for one of them.

    Row i of a reset with seed s is the single environment reset with seed s + i, bit for bit, through automatic resets.

    Parameters
    ----------
    num_envs : int
        Number of rows, at least 1.
    autoreset_mode : str or AutoresetMode
        `NextStep` (default: the step after the end resets, its action ignored, reward 0), `SameStep` (the last
        observation and info are in `infos["final_obs"]`, `infos["final_info"]`) or `Disabled` (rows are reset by
        `reset(options={"reset_mask": mask})`).
    params, render_mode, **keywords
        As in the single environment; `render` returns one frame a row.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": RENDER_FPS}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        params: Params | dict[str, Any] | None = None,
        render_mode: str | None = None,
        **keywords: Any,
    ):
        if isinstance(num_envs, bool) or not isinstance(num_envs, (int, np.integer)) or num_envs < 1:
            raise ParamsError(f"num_envs must be a whole number >= 1, got {num_envs!r}")
        if not isinstance(autoreset_mode, AutoresetMode):
            if autoreset_mode not in _MODES:
                raise ParamsError(
                    f"autoreset_mode {autoreset_mode!r} is unknown{suggestion(str(autoreset_mode), _MODES)}"
                )
            autoreset_mode = _MODES[autoreset_mode]
        self.autoreset_mode = autoreset_mode
        self.metadata = type(self).metadata | {"autoreset_mode": autoreset_mode}
        self.params, self.num_envs = Params.of(params, **keywords), int(num_envs)
        self.batch = Batch(self.params, self.num_envs)
        self.single_observation_space, self.single_action_space = spaces(self.params)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.painter = Painter(render_mode, self.metadata, self.num_envs)
        self.render_mode = render_mode
        self._all = np.ones(self.num_envs, bool)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode in every row, or in those of `options["reset_mask"]`, a bool array of `num_envs`.

        `seed` s gives row i the seed s + i; a list gives each row its own, None going on with the row's episodes.
        """
        chosen = checked_options(options, self.num_envs, "reset_mask")
        mask, seeds = self._mask(chosen), self._seeds(seed)
        if seed is None or isinstance(seed, (int, np.integer)):
            super().reset(seed=None if seed is None else checked_seed(seed))
        for row, value in enumerate(seeds):
            if mask[row] and value is not None:
                self.batch.seed(np.array([value], np.uint64), slice(row, row + 1))
        fresh = mask & ~self.batch.started & np.array([value is None for value in seeds])
        if fresh.any():
            self.batch.seed(self.np_random.integers(SEED_LIMIT, size=int(fresh.sum())).astype(np.uint64), fresh)
        self.batch.apply_options(chosen, mask)
        self.batch.reset(mask)
        self.painter.restart(self.batch, mask)
        return self.batch.observations.copy(), self._infos(mask)

    def step(self, actions: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Fly one decision in every row.

        Raises
        ------
        gymnasium.error.ResetNeeded
            Before the first reset; in mode `Disabled` also when a row has ended and was not reset.
        ValueError, TypeError
            For actions of the wrong shape or type, or non-finite ones.
        """
        batch, episode = self.batch, self.batch.episode
        if not batch.started.all():
            raise gym.error.ResetNeeded("call reset() before step(): no episode is running")
        ended = episode["terminated"] | episode["truncated"]
        if self.autoreset_mode is AutoresetMode.DISABLED and ended.any():
            raise gym.error.ResetNeeded(
                f"row {np.flatnonzero(ended)[0]} has ended; reset it with reset(options={{'reset_mask': mask}})"
            )
        batch.step(decode(actions, self.params, self.num_envs), ~ended)
        if ended.any():  # only in NEXT_STEP: the other modes never leave an ended row behind
            batch.reset(ended)
            self.painter.restart(batch, ended)
        self.painter.follow(batch, ~ended)
        rewards = batch.rewards.copy()
        terminated, truncated = episode["terminated"].copy(), episode["truncated"].copy()
        infos: dict[str, Any] = {}
        ended = terminated | truncated
        if self.autoreset_mode is AutoresetMode.SAME_STEP and ended.any():
            infos |= self._final(ended)
            batch.reset(ended)
            self.painter.restart(batch, ended)
        return batch.observations.copy(), rewards, terminated, truncated, infos | self._infos(self._all)

    def render(self) -> tuple[np.ndarray, ...] | None:
        """One frame (H, W, 3) a row."""
        return self.painter.render_all(self.batch)

    def close_extras(self, **kwargs: Any) -> None:
        """Close what rendering holds."""
        self.painter.close()

    def _infos(self, mask: np.ndarray) -> dict[str, Any]:
        infos: dict[str, Any] = {}
        for name in (*INFO, "is_success"):
            values = self.batch.info(name)
            infos[name] = values if mask.all() else np.where(mask, values, np.zeros((), values.dtype))
            infos[f"_{name}"] = mask.copy()
        return infos

    def _final(self, ended: np.ndarray) -> dict[str, Any]:
        observations = np.full(self.num_envs, None, object)
        for row in np.flatnonzero(ended):
            observations[row] = self.batch.observations[row].copy()
        return {
            "final_obs": observations,
            "_final_obs": ended.copy(),
            "final_info": self._infos(ended),
            "_final_info": ended.copy(),
        }

    def _mask(self, options: Mapping[str, Any]) -> np.ndarray:
        mask = options.get("reset_mask", self._all)
        if not isinstance(mask, np.ndarray) or mask.dtype != bool or mask.shape != (self.num_envs,) or not mask.any():
            raise ValueError(
                f"reset option 'reset_mask' must be a bool array ({self.num_envs},) with a True in it, got {mask!r}"
            )
        return mask

    def _seeds(self, seed: Any) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if is_row_list(seed):
            if len(seed) != self.num_envs:
                raise ValueError(f"a list of seeds must have num_envs = {self.num_envs} entries, got {len(seed)}")
            return [None if value is None else checked_seed(value) for value in seed]
        first = checked_seed(seed)
        return [checked_seed(first + row) for row in range(self.num_envs)]
