"""The batch as a `VecEnv` of Stable-Baselines3: `make_vec_env("rss_gym/Encounter-v0", n_envs=256, seed=0)`.

Needs the extra `train`; nothing else imports this module.
"""

from __future__ import annotations

import functools
import importlib
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec

from rss_gym.core import SEED_LIMIT, checked_options, checked_seed
from rss_gym.domain import domain_of
from rss_gym.ids import IDS, ROADS
from rss_gym.params import Params, ParamsError, suggestion
from rss_gym.render.painter import RENDER_FPS, Painter
from rss_gym.rows import INFOS, EnvRows, StepLimit, count_of_rows

try:
    from stable_baselines3.common import env_util
    from stable_baselines3.common.vec_env import VecEnv, VecMonitor
except ImportError as error:
    raise ImportError("rss_gym.sb3 needs Stable-Baselines3: pip install -e '.[train]' in the clone") from error

_OF_CLASS = ("every_info",)  # keywords of `EncounterVecEnv` that are none of the environment


def make_vec_env(
    env_id: str | EnvSpec | Callable[..., gym.Env[Any, Any]],
    n_envs: int = 1,
    seed: int | None = None,
    start_index: int = 0,
    monitor_dir: str | None = None,
    wrapper_class: Callable[..., gym.Env[Any, Any]] | None = None,
    env_kwargs: Mapping[str, Any] | None = None,
    vec_env_cls: Any = None,
    vec_env_kwargs: Mapping[str, Any] | None = None,
    monitor_kwargs: Mapping[str, Any] | None = None,
    wrapper_kwargs: Mapping[str, Any] | None = None,
    **keywords: Any,
) -> VecEnv:
    """A monitored `VecEnv`, with the arguments of Stable-Baselines3's function of this name.

    Encounters run side by side on one batch, which is many times as fast as environments one by one. Where that cannot
    be (roads, a callable, `wrapper_class`, `vec_env_cls`, a spec with wrappers, or an option of the monitor other than
    `info_keywords`) this is SB3's own function over `gymnasium.make`.

    Parameters
    ----------
    env_id : str, EnvSpec or callable
        A registered id, such as `rss_gym/Encounter-v0`, also as `module:id`; a spec; or what makes an environment.
    n_envs : int
        Number of rows, at least 1. A batch costs hardly more per decision of 256 rows than of 64.
    seed : int, optional
        EnvRow i gets seed + i at its first reset, as in `gymnasium.make_vec`; None draws them.
    start_index : int
        Number in the name of the monitor's file.
    monitor_dir : str, optional
        Folder for the monitor's file; without it, only the infos tell return and length of the episodes.
    wrapper_class, wrapper_kwargs, vec_env_cls
        As SB3's function takes them.
    env_kwargs : dict, optional
        As `gymnasium.make` takes them: `params`, `render_mode`, `max_episode_steps`, any field of the parameters.
    vec_env_kwargs : dict, optional
        `every_info` of the class, or, with `vec_env_cls`, that class's.
    monitor_kwargs : dict, optional
        Such as `info_keywords=("collision",)`.
    **keywords
        More of `env_kwargs`, and `every_info`.

    Raises
    ------
    ParamsError
        For an unknown id, parameter or keyword.
    """
    more, monitor = dict(vec_env_kwargs or {}), dict(monitor_kwargs or {})
    found, world = _found(env_id), _merged("env_kwargs", env_kwargs, keywords)
    count_of_rows("n_envs", n_envs)
    is_plain = (
        wrapper_class is None and vec_env_cls is None and not wrapper_kwargs and set(monitor) <= {"info_keywords"}
    )
    if found is None or not is_plain:
        unknown = next((name for name in _OF_CLASS if name in world or name in more), None)
        if unknown is not None:
            raise ParamsError(f"{unknown} is for the batch, which cannot be used here: {_why(found, is_plain)}")
        make: Any = functools.partial(gym.make, env_id) if isinstance(env_id, EnvSpec) else env_id
        return env_util.make_vec_env(
            make, n_envs, None if seed is None else checked_seed(seed), start_index, monitor_dir, wrapper_class, world,
            vec_env_cls, more, monitor, dict(wrapper_kwargs or {}),
        )  # fmt: skip
    for name in more:
        if name not in _OF_CLASS:
            raise ParamsError(f"vec_env_kwargs has no {name!r} without a vec_env_cls{suggestion(name, _OF_CLASS)}")
    environment = EncounterVecEnv(n_envs, **_merged("vec_env_kwargs", more, {**found, **world}))
    environment.spec = env_id if isinstance(env_id, EnvSpec) else gym.spec(str(env_id).rpartition(":")[2])
    if seed is not None:
        environment.seed(checked_seed(seed))
    file = None
    if monitor_dir is not None:
        os.makedirs(monitor_dir, exist_ok=True)
        file = os.path.join(monitor_dir, str(start_index))
    return VecMonitor(environment, file, tuple(monitor.get("info_keywords", ())))


