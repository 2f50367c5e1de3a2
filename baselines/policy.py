"""The protocol of a policy, the base of the scripted ones, and the two that do not look.

Scripted policies are handed observations and nothing else; what they remember travels in `state`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol, get_args

import numpy as np

from rss_gym import observation
from rss_gym.jit import kernel
from rss_gym.params import Group, Params, Track
from rss_gym.physics.random import uniform


class Policy(Protocol):
    """Anything with SB3's `predict`, on one observation or a batch of them."""

    def predict(
        self,
        observation: Any,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Any, Any]:
        """Actions, and the state to hand back at the next call."""
        ...


@dataclass(frozen=True, kw_only=True)
class Scripted(Group):
    """Base of the scripted policies: options as fields, the world they fly in, memory as one array of rows.

    A subclass writes `act`; `memory` columns are zero at the start of an episode. `tracks` are those it can fly on;
    a rule that `reads_positions` flies on track `range` inside `RangeOnly`, one `in_space` in no planar world.
    """

    world: Params = field(default_factory=Params)

    columns = 0
    tracks: ClassVar[tuple[str, ...]] = get_args(Track)
    reads_positions: ClassVar[bool] = False
    in_space: ClassVar[bool] = False

    def interface(self) -> dict[str, Any]:
        """Parameters of the world that the policy needs: track, action, reach."""
        return {}

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """Actions (n, 3) along, right, up; `seen` in SI units, own (n,) and per intruder (n, K); memory in place."""
        raise NotImplementedError

    def predict(
        self, observation_: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """SB3's `predict`.

        Parameters
        ----------
        observation_ : (d,) or (n, d) array
            Of the policy's `world`.
        state : (n, m) array, optional
            As returned by the last call; None starts afresh.
        episode_start : (n,) bool array, optional
            Rows whose memory is cleared.

        Returns
        -------
        actions, state
            float32 (axes,) or (n, axes), and the memory.
        """
        return self.answer(observation_, state, episode_start, self.act)

    def answer(
        self, observation_: Any, state: Any, episode_start: Any, act: Callable[..., np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """What `predict` returns for the actions of `act`."""
        values = np.asarray(observation_)
        rows = np.atleast_2d(values)
        memory = np.zeros((len(rows), self.columns)) if state is None else np.array(state, dtype=np.float64)
        if episode_start is not None:
            memory[np.broadcast_to(np.asarray(episode_start, bool), len(rows))] = 0.0
        actions = act(observation.split(rows, self.world), memory)
        if self.world.encounter.planar:
            actions = actions[:, :2]
        actions = np.clip(actions, -1.0, 1.0).astype(np.float32)
        return (actions if values.ndim > 1 else actions[0]), memory


@dataclass(frozen=True, kw_only=True)
class Nothing(Scripted):
    """Flies the predefined trajectory: the denominator of every risk ratio."""

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """Zero."""
        return np.zeros((len(memory), 3))


@kernel
def _draw(memory, first, actions):
    """Uniform actions as a function of the episode's first observation and of the step, so of no batch or seed."""
    for row in range(len(memory)):
        if memory[row, 1] == 0.0:
            memory[row, 0] = first[row]
        key = np.uint64(memory[row, 0])
        for axis in range(3):
            actions[row, axis] = 2.0 * uniform(key, axis, int(memory[row, 1])) - 1.0
        memory[row, 1] += 1.0


@dataclass(frozen=True, kw_only=True)
class Random(Scripted):
    """Uniformly random actions, the same in every re-run of an episode."""

    columns = 2

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """Random."""
        actions = np.zeros((len(memory), 3))
        # 2^24 different first ranges are enough to tell episodes apart; a double holds them exactly.
        _draw(memory, np.floor(np.ascontiguousarray(seen["range_m"][:, 0]) * 65536.0), actions)
        return actions
