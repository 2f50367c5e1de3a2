"""The single environment: a thin shell round a batch of one."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np

from rss_gym.core import INFO, SEED_LIMIT, Batch, checked_options, checked_seed, decode, spaces
from rss_gym.params import Params
from rss_gym.records import EPISODE
from rss_gym.render.painter import RENDER_FPS, Painter

_NAMES = list(EPISODE.names or ())
_COLUMNS, _TRUNCATED = {name: _NAMES.index(name) for name in INFO}, _NAMES.index("truncated")
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

    A flat `Box` of named fields, float32: a value divided by its scale, clipped to [low, high]. These are the columns
    in space, on track `paper`, with one intruder; each further intruder adds those of `intruder_0`.

    | Num | Field | Unit | Scale | Low | High | Meaning |
    |---|---|---|---|---|---|---|
    | 0 | `track_error_along_m` | m | 30 | -3 | 3 | own solution minus predefined trajectory |
    | 1 | `track_error_right_m` | m | 30 | -3 | 3 | own solution minus predefined trajectory |
    | 2 | `track_error_up_m` | m | 30 | -3 | 3 | own solution minus predefined trajectory |
    | 3 | `way_point_along_m` | m | 30 | -3 | 3 | commanded way point minus predefined trajectory |
    | 4 | `way_point_right_m` | m | 30 | -3 | 3 | commanded way point minus predefined trajectory |
    | 5 | `way_point_up_m` | m | 30 | -3 | 3 | commanded way point minus predefined trajectory |
    | 6 | `velocity_along_mps` | m/s | 5 | -3 | 3 | own velocity, own solution |
    | 7 | `velocity_right_mps` | m/s | 5 | -3 | 3 | own velocity, own solution |
    | 8 | `velocity_up_mps` | m/s | 5 | -3 | 3 | own velocity, own solution |
    | 9 | `cruise_mps` | m/s | 5 | 0 | 3 | speed of the predefined trajectory |
    | 10 | `time_s` | s | 60 | 0 | 3 | time flown |
    | 11 | `turn_in_s` | s | 20 | 0 | 3 | time to the next turn of the predefined trajectory, or the limit |
    | 12 | `turn_cos` | 1 | 1 | -1 | 1 | cosine of that turn, 1 without one |
    | 13 | `turn_sin` | 1 | 1 | -1 | 1 | sine of that turn, positive to the right |
    | 14 | `intruder_0.present` | 1 | 1 | 0 | 1 | 1 if this intruder exists; the row is zero otherwise |
    | 15 | `intruder_0.range_m` | m | 120 | 0 | 3 | estimated range |
    | 16 | `intruder_0.range_std_m` | m | 60 | 0 | 3 | its standard deviation according to the filter |
    | 17 | `intruder_0.coloured_db` | dB | 10 | -3 | 3 | estimated coloured noise of the link |
    | 18 | `intruder_0.path_loss_factor` | 1 | 4 | 0 | 3 | path loss factor that the filter holds |
    | 19 | `intruder_0.range_rate_mps` | m/s | 10 | -3 | 3 | smoothed rate of the estimated range |
    | 20 | `intruder_0.zone_radius_m` | m | 120 | 0 | 3 | radius S of the safety zone in force |
    | 21 | `intruder_0.margin_m` | m | 120 | -3 | 3 | estimated range minus zone radius |
    | 22 | `intruder_0.warning` | 1 | 1 | 0 | 1 | 1 while the warning is open |
    | 23 | `intruder_0.streak` | 1 | 1 | 0 | 1 | consecutive ticks inside the zone over n_d |
    | 24 | `intruder_0.message_valid` | 1 | 1 | 0 | 1 | 1 once a message is held |
    | 25 | `intruder_0.message_age_s` | s | 10 | 0 | 3 | age of the held message |
    | 26 | `intruder_0.message_velocity_along_mps` | m/s | 5 | -3 | 3 | intruder's velocity, its own solution |
    | 27 | `intruder_0.message_velocity_right_mps` | m/s | 5 | -3 | 3 | intruder's velocity, its own solution |
    | 28 | `intruder_0.message_velocity_up_mps` | m/s | 5 | -3 | 3 | intruder's velocity, its own solution |
    | 29 | `intruder_0.message_position_along_m` | m | 120 | -3 | 3 | intruder's announced position minus own solution |
    | 30 | `intruder_0.message_position_right_m` | m | 120 | -3 | 3 | intruder's announced position minus own solution |
    | 31 | `intruder_0.message_position_up_m` | m | 120 | -3 | 3 | intruder's announced position minus own solution |
    | 32 | `intruder_0.message_way_point_along_m` | m | 120 | -3 | 3 | intruder's announced next way point minus own solution |
    | 33 | `intruder_0.message_way_point_right_m` | m | 120 | -3 | 3 | intruder's announced next way point minus own solution |
    | 34 | `intruder_0.message_way_point_up_m` | m | 120 | -3 | 3 | intruder's announced next way point minus own solution |

    Planar worlds have no `up` fields, track `range` no `message_position` and `message_way_point`. The table of any
    world is `rss_gym.observation.fields(params)`; `rss_gym.observation.split` is the way back to SI units. Absent
    intruders' fields are zero. Nothing here is a true state, except on track `oracle`.

    ## Rewards

    `-(q |u - u^d| + kappa |dv|)` of (42), a soft proximity cost inside `comfort_m`, and on a collision
    `-(collision + q S)` for each decision left. The terms are in `info`.

    ## Starting state

    Both aircraft on their predefined trajectories, about 130-190 m apart, drawn from the families of encounters.
    `reset(seed=s)` starts episode 0 of seed s; every later `reset()` the next one. `reset(options={"split": "suite",
    "episode": k})` replays any episode of a split (`train`, `validation`, `suite`).

    ## Episode end

    1. Termination: the separation was below `collision_m`.
    2. Truncation: the clock of the encounter, its closest approach plus `tail_s`, has run out.

    ## Arguments

    `params` (a `Params` or its dict) and any field of it as a keyword; `channel` takes a preset, a TOML file, or a
    list to draw from once an episode. `render_mode` is `rgb_array` or `human`.

    ## Version history

    * v0: first version.
    """  # noqa: E501 (the table)

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
        chosen = checked_options(options, 1)
        if seed is not None:
            seed = checked_seed(seed)
        super().reset(seed=seed)
        if seed is None and not self.batch.started[0]:
            seed = int(self.np_random.integers(SEED_LIMIT))
        if seed is not None:
            self.batch.seed(np.array([seed], np.uint64))
        self.batch.choose(chosen, _ROW)
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
        values = self.batch.episode[0].item()  # one conversion: a field of a record costs as much as the whole
        info = {name: values[column] for name, column in _COLUMNS.items()}
        info["is_success"] = values[_TRUNCATED] and not info["collision"]
        return info
