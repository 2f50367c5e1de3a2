"""The single environment: a thin shell round a batch of one."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec

from rss_gym.core import INFO, SEED_LIMIT, Batch, checked_options, checked_seed, decode, longest_episode, spaces
from rss_gym.ids import bounded
from rss_gym.params import Params
from rss_gym.render.painter import RENDER_FPS, Painter
from rss_gym.state import EPISODE

_NAMES = list(EPISODE.names or ())
_COLUMNS = {name: _NAMES.index(name) for name in INFO}
_TERMINATED, _TRUNCATED = _NAMES.index("terminated"), _NAMES.index("truncated")
_ROW = np.ones(1, bool)


class EncounterEnv(gym.Env[np.ndarray, Any]):
    """An encounter of one agent with one to eight intruders whom it ranges by radio signal strength.

    ## Description

    The agent flies a predefined trajectory, has the duty to give way, and should come back to its path. Nobody has
    GNSS: every aircraft localises itself by its ranges to four reference nodes on a square of `node_square_m`, and
    ranges are estimated from the received signal strength, whose noise is coloured, by the augmented extended Kalman
    filter (12)-(21). The agent ranges each intruder in the same way. While the estimated range is within the safety
    zone (40) a warning is open, and with every tick of the radio a message of the intruder arrives: its velocity, its
    position and the accuracy of that, and where it plans to be `announce_s` later, all by its own solution. A tracker
    makes one relative state with a covariance of messages and ranges. One step is one decision, `decision_s`.

    ## Action space

    `Box(-1, 1, (2,), float32)`, in space `(3,)`: the change of the way point's velocity from the planned velocity.

    | Num | Action | Min | Max | Unit |
    |---|---|---|---|---|
    | 0 | along the current leg | -1 | 1 | `speed_max_mps` |
    | 1 | to the right of it | -1 | 1 | `speed_max_mps` |
    | 2 | up (only with `planar=False`) | -1 | 1 | `vertical_speed_max_mps` |

    The way point moves at the planned velocity plus the change, shortened to `speed_max_mps` if it is faster, and the
    autopilot, the regulator of (42), follows it; its height stays within `altitude_band_m` of the planned one. Zero
    keeps the present offset from the path: it is the policy that leads the aircraft back. With `action="discrete"` the space is
    `Discrete(9)`: no change, and the eight combinations of half the limit forward or back with half of it to the right
    or to the left; `Discrete(11)` in space, with climb and descent at the full limit. `rss_gym.core.DISCRETE_ACTIONS`
    lists them. Finite values outside the box are clipped; other values raise `ValueError` or `TypeError`.

    ## Observation space

    A flat `Box` of named fields, float32. A column is made of the value x in SI units as the table says, and clipped to
    [low, high]; near distances are stretched, so that 5 m and 15 m differ. Vectors are given along the current leg, to
    the right of it, and up. These are the columns in space, with information `positions` and one intruder; each
    further intruder adds those of `intruder_0`.

    | Num | Field | Unit | Column | Low | High | Meaning |
    |---|---|---|---|---|---|---|
    | 0 | `way_point_along_m` | m | x / (abs(x) + 20) | -1 | 1 | commanded way point minus predefined trajectory |
    | 1 | `way_point_right_m` | m | x / (abs(x) + 20) | -1 | 1 | commanded way point minus predefined trajectory |
    | 2 | `way_point_up_m` | m | x / (abs(x) + 20) | -1 | 1 | commanded way point minus predefined trajectory |
    | 3 | `offset_along_m` | m | x / (abs(x) + 20) | -1 | 1 | own solution minus predefined trajectory |
    | 4 | `offset_right_m` | m | x / (abs(x) + 20) | -1 | 1 | own solution minus predefined trajectory |
    | 5 | `offset_up_m` | m | x / (abs(x) + 20) | -1 | 1 | own solution minus predefined trajectory |
    | 6 | `velocity_along_mps` | m/s | x / 5 | -3 | 3 | own velocity, own solution |
    | 7 | `velocity_right_mps` | m/s | x / 5 | -3 | 3 | own velocity, own solution |
    | 8 | `velocity_up_mps` | m/s | x / 5 | -3 | 3 | own velocity, own solution |
    | 9 | `cruise_mps` | m/s | x / 5 | 0 | 3 | speed of the predefined trajectory |
    | 10 | `ahead_along_m` | m | x / 30 | -3 | 3 | predefined trajectory `announce_s` later minus now |
    | 11 | `ahead_right_m` | m | x / 30 | -3 | 3 | predefined trajectory `announce_s` later minus now |
    | 12 | `solution_std_m` | m | x / 15 | 0 | 3 | standard deviation of the own solution, per axis |
    | 13 | `intruder_0.present` | 1 | x | 0 | 1 | 1 if this intruder exists; the row is zero otherwise |
    | 14 | `intruder_0.range_m` | m | x / 120 | 0 | 3 | estimated range |
    | 15 | `intruder_0.range_std_m` | m | x / 60 | 0 | 3 | its standard deviation according to the filter |
    | 16 | `intruder_0.range_rate_mps` | m/s | x / 10 | -3 | 3 | smoothed rate of the estimated range |
    | 17 | `intruder_0.coloured_db` | dB | x / 10 | -3 | 3 | estimated coloured noise of the link |
    | 18 | `intruder_0.path_loss_factor` | 1 | x / 4 | 0 | 3 | path loss factor that the filter holds |
    | 19 | `intruder_0.white_std_db` | dB | x / 10 | 0 | 3 | standard deviation of the white noise that it holds |
    | 20 | `intruder_0.coloured_std_db` | dB | x / 10 | 0 | 3 | that of the coloured noise |
    | 21 | `intruder_0.coloured_tc_s` | s | x / 10 | 0 | 3 | correlation time of the coloured noise |
    | 22 | `intruder_0.zone_radius_m` | m | x / 120 | 0 | 3 | radius S of the safety zone in force |
    | 23 | `intruder_0.margin_m` | m | x / 120 | -3 | 3 | estimated range minus zone radius |
    | 24 | `intruder_0.warning` | 1 | x | 0 | 1 | 1 while the warning is open |
    | 25 | `intruder_0.consecutive_warnings` | 1 | x | 0 | 1 | consecutive ticks inside the zone over n_d |
    | 26 | `intruder_0.message_valid` | 1 | x | 0 | 1 | 1 once a message is held; its fields and the track's are zero before |
    | 27 | `intruder_0.message_age_s` | s | x / 10 | 0 | 3 | time since the held message was sent |
    | 28 | `intruder_0.message_velocity_along_mps` | m/s | x / 5 | -3 | 3 | intruder's velocity, its own solution |
    | 29 | `intruder_0.message_velocity_right_mps` | m/s | x / 5 | -3 | 3 | intruder's velocity, its own solution |
    | 30 | `intruder_0.message_velocity_up_mps` | m/s | x / 5 | -3 | 3 | intruder's velocity, its own solution |
    | 31 | `intruder_0.message_position_along_m` | m | x / 120 | -3 | 3 | intruder's announced position minus own solution |
    | 32 | `intruder_0.message_position_right_m` | m | x / 120 | -3 | 3 | intruder's announced position minus own solution |
    | 33 | `intruder_0.message_position_up_m` | m | x / 120 | -3 | 3 | intruder's announced position minus own solution |
    | 34 | `intruder_0.message_way_point_along_m` | m | x / 120 | -3 | 3 | intruder's announced next way point minus own solution |
    | 35 | `intruder_0.message_way_point_right_m` | m | x / 120 | -3 | 3 | intruder's announced next way point minus own solution |
    | 36 | `intruder_0.message_way_point_up_m` | m | x / 120 | -3 | 3 | intruder's announced next way point minus own solution |
    | 37 | `intruder_0.message_std_m` | m | x / 15 | 0 | 3 | accuracy of its position that the intruder states, per axis |
    | 38 | `intruder_0.track_valid` | 1 | x | 0 | 1 | 1 once there is a track |
    | 39 | `intruder_0.track_position_along_m` | m | x / 120 | -3 | 3 | track: intruder's position relative to the own |
    | 40 | `intruder_0.track_position_right_m` | m | x / 120 | -3 | 3 | track: intruder's position relative to the own |
    | 41 | `intruder_0.track_position_up_m` | m | x / 120 | -3 | 3 | track: intruder's position relative to the own |
    | 42 | `intruder_0.track_velocity_along_mps` | m/s | x / 10 | -3 | 3 | track: intruder's velocity relative to the own |
    | 43 | `intruder_0.track_velocity_right_mps` | m/s | x / 10 | -3 | 3 | track: intruder's velocity relative to the own |
    | 44 | `intruder_0.track_velocity_up_mps` | m/s | x / 10 | -3 | 3 | track: intruder's velocity relative to the own |
    | 45 | `intruder_0.track_std_along_m` | m | x / 15 | 0 | 3 | track: standard deviation along the bearing |
    | 46 | `intruder_0.track_std_across_m` | m | x / 15 | 0 | 3 | track: standard deviation across the bearing, level |
    | 47 | `intruder_0.track_std_up_m` | m | x / 15 | 0 | 3 | track: standard deviation of the height |
    | 48 | `intruder_0.flown_time_s` | s | x / 20 | 0 | 3 | time to the closest approach by the track, the own velocity staying as it is |
    | 49 | `intruder_0.flown_miss_along_m` | m | x / (abs(x) + 10) | -1 | 1 | where the intruder is then |
    | 50 | `intruder_0.flown_miss_right_m` | m | x / (abs(x) + 10) | -1 | 1 | where the intruder is then |
    | 51 | `intruder_0.flown_miss_up_m` | m | x / (abs(x) + 10) | -1 | 1 | where the intruder is then |
    | 52 | `intruder_0.flown_distance_m` | m | x / (abs(x) + 10) | 0 | 1 | how far away it is then |
    | 53 | `intruder_0.planned_time_s` | s | x / 20 | 0 | 3 | time to the closest approach by the track, the agent flying its predefined trajectory |
    | 54 | `intruder_0.planned_miss_along_m` | m | x / (abs(x) + 10) | -1 | 1 | where the intruder is then |
    | 55 | `intruder_0.planned_miss_right_m` | m | x / (abs(x) + 10) | -1 | 1 | where the intruder is then |
    | 56 | `intruder_0.planned_miss_up_m` | m | x / (abs(x) + 10) | -1 | 1 | where the intruder is then |
    | 57 | `intruder_0.planned_distance_m` | m | x / (abs(x) + 10) | 0 | 1 | how far away it is then |

    Planar worlds have no `up` fields. Information `ranges` has no `message_position`, `message_way_point`,
    `message_std_m` and `solution_std_m`, which by dead reckoning would tell the time flown. It adds `side_probability`
    and `other_position_along_m`, `other_position_right_m` behind the track's standard deviations, as ranges alone leave
    it open on which side of the relative velocity the intruder is.
    With information `oracle` every field is the true state, and the track is the truth with standard deviation 0.
    Otherwise nothing here is a true state. The columns of any world are `rss_gym.observation.fields(params)`;
    `rss_gym.observation.split` is the way back to SI units. Fields of absent intruders are zero, those of message
    and track while there is none.

    ## Rewards

    The reward is minus what the decision adds to the cost of the encounter, in metres:

    `deviation_price` (1) times the mean distance from the predefined trajectory over the flight, plus `snmac_price_m`
    (100) if there was an sNMAC, plus `collision_price_m` (10000) if there was a collision.

    So the undiscounted return is minus the cost, however the episode ends; a collision ends the flight, and the mean is
    over the part that was flown. For training there is `proximity_price_m` (0), the price of a flight spent at distance
    0, which falls to 0 at `comfort_m`, and `shaping_m` (0), a potential of the true predicted miss whose discounted
    gain (`shaping_discount`) is added and leaves the optimal policy as it is. `info` holds `cost_m`, the terms of the
    last reward, the events and the deviation; `is_success` is true at an end without a collision.

    ## Starting state

    All aircraft are on their predefined trajectories, the intruders about 130-190 m away, drawn from the families of
    encounters; about 40 % of encounters collide if nobody acts. `reset(seed=s)` starts episode 0 of seed s; every later
    `reset()` the next one. `reset(options={"split": "suite", "episode": k})` replays any episode of a split (`train`,
    `validation`, `suite`). A split holds for the episode that this reset starts; a later `reset()` without it starts
    the next number of split `train`.

    ## Info

    Arrays of shape (): the columns of `rss_gym.core.INFO` (events, separation, deviation, `cost_m`, the terms of the
    reward), and `is_success`. The vector environment has one array of `num_envs` values for each.

    ## Episode end

    1. Termination: the separation was below `collision_m`.
    2. Truncation: the flight has lasted until `tail_min_s` to `tail_max_s` (15 to 45 s, drawn) after the last planned
       closest approach. The clock is hidden from the policy, and paths go on beyond the end of the flight.

    ## Arguments

    `params` (a `Params` or its dict) and any field of it as a keyword; `channel` takes a preset, a TOML file, `radios`
    (all presets but `clean`, and random radios), or a list to draw from once an episode. `information` is `positions`,
    `oracle` (true states) or `ranges` (velocities and ranges only, dead reckoning, tracker `bearings`); `tracker` is
    `fused` or `latest`; `estimator` is `ekf-coloured`, `ekf-white`, `ekf-white-r` or `ls`. `render_mode` is
    `rgb_array` or `human`.

    ## Version history

    * v0: first version.
    """  # noqa: E501 (the table)

    metadata = {"render_modes": ["rgb_array", "human"], "render_fps": RENDER_FPS}  # noqa: RUF012

    _spec: EnvSpec | None = None

    def __init__(self, params: Params | dict[str, Any] | None = None, render_mode: str | None = None, **keywords: Any):
        self.params = Params.of(params, **keywords)
        self.batch = Batch(self.params, 1)
        self._running = False
        self.observation_space, self.action_space = spaces(self.params)
        self.painter = Painter(render_mode, self.metadata)
        self.render_mode = render_mode

    @property
    def spec(self) -> EnvSpec | None:
        """What `gymnasium.make` made this of; no episode of this world is longer than its `max_episode_steps`."""
        return self._spec

    @spec.setter
    def spec(self, value: EnvSpec | None) -> None:
        self._spec = bounded(value, longest_episode(self.params))

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
        self.batch.apply_options(chosen, _ROW)
        self.batch.reset(_ROW)
        self.painter.restart(self.batch)
        self._running = True
        return self.batch.observations[0].copy(), self._info(self.batch.episode[0].item())

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Fly one decision.

        Raises
        ------
        gymnasium.error.ResetNeeded
            Before the first reset, and after the end of an episode.
        ValueError, TypeError
            For an action of the wrong shape or type, or a non-finite one.
        """
        if not self._running:
            raise gym.error.ResetNeeded("call reset() before step(): no episode is running")
        batch = self.batch
        batch.step(decode(np.asarray(action)[None], self.params, 1), _ROW)
        self.painter.follow(batch)
        values = batch.episode[0].item()  # one conversion: a field of a record costs as much as the whole
        terminated, truncated = values[_TERMINATED], values[_TRUNCATED]
        self._running = not (terminated or truncated)
        return batch.observations[0].copy(), batch.rewards.item(), terminated, truncated, self._info(values)

    def render(self) -> np.ndarray | None:
        """The current frame: an array (H, W, 3) for `rgb_array`, None for `human`.

        Raises
        ------
        gymnasium.error.ResetNeeded
            Before the first reset.
        """
        return self.painter.render(self.batch)

    def close(self) -> None:
        """Close the window, if there is one."""
        self.painter.close()

    def _info(self, values: tuple[Any, ...]) -> dict[str, Any]:
        """The columns of `INFO` among the values of the episode record, as arrays: readers ask for type and shape."""
        info = {name: np.array(values[column]) for name, column in _COLUMNS.items()}
        info["is_success"] = np.array(values[_TRUNCATED] and not info["collision"])
        return info