def _found(env_id: Any) -> dict[str, Any] | None:
    """The keywords of an id's or spec's world; None where a batch cannot stand for it."""
    if isinstance(env_id, EnvSpec):
        if env_id.id not in IDS or env_id.additional_wrappers:
            return None
        limit = {} if env_id.max_episode_steps is None else {"max_episode_steps": env_id.max_episode_steps}
        return {**limit, **env_id.kwargs}
    if callable(env_id):
        return None
    module, colon, name = env_id.rpartition(":") if isinstance(env_id, str) else ("", "", "")
    if colon:
        try:
            importlib.import_module(module)
        except ImportError as error:
            raise ParamsError(f"environment {env_id!r}: module {module!r} cannot be imported: {error}") from error
    if name not in IDS and name not in ROADS:
        raise ParamsError(f"environment {env_id!r} is unknown{suggestion(str(env_id), [*IDS, *ROADS])}")
    return None if name in ROADS else IDS[name]


def _merged(name: str, given: Mapping[str, Any] | None, keywords: Mapping[str, Any]) -> dict[str, Any]:
    twice = next((key for key in given or {} if key in keywords), None)
    if twice is not None:
        raise ParamsError(f"{twice} is given twice, as a keyword and in {name}")
    return {**(given or {}), **keywords}


def _why(found: Any, is_plain: bool) -> str:
    return "other arguments ask for environments one by one" if found is not None else "this is no encounter's id"


class EncounterVecEnv(VecEnv):
    """Encounters side by side, equal bit for bit to the Gymnasium vector environment in mode `SameStep`.

    Parameters
    ----------
    n_envs : int
        Number of rows.
    params, render_mode, **keywords
        As in `rss_gym.env.EncounterEnv`; render mode `rgb_array` or None.
    max_episode_steps : int, optional
        Truncate an episode after so many steps.
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
        max_episode_steps: int | None = None,
        **keywords: Any,
    ) -> None:
        n_envs = count_of_rows("n_envs", n_envs)
        self.limit = StepLimit(max_episode_steps, n_envs)
        self.params, self.every_info = Params.of(params, **keywords), every_info
        domain = domain_of(self.params)
        self.batch, self._decode = domain.make_batch(self.params, n_envs), domain.decode
        self.painter = Painter(render_mode, {"render_modes": ["rgb_array"]}, n_envs)
        self.observation_space, self.action_space = domain.spaces(self.params)
        self.metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": RENDER_FPS}
        self.spec: EnvSpec | None = None
        self._rows = EnvRows(self, n_envs, self.observation_space, self.action_space)
        super().__init__(n_envs, self.observation_space, self.action_space)
        self.metadata["render_fps"] = RENDER_FPS
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
        self._start(self._all)
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
        self._actions = self._decode(actions, self.params, self.num_envs)

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Fly one decision: observations (n, d), rewards (n,) float32, dones (n,), infos."""
        if self._actions is None:
            raise gym.error.ResetNeeded("call step_async() before step_wait()")
        batch, episode = self.batch, self.batch.episode
        batch.step(self._actions, self._all)
        self._actions = None
        self.painter.follow(batch, self._all)
        self.limit.follow(self._all)
        rewards = batch.rewards.astype(np.float32)
        terminated, truncated = episode["terminated"].copy(), episode["truncated"] | self.limit.reached
        dones = terminated | truncated
        infos = self._infos(self._all if self.every_info else dones)
        if dones.any():
            for row in np.flatnonzero(dones):
                infos[row]["terminal_observation"] = batch.observations[row].copy()
                infos[row]["TimeLimit.truncated"] = bool(truncated[row] and not terminated[row])
            self._start(dones)
        return batch.observations.copy(), rewards, dones, infos

    def close(self) -> None:
        """Close what rendering holds."""
        self.painter.close()

    def get_images(self) -> Sequence[np.ndarray | None]:
        """One frame (H, W, 3) a row, or None without a render mode."""
        return self.painter.render_all(self.batch) or [None] * self.num_envs

    def get_attr(self, attr_name: str, indices: int | Iterable[int] | None = None) -> list[Any]:
        """An attribute of each of the chosen rows; `params` is the world's."""
        return self._rows.get(attr_name, self._get_indices(indices))

    def set_attr(self, attr_name: str, value: Any, indices: int | Iterable[int] | None = None) -> None:
        """Set an attribute of the chosen rows.

        Raises
        ------
        ParamsError
            For `params`: rows share one world, so another one needs another environment.
        """
        chosen = list(self._get_indices(indices))
        self._rows.set(attr_name, [value] * len(chosen), chosen)

    def env_method(
        self, method_name: str, *arguments: Any, indices: int | Iterable[int] | None = None, **keywords: Any
    ) -> list[Any]:
        """Call a method of each of the chosen rows, such as `info`."""
        return self._rows.call(method_name, self._get_indices(indices), *arguments, **keywords)

    def env_is_wrapped(
        self, wrapper_class: type[gym.Wrapper[Any, Any, Any, Any]], indices: int | Iterable[int] | None = None
    ) -> list[bool]:
        """No row is wrapped."""
        return [False for _ in self._get_indices(indices)]

    def _start(self, mask: np.ndarray) -> None:
        self.batch.reset(mask)
        self.limit.restart(mask)
        self.painter.restart(self.batch, mask)

    def _infos(self, mask: np.ndarray) -> list[dict[str, Any]]:
        """A dictionary of its own for each row, as wrappers write into them; empty outside `mask`."""
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        if mask.any():
            columns = {name: self.batch.info(name)[mask].tolist() for name in INFOS}
            for position, row in enumerate(np.flatnonzero(mask)):
                infos[row] = {name: values[position] for name, values in columns.items()}
        return infos
