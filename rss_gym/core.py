"""The batch that every shell stands on: n environments, their state, and the calls that advance them.

`env.py` is a batch of one, `vector.py` a batch of n; neither holds any physics.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np

from rss_gym import encounters, observation, variants
from rss_gym.encounters.sampler import STAGGER_S
from rss_gym.jit import announce, kernel
from rss_gym.params import Params, ParamsError, suggestion
from rss_gym.physics.motion import clip
from rss_gym.sensed import OTHER, OWN
from rss_gym.state import allocate

SPLITS = {"train": 0, "validation": 1, "suite": 2}
SEED_LIMIT = 2**63

# The changes of velocity of the discrete actions, in shares of the speed limits (along, right, up): all combinations of
# half the limit forward and back with half of it to the right and to the left; planar worlds end before `up`.
DISCRETE_ACTIONS = np.array(
    [[0, 0, 0]]
    + [[along, right, 0] for along in (0, 1, -1) for right in (0, 1, -1) if along or right]
    + [[0, 0, 1], [0, 0, -1]],
    dtype=np.float64,
) / [2.0, 2.0, 1.0]

# Columns of the episode record that go into `info`, with their meaning.
INFO = {
    "collision": "separation was below `collision_m`",
    "snmac": "horizontal and vertical separation were below the sNMAC limits at one instant",
    "zone": "separation was below the zone radius",
    "min_separation_m": "least true separation so far",
    "deviation_m": "mean distance from the predefined trajectory over the last decision",
    "deviation_mean_m": "mean distance from the predefined trajectory over the flight so far",
    "deviation_max_m": "greatest such distance so far",
    "cost_m": "cost of the encounter so far; at the end of the episode, the cost of the encounter",
    "reward_deviation": "term of the reward: the mean deviation",
    "reward_snmac": "term of the reward: the price of an sNMAC",
    "reward_collision": "term of the reward: the price of a collision",
    "reward_proximity": "term of the reward: the price of being near, 0 unless `proximity_price_m` is set",
    "reward_shaping": "term of the reward: the gain of the potential, 0 unless `shaping_m` is set",
}


class Seen(NamedTuple):
    """What the agents of a batch know, and the working memory in which their observations are written."""

    own: Any  # (n,) OWN
    others: Any  # (n, K) OTHER
    raw: Any  # (d,) SI values of one observation
    table: Any  # (d, 4) `observation.transforms`


class NotFiniteError(RuntimeError):
    """The state of a row is not finite: whatever the run has scored since is void.

    Parameters
    ----------
    split : str
    seed, episode : int
        The seed and the number of the row's episode.
    """

    def __init__(self, split: str, seed: int, episode: int) -> None:
        super().__init__(split, seed, episode)
        self.split, self.seed, self.episode = split, seed, episode

    def __str__(self) -> str:
        """One sentence that names the encounter."""
        return (
            f"the state of episode {self.episode} of seed {self.seed}, split {self.split!r}, is not finite; "
            "please report these numbers with the parameters of the world"
        )


class BaseBatch(ABC):
    """n environments side by side, whatever they simulate: which episode each row runs, and what it has come to.

    A subclass adds `episode`, an (n,) array with the columns of `rss_gym.state.EPISODE`, `reset` and `step`, and for
    the evaluator `positions_m`, `planned_mps` and `sample`.

    Parameters
    ----------
    params : Params
    n : int
        Number of rows.
    width : int
        Fields of an observation.

    Attributes
    ----------
    observations : (n, d) float32 array
        Written by `reset` and `step`; copy before handing it out.
    rewards : (n,) array
    is_training : bool
        Whether the rows are those of a training: drives on roads are then faster, equal but for rounding, and their
        rewards charge the deviation evenly.
    """

    episode: Any
    is_training = False

    def __init__(self, params: Params, n: int, width: int) -> None:
        self.params, self.n = params, n
        self.observations = np.zeros((n, width), np.float32)
        self.rewards = np.zeros(n)
        self.split = np.zeros(n, np.int64)
        self.seeds = np.zeros(n, np.uint64)
        self.numbers = np.zeros(n, np.uint64)  # of the next episode
        self.started = np.zeros(n, bool)

    def seed(self, seeds: np.ndarray, mask: np.ndarray | slice = slice(None)) -> None:
        """Give rows a seed; their next episode is number 0 of it, on split `train`."""
        self.seeds[mask], self.numbers[mask], self.split[mask] = seeds, 0, SPLITS["train"]

    def apply_options(self, options: Mapping[str, Any], mask: np.ndarray) -> None:
        """Apply reset options that `checked_options` has returned to the rows of `mask`."""
        if "split" in options:
            self.split[mask] = SPLITS[options["split"]]
        if "episode" in options:
            self.numbers[mask] = np.broadcast_to(np.asarray(options["episode"], np.uint64), self.n)[mask]

    @abstractmethod
    def reset(self, mask: np.ndarray) -> None:
        """Start the next episode in the rows of `mask`, shape (n,)."""

    @abstractmethod
    def step(self, actions: np.ndarray, mask: np.ndarray) -> None:
        """Run one decision in the rows of `mask`; `actions` as the domain's `decode` returns them."""

    @property
    @abstractmethod
    def positions_m(self) -> np.ndarray:
        """The agents' positions (n, axes); NaN in a row that the last step left out, if rows end apart."""

    @property
    @abstractmethod
    def planned_mps(self) -> np.ndarray:
        """The agents' planned speeds, shape (n,)."""

    @abstractmethod
    def sample(self) -> tuple[np.ndarray, np.ndarray]:
        """True and estimated range of one other in each row, shape (n,) each; zeros where nobody is ranged."""

    def info(self, name: str) -> np.ndarray:
        """A copy of one column of `INFO`, or `is_success`."""
        e = self.episode
        if name == "is_success":
            return e["truncated"] & ~e["collision"]
        return e[name].copy()


