"""The single environment: a thin shell round a batch of one."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np

from rss_gym.core import INFO, SEED_LIMIT, Batch, checked_seed, decode, spaces
from rss_gym.params import Params
from rss_gym.render.painter import RENDER_FPS, Painter

_NO_ROW, _ROW = np.zeros(1, bool), np.ones(1, bool)


class EncounterEnv(gym.Env[np.ndarray, Any]):
    """An encounter of one agent with one to eight intruders whom it ranges by radio signal strength.

    ## Description

    The agent flies a predefined trajectory and must give way. It hears each intruder's radio and estimates the range
    from the received signal strength, whose noise is coloured, with the augmented extended Kalman filter (12)-(21).
    While the estimated range is within the safety zone (40), a warning is open and messages with the intruder's own
    position solution, velocity and next way point arrive. One step is one decision, `decision_s`.

    ## Action space

    `Box(-1, 1, (2,), float32)`, in space `(3,)`: displacement of the way point from the predefined trajectory.

    | Num | Action | Min | Max | Unit |
    |---|---|---|---|---|
    | 0 | along the current leg | -1 | 1 | `reach_m` |
    | 1 | to the right of it | -1 | 1 | `reach_m` |
    | 2 | up (only with `planar=False`) | -1 | 1 | `reach_m`, held within `altitude_band_m` |

    Zero means: follow the predefined trajectory. The way point moves at most `speed_max_mps`. With `action="velocity"`
    the way point instead moves at the planned velocity plus the action times `speed_max_mps`; with
    `action="discrete"` the space is `Discrete(5)` (`Discrete(7)` in space): follow, right, left, ahead, back, up, down.
    Finite values outside the box are clipped; other values raise `ValueError` or `TypeError`.

    ## Observation space

    A flat `Box` of named fields, float32, each divided by its scale and clipped. The columns depend on the parameters:
    `rss_gym.observation.fields(params)` is the table, `rss_gym.observation.split` the way back to SI units.

    | Field | Unit | Scale | Low | High | Meaning |
    |---|---|---|---|---|---|
    {fields}

    Absent intruders' fields are zero. Nothing here is a true state, except on track `oracle`.

    ## Rewards

    `-(q |u - u^d| + kappa |dv|)` of (42), a soft proximity cost inside `comfort_m`, and on a collision
    `-(collision + q S)` for each decision left. The terms are in `info`.

    ## Starting state

    Both aircraft on their predefined trajectories, about 130-190 m apart, drawn from the families of encounters.
    `reset(seed=s)` starts episode 0 of seed s; every later `reset()` the next one. `reset(options={{"split": "suite",
    "episode": k}})` replays any episode of a split (`train`, `validation`, `suite`).

    ## Episode end

    1. Termination: the separation was below `collision_m`.
    2. Truncation: the clock of the encounter, its closest approach plus `tail_s`, has run out.

    ## Arguments

    `params` (a `Params` or its dict) and any field of it as a keyword; `channel` takes a preset, a TOML file, or a
    list to draw from once an episode. `render_mode` is `rgb_array` or `human`.

    ## Version history

    * v0: first version.
    """

    metadata = {"render_modes": ["rgb_array", "human"], "render_fps": RENDER_FPS}  # noqa: RUF012

    def __init__(self, params: Params | dict[str, Any] | None = None, render_mode: str | None = None, **keywords: Any):
        self.params = Params.of(params, **keywords)
        self.batch = Batch(self.params, 1)
        self.observation_space, self.action_space = spaces(self.params)
        self.painter = Painter(render_mode, self.metadata)
        self.render_mode = render_mode

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode; see the class for `seed` and `options`."""
        if seed is not None:
            seed = checked_seed(seed)
        super().reset(seed=seed)
        if seed is None and not self.batch.started[0]:
            seed = int(self.np_random.integers(SEED_LIMIT))
        if seed is not None:
            self.batch.seed(np.array([seed], np.uint64))
        self.batch.choose(options or {}, _ROW)
        self.batch.reset(_ROW)
        self.painter.restart(self.batch)
        return self.batch.observations[0].copy(), self._info()

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Fly one decision.

        Raises
        ------
        gymnasium.error.ResetNeeded
            Before the first reset, and after the end of an episode.
        ValueError, TypeError
            For an action of the wrong shape or type, or a non-finite one.
        """
        episode = self.batch.episode[0]
        if not self.batch.started[0] or episode["terminated"] or episode["truncated"]:
            raise gym.error.ResetNeeded("call reset() before step(): no episode is running")
        self.batch.step(decode(np.asarray(action)[None], self.params, 1), _NO_ROW)
        self.painter.follow(self.batch)
        end = bool(episode["terminated"]), bool(episode["truncated"])
        return self.batch.observations[0].copy(), float(self.batch.rewards[0]), *end, self._info()

    def render(self) -> np.ndarray | None:
        """The current frame: an array (H, W, 3) for `rgb_array`, None for `human`."""
        return self.painter.render(self.batch)

    def close(self) -> None:
        """Close the window, if there is one."""
        self.painter.close()

    def _info(self) -> dict[str, Any]:
        episode = self.batch.episode[0]
        info = {name: episode[name].item() for name in INFO}
        info["is_success"] = bool(episode["truncated"]) and not info["collision"]
        return info
