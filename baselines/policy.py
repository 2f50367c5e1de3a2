"""The protocol of a policy, the base of the scripted ones, and the two that do not look.

Scripted policies are handed observations and nothing else; what they remember travels in `state`. All command a change
of the way point's velocity.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol, get_args

import numpy as np

from rss_gym import observation
from rss_gym.jit import kernel
from rss_gym.params import Group, Information, Params
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

    A subclass writes `act`; `memory` columns are zero at the start of an episode. `information` are the levels that it
    can fly on; one `in_space` flies in no planar world.
    """

    params: Params = field(default_factory=Params)

    columns = 0
    information: ClassVar[tuple[str, ...]] = get_args(Information)
    in_space: ClassVar[bool] = False

    @classmethod
    def home(cls, params: Params) -> Params:
        """The world that it flies in, of the one that it is made for."""
        return params

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """Actions (n, 3) along, right, up; `seen` in SI units, own (n,) and per intruder (n, K); memory in place."""
        raise NotImplementedError

    def predict(
        self, observation_: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[np.ndarray, Any]:
        """SB3's `predict`.

        Parameters
        ----------
        observation_ : (d,) or (n, d) array
            One or several observations of the policy's `params`.
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
        actions = act(observation.split(rows, self.params), memory)
        if self.params.encounter.planar:
            actions = actions[:, :2]
        actions = np.clip(actions, -1.0, 1.0).astype(np.float32)
        return (actions if values.ndim > 1 else actions[0]), memory


def vectors(seen: Mapping[str, np.ndarray], stem: str, unit: str) -> np.ndarray:
    """The components along, right and up of a named vector as one array, shape (..., 3); a missing `up` is zero."""
    first = seen[f"{stem}_along_{unit}"]
    up = seen.get(f"{stem}_up_{unit}", np.zeros_like(first))
    return np.stack([first, seen[f"{stem}_right_{unit}"], up], axis=-1)


@dataclass(frozen=True, kw_only=True)
class Nothing(Scripted):
    """Flies the predefined trajectory: the denominator of every risk ratio."""

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """No change of the planned velocity in any row, (n, 3)."""
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
        """Actions (n, 3) uniform in [-1, 1]."""
        actions = np.zeros((len(memory), 3))
        # 2^24 different first ranges are enough to tell episodes apart; a double holds them exactly.
        _draw(memory, np.floor(np.ascontiguousarray(seen["range_m"][:, 0]) * 65536.0), actions)
        return actions