class Batch(BaseBatch):
    """n encounters side by side.

    Parameters
    ----------
    params : Params
        The world; its channels are drawn from once per episode.
    n : int
        Number of rows.

    Attributes
    ----------
    state : rss_gym.state.State
        Record arrays of n rows.
    """

    def __init__(self, params: Params, n: int) -> None:
        announce(Path(__file__).resolve().parent)
        table = observation.transforms(observation.fields(params))
        super().__init__(params, n, len(table))
        self.state = allocate(params, encounters.table(params.encounter), n)
        others = np.zeros((n, params.encounter.intruders), OTHER)
        self.seen = Seen(np.zeros(n, OWN), others, np.zeros(len(table)), table)
        self.episode = self.state.episode

    def reset(self, mask: np.ndarray) -> None:
        """Start the next episode in the rows of `mask`, shape (n,)."""
        reset, _ = variants.kernels(self.params)
        failed = reset(self.state, self.seen, mask, self.split, self.seeds, self.numbers, self.observations)
        if failed >= 0:
            raise ParamsError(
                f"no encounter of families {self.params.encounter.families!r} meets the limits on closing speed, time "
                "and start range; widen cruise speeds, closing_min_mps or time_to_approach_max_s"
            )
        self.numbers[mask] += np.uint64(1)
        self.split[mask] = SPLITS["train"]  # a split is chosen for one episode: no later one strays into the suite
        self.rewards[mask] = 0.0
        self.started |= mask

    def step(self, actions: np.ndarray, mask: np.ndarray) -> None:
        """Fly one decision in the rows of `mask`, shape (n,); `actions` (n, 3) in [-1, 1] along, right, up.

        Raises
        ------
        NotFiniteError
            When a state is not finite.
        """
        _, step = variants.kernels(self.params)
        failed = step(self.state, self.seen, mask, actions, self.observations, self.rewards)
        if failed >= 0:
            e = self.episode[failed]
            raise NotFiniteError(list(SPLITS)[e["split"]], int(e["seed"]), int(e["number"]))

    @property
    def positions_m(self) -> np.ndarray:
        """The agents' positions (n, 3), held once a row has ended."""
        return np.array(self.state.aircraft["position_m"][:, 0])

    @property
    def planned_mps(self) -> np.ndarray:
        """The agents' planned speeds, shape (n,)."""
        return np.linalg.norm(self.state.aircraft["planned_mps"][:, 0], axis=1)

    def sample(self) -> tuple[np.ndarray, np.ndarray]:
        """True and estimated range of the first intruder, shape (n,) each."""
        position_m = self.state.aircraft["position_m"]
        return np.linalg.norm(position_m[:, 1] - position_m[:, 0], axis=1), self.state.links["range_m"][:, 0].copy()


def discrete_actions(params: Params) -> int:
    """How many of `DISCRETE_ACTIONS` there are in this world."""
    return 9 if params.encounter.planar else len(DISCRETE_ACTIONS)


def longest_episode(params: Params) -> int:
    """Decisions that no episode of this world exceeds: from the longest planned approach, and the tail after it."""
    encounter, clock = params.encounter, params.clock
    laws = encounters.table(encounter)
    start_m = encounter.start_range_max * encounter.start_range_unit_m
    approach_s = min(start_m / encounter.closing_min_mps, encounter.time_to_approach_max_s)
    if laws["merging"].any():
        approach_s += (encounter.intruders - 1) * STAGGER_S
    drawn_s = 0.0 if laws["scripted"].all() else approach_s + clock.tail_max_s
    decision_s = clock.ticks_per_decision * clock.tick_s
    return max(math.ceil(max(drawn_s, laws["end_s"].max()) / decision_s - 1e-9), 1)


