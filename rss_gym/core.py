"""The batch that every shell stands on: n environments, their records, and the calls that advance them.

`env.py` is a batch of one, `vector.py` a batch of n; neither holds any physics.
"""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np

from rss_gym import encounters, observation, records, world
from rss_gym.jit import kernel
from rss_gym.params import Params, ParamsError, suggestion
from rss_gym.sensed import OTHER, OWN
from rss_gym.sensing import sense_row

decide_row, reset_row, write = world.decide_row, world.reset_row, observation.write

SPLITS = {"train": 0, "validation": 1, "suite": 2}
SEED_LIMIT = 2**63

# What a discrete action displaces the way point to, in reaches (along, right, up); planar worlds end before `up`.
DISCRETE_ACTIONS = np.array(
    [[0, 0, 0], [0, 1, 0], [0, -1, 0], [1, 0, 0], [-1, 0, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64
)

# Columns of the episode record that go into `info`, with their meaning.
INFO = {
    "collision": "separation was below `collision_m`",
    "snmac": "horizontal and vertical separation were below the sNMAC limits at one instant",
    "zone": "separation was below the zone radius",
    "min_separation_m": "least true separation so far",
    "deviation_m": "mean distance from the predefined trajectory over the last decision",
    "deviation_max_m": "greatest such distance so far",
    "cost": "safety cost: 1 on a collision, else the squared closeness inside `comfort_m`",
    "reward_tracking": "term of the reward",
    "reward_effort": "term of the reward",
    "reward_proximity": "term of the reward",
    "reward_collision": "term of the reward",
}


@kernel
def step_rows(state, own, others, planar, positions, actions, skip, observations, rewards):
    """Advance the rows that are not skipped by one decision and write their observations."""
    for i in range(len(rewards)):
        if not skip[i]:
            rewards[i] = decide_row(state, i, actions[i])
            sense_row(state, i, own[i], others[i])
            write(own[i], others[i], planar, positions, observations[i])


@kernel
def reset_rows(state, own, others, planar, positions, mask, split, seeds, numbers, observations):
    """Start the given episodes in the rows of `mask` and write their observations. Returns the row that failed."""
    for i in range(len(mask)):
        if mask[i]:
            reset_row(state, i, split[i], seeds[i], numbers[i])
            if state.episode[i].family < 0:
                return i
            sense_row(state, i, own[i], others[i])
            write(own[i], others[i], planar, positions, observations[i])
    return -1


class Batch:
    """n environments side by side.

    Parameters
    ----------
    params : Params
        The world; its channels are drawn from once per episode.
    n : int
        Number of rows.

    Attributes
    ----------
    world : records.World
        All state, as record arrays of n rows.
    observations : (n, d) float32 array
        Written by `reset` and `step`; copy before handing it out.
    """

    def __init__(self, params: Params, n: int) -> None:
        self.params, self.n = params, n
        self.world = records.allocate(params, encounters.records(params.encounter), n)
        self.own = np.zeros(n, OWN)
        self.others = np.zeros((n, params.encounter.intruders), OTHER)
        self.observations = np.zeros((n, len(observation.fields(params))), np.float32)
        self.rewards = np.zeros(n)
        self.split = np.zeros(n, np.int64)
        self.seeds = np.zeros(n, np.uint64)
        self.numbers = np.zeros(n, np.uint64)  # of the next episode
        self.started = np.zeros(n, bool)
        self._layout = (params.encounter.planar, params.interface.track != "range")

    @property
    def episode(self) -> np.ndarray:
        """The rows' episode records, shape (n,)."""
        return self.world.episode  # type: ignore[no-any-return]

    def seed(self, seeds: np.ndarray, mask: np.ndarray | slice = slice(None)) -> None:
        """Give rows a seed; their next episode is number 0 of it, on split `train`."""
        self.seeds[mask], self.numbers[mask], self.split[mask] = seeds, 0, SPLITS["train"]

    def choose(self, options: dict[str, Any], mask: np.ndarray) -> None:
        """Apply the reset options `split` and `episode` (a number, or one per row) to the rows of `mask`.

        Raises
        ------
        ValueError
            For an unknown option or split, or an episode that is not a whole number >= 0.
        """
        for name in options:
            if name not in ("split", "episode", "reset_mask"):
                raise ValueError(f"reset option {name!r} is unknown{suggestion(name, ['split', 'episode', 'reset_mask'])}")
        if "split" in options:
            if options["split"] not in SPLITS:
                raise ValueError(f"split {options['split']!r} is unknown{suggestion(str(options['split']), SPLITS)}")
            self.split[mask] = SPLITS[options["split"]]
        if "episode" in options:
            numbers = np.asarray(options["episode"])
            if numbers.dtype.kind not in "iu" or numbers.shape not in ((), (self.n,)) or np.any(numbers < 0):
                raise ValueError(
                    f"reset option 'episode' must be a whole number >= 0, or {self.n} of them, got {options['episode']!r}"
                )
            self.numbers[mask] = np.broadcast_to(numbers, self.n)[mask]

    def reset(self, mask: np.ndarray) -> None:
        """Start the next episode in the rows of `mask`, shape (n,)."""
        failed = reset_rows(
            self.world, self.own, self.others, *self._layout, mask, self.split, self.seeds, self.numbers,
            self.observations,
        )  # fmt: skip
        if failed >= 0:
            raise ParamsError(
                f"no encounter of families {self.params.encounter.families!r} meets the limits on closing speed, time "
                "and start range; widen cruise speeds, closing_min_mps or time_to_approach_max_s"
            )
        self.numbers[mask] += np.uint64(1)
        self.rewards[mask] = 0.0
        self.started |= mask

    def step(self, actions: np.ndarray, skip: np.ndarray) -> None:
        """Fly one decision in the rows that are not in `skip`; `actions` (n, 3) in [-1, 1] along, right, up."""
        step_rows(
            self.world, self.own, self.others, *self._layout, actions, skip, self.observations, self.rewards
        )

    def info(self, name: str) -> np.ndarray:
        """A copy of one column of `INFO`, or `is_success`."""
        e = self.episode
        if name == "is_success":
            return e["truncated"] & ~e["collision"]  # type: ignore[no-any-return]
        return e[name].copy()  # type: ignore[no-any-return]


def spaces(params: Params) -> tuple[gym.spaces.Box, gym.Space[Any]]:
    """Observation and action space of one environment."""
    low, high = observation.bounds(params)
    axes = 2 if params.encounter.planar else 3
    if params.interface.action == "discrete":
        return gym.spaces.Box(low, high, dtype=np.float32), gym.spaces.Discrete(1 + 2 * axes)
    return gym.spaces.Box(low, high, dtype=np.float32), gym.spaces.Box(-1.0, 1.0, (axes,), np.float32)


def decode(actions: Any, params: Params, n: int) -> np.ndarray:
    """The policy's actions as displacements or velocities in [-1, 1], shape (n, 3); finite values are clipped.

    Raises
    ------
    ValueError, TypeError
        If shape or type is wrong or a value is not finite; the sentence names what was expected.
    """
    values = np.asarray(actions)
    if params.interface.action == "discrete":
        count = spaces(params)[1].n  # type: ignore[attr-defined]
        if values.dtype.kind not in "iu":
            raise TypeError(f"discrete actions must be whole numbers, got {values.dtype}")
        if values.shape != (n,):
            raise ValueError(f"actions have shape {values.shape}, expected ({n},)")
        if np.any((values < 0) | (values >= count)):
            raise ValueError(f"discrete actions must be in 0..{count - 1}, got {values[(values < 0) | (values >= count)][0]}")
        return DISCRETE_ACTIONS[values]
    axes = 2 if params.encounter.planar else 3
    if values.dtype.kind not in "fiu":
        raise TypeError(f"actions must be real numbers, got {values.dtype}")
    if values.shape != (n, axes):
        raise ValueError(f"actions have shape {values.shape}, expected ({n}, {axes}): along, right{', up' * (axes - 2)}")
    out = np.zeros((n, 3))
    out[:, :axes] = values
    # One sum sees every NaN and infinity; the search for the row is only done when there is one.
    if not np.isfinite(out.sum()):
        bad = np.flatnonzero(~np.isfinite(out).all(axis=1))
        if len(bad):
            raise ValueError(f"action of row {bad[0]} is not finite: {values[bad[0]]}")
    return np.clip(out, -1.0, 1.0, out=out)


def checked_seed(seed: Any) -> int:
    """A seed as a whole number in [0, 2**63).

    Raises
    ------
    ValueError
        For any other value.
    """
    if isinstance(seed, (bool, np.bool_)) or not isinstance(seed, (int, np.integer)) or not 0 <= seed < SEED_LIMIT:
        raise ValueError(f"seed must be a whole number in [0, 2**63), got {seed!r}")
    return int(seed)
