"""The vector environment: a thin shell round a batch of n, row for row equal to n single environments."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils import seeding
from gymnasium.vector.utils import batch_space

from rss_gym.core import (
    SEED_LIMIT,
    Batch,
    checked_options,
    checked_seed,
    decode,
    is_row_list,
    longest_episode,
    spaces,
)
from rss_gym.ids import bounded
from rss_gym.params import Params, ParamsError, suggestion
from rss_gym.render.painter import RENDER_FPS, Painter
from rss_gym.rows import INFOS, AutoresetMode, EnvRows, StepLimit, count_of_rows

_MODES = {mode.value: mode for mode in AutoresetMode}
if TYPE_CHECKING:
    _Base = gym.vector.VectorEnv[np.ndarray, Any, np.ndarray]
else:
    _Base = gym.vector.VectorEnv  # not generic in Gymnasium before 1.0


class EncounterVectorEnv(_Base):
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
    max_episode_steps : int, optional
        Truncate an episode after so many steps, as `gymnasium.wrappers.TimeLimit` does; the cost so far stays as it is.
    params, render_mode, **keywords
        As in the single environment; `render` returns one frame a row, with `rgb_array_list` one list of frames a row.
    """

    metadata = {"render_modes": ["rgb_array", "rgb_array_list"], "render_fps": RENDER_FPS}  # noqa: RUF012
    is_vector_env = True  # asked for by wrappers of Gymnasium before 1.0
    closed = False
    viewer = None  # closed by Gymnasium before 1.0
    _spec: EnvSpec | None = None

    def __init__(
        self,
        num_envs: int = 1,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        max_episode_steps: int | None = None,
        params: Params | dict[str, Any] | None = None,
        render_mode: str | None = None,
        **keywords: Any,
    ):
        self.num_envs = count_of_rows("num_envs", num_envs)
        self.limit = StepLimit(max_episode_steps, self.num_envs)
        if not isinstance(autoreset_mode, AutoresetMode):
            if autoreset_mode not in _MODES:
                raise ParamsError(
                    f"autoreset_mode {autoreset_mode!r} is unknown{suggestion(str(autoreset_mode), _MODES)}"
                )
            autoreset_mode = _MODES[autoreset_mode]
        self.autoreset_mode = autoreset_mode
        self.metadata = type(self).metadata | {"autoreset_mode": autoreset_mode}
        self.params = Params.of(params, **keywords)
        self.batch = Batch(self.params, self.num_envs)
        self.single_observation_space, self.single_action_space = spaces(self.params)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.painter = Painter(render_mode, self.metadata, self.num_envs)
        self.render_mode = render_mode
        self._all = np.ones(self.num_envs, bool)
        self._rows = EnvRows(self, self.num_envs, self.single_observation_space, self.single_action_space)

    @property
    def spec(self) -> EnvSpec | None:
        """What `gymnasium.make_vec` made this of; no episode is longer than its `max_episode_steps`."""
        return self._spec

    @spec.setter
    def spec(self, value: EnvSpec | None) -> None:
        self._spec = bounded(value, longest_episode(self.params), self.limit.steps)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode in every row, or in those of `options["reset_mask"]`, a bool array of `num_envs`.

        `seed` s gives row i the seed s + i; a list gives each row its own, None going on with the row's episodes.
        """
        chosen = checked_options(options, self.num_envs, "reset_mask")
        mask, seeds = self._mask(chosen), self._seeds(seed)
        if seed is None or isinstance(seed, (int, np.integer)):
            if seed is not None:
                self._np_random, self._np_random_seed = seeding.np_random(checked_seed(seed))
        for row, value in enumerate(seeds):
            if mask[row] and value is not None:
                self.batch.seed(np.array([value], np.uint64), slice(row, row + 1))
        fresh = mask & ~self.batch.started & np.array([value is None for value in seeds])
        if fresh.any():
            self.batch.seed(self.np_random.integers(SEED_LIMIT, size=int(fresh.sum())).astype(np.uint64), fresh)
        self.batch.apply_options(chosen, mask)
        self._start(mask)
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
        ended = episode["terminated"] | episode["truncated"] | self.limit.reached
        if self.autoreset_mode is AutoresetMode.DISABLED and ended.any():
            raise gym.error.ResetNeeded(
                f"row {np.flatnonzero(ended)[0]} has ended; reset it with reset(options={{'reset_mask': mask}})"
            )
        batch.step(decode(actions, self.params, self.num_envs), ~ended)
        if ended.any():  # only in NEXT_STEP: the other modes never leave an ended row behind
            self._start(ended)
        self.painter.follow(batch, ~ended)
        self.limit.follow(~ended)
        rewards = batch.rewards.copy()
        terminated, truncated = episode["terminated"].copy(), episode["truncated"] | self.limit.reached
        infos: dict[str, Any] = {}
        ended = terminated | truncated
        if self.autoreset_mode is AutoresetMode.SAME_STEP and ended.any():
            infos |= self._final(ended)
            self._start(ended)
        return batch.observations.copy(), rewards, terminated, truncated, infos | self._infos(self._all)

    def render(self) -> tuple[Any, ...] | None:
        """One frame (H, W, 3) a row; with `rgb_array_list` the list of a row's frames since the last call.

        Raises
        ------
        gymnasium.error.ResetNeeded
            Before the first reset.
        """
        return self.painter.render_all(self.batch)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """An attribute of each row, as of `gymnasium.vector.SyncVectorEnv`; `rss_gym.rows.EnvRow` lists them.

        Raises
        ------
        AttributeError
            If the rows have no such attribute.
        """
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of the rows: a list or tuple gives each its own value, anything else is for all.

        Raises
        ------
        ValueError
            If a list is not as long as there are rows, and for `params`, which all rows share.
        """
        given = values if isinstance(values, (list, tuple)) else [values] * self.num_envs
        if len(given) != self.num_envs:
            raise ValueError(f"values must be one, or a list of num_envs = {self.num_envs} of them, got {len(given)}")
        self._rows.set(name, given, range(self.num_envs))

    def call(self, name: str, *arguments: Any, **keywords: Any) -> tuple[Any, ...]:
        """Call a method of each row, such as `info`, or read an attribute."""
        return tuple(self._rows.call(name, range(self.num_envs), *arguments, **keywords))

    def close_extras(self, **kwargs: Any) -> None:
        """Close what rendering holds."""
        self.painter.close()

    def _start(self, mask: np.ndarray) -> None:
        self.batch.reset(mask)
        self.limit.restart(mask)
        self.painter.restart(self.batch, mask)

    def _infos(self, mask: np.ndarray) -> dict[str, Any]:
        infos: dict[str, Any] = {}
        for name in INFOS:
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
        name = "`options['reset_mask']`"  # in the words of Gymnasium, whose kinds of errors these are too
        if not isinstance(mask, np.ndarray):
            raise TypeError(f"{name} must be a numpy array, got {type(mask)}")
        if mask.dtype != bool:
            raise TypeError(f"{name} must have `dtype=np.bool_`, got {mask.dtype}")
        if mask.shape != (self.num_envs,):
            raise ValueError(f"{name} must have shape `({self.num_envs},)`, got {mask.shape}")
        if not mask.any():
            raise ValueError(f"{name} must contain a boolean array with at least one True value, got reset_mask={mask}")
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