def spaces(params: Params) -> tuple[gym.spaces.Box, gym.Space[Any]]:
    """Observation and action space of one environment."""
    low, high = observation.bounds(params)
    axes = 2 if params.encounter.planar else 3
    if params.interface.action == "discrete":
        return gym.spaces.Box(low, high, dtype=np.float32), gym.spaces.Discrete(discrete_actions(params))
    return gym.spaces.Box(low, high, dtype=np.float32), gym.spaces.Box(-1.0, 1.0, (axes,), np.float32)


def decode(actions: Any, params: Params, n: int) -> np.ndarray:
    """The policy's actions as changes of velocity in [-1, 1], shape (n, 3); finite values are clipped.

    Raises
    ------
    ValueError, TypeError
        If shape or type is wrong or a value is not finite; the sentence names what was expected.
    """
    values = np.asarray(actions)
    if params.interface.action == "discrete":
        return DISCRETE_ACTIONS[decode_discrete(values, discrete_actions(params), n)]
    axes = 2 if params.encounter.planar else 3
    if values.dtype.kind not in "fiu":
        raise TypeError(f"actions must be real numbers, got {values.dtype}")
    if values.shape != (n, axes):
        raise ValueError(
            f"actions have shape {values.shape}, expected ({n}, {axes}): along, right{', up' * (axes - 2)}"
        )
    out = np.zeros((n, 3))
    out[:, :axes] = values
    row = clipped(out)
    if row >= 0:
        raise ValueError(f"action of row {row} is not finite: {values[row]}")
    return out


def decode_discrete(values: np.ndarray, count: int, n: int) -> np.ndarray:
    """Discrete actions (n,), found to be whole numbers below `count`; errors as those of `decode`."""
    if values.dtype.kind not in "iu":
        raise TypeError(f"discrete actions must be whole numbers, got {values.dtype}")
    if values.shape != (n,):
        raise ValueError(f"actions have shape {values.shape}, expected ({n},)")
    wrong = (values < 0) | (values >= count)
    if np.any(wrong):
        raise ValueError(f"discrete actions must be in 0..{count - 1}, got {values[wrong][0]}")
    return values


@kernel
def clipped(actions):
    """Hold `actions` (n, 3) within [-1, 1] in place. Returns the first row that is not finite, -1 if all are.

    One call costs a fraction of those of NumPy that do the same, and a single environment makes it at every step.
    """
    for row in range(len(actions)):
        for axis in range(3):
            if not isfinite(actions[row, axis]):
                return row
            actions[row, axis] = clip(actions[row, axis], -1.0, 1.0)
    return -1


def checked_options(options: Any, n: int, *more: str) -> Mapping[str, Any]:
    """The options of a reset of n rows: `split`, `episode` (a number, or one per row), and the names in `more`.

    Raises
    ------
    ValueError
        For an unknown option or split, or an episode that is not a whole number in [0, 2**63).
    TypeError
        If they are not a mapping.
    """
    options = {} if options is None else options
    if not isinstance(options, Mapping):
        raise TypeError(f"reset options must be a dict, got {options!r}")
    for name in options:
        if name not in ("split", "episode", *more):
            raise ValueError(f"reset option {name!r} is unknown{suggestion(str(name), ['split', 'episode', *more])}")
    split, episode = options.get("split", "train"), options.get("episode", 0)
    if not isinstance(split, str) or split not in SPLITS:
        raise ValueError(f"reset option 'split' = {split!r} is unknown{suggestion(str(split), SPLITS)}")
    rows = episode if is_row_list(episode) else [episode]
    if len(rows) not in {1, n} or not all(map(_counts, rows)):
        expected = "a whole number in [0, 2**63)" + f", or {n} of them" * (n > 1)
        raise ValueError(f"reset option 'episode' must be {expected}, got {episode!r}")
    return options


def is_row_list(value: Any) -> bool:
    """Whether this is a list, tuple or one-dimensional array: one entry a row."""
    return isinstance(value, (list, tuple)) or (isinstance(value, np.ndarray) and value.ndim == 1)


def _counts(value: Any) -> bool:
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    return whole and 0 <= value < SEED_LIMIT


def checked_seed(seed: Any) -> int:
    """A seed as a whole number in [0, 2**63).

    Raises
    ------
    ValueError
        For any other value.
    """
    if not _counts(seed):
        raise ParamsError(f"seed must be a whole number in [0, 2**63), got {seed!r}")
    return int(seed)
