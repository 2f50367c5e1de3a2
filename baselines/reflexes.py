"""Reflexes to the warning alone: they expose scores that reward freezing or fleeing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rss_gym.baselines.policy import Scripted
from rss_gym.baselines.way_points import commanded, path_following, towards
from rss_gym.params import number


@dataclass(frozen=True, kw_only=True)
class Brake(Scripted):
    """Stops while any warning is open, then returns to the predefined trajectory."""

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """No velocity under a warning, else path following."""
        velocity = path_following(seen, self.params)
        velocity[seen["warning"].any(axis=1)] = 0.0
        return commanded(velocity, seen, self.params)


@dataclass(frozen=True, kw_only=True)
class RightTurn(Scripted):
    """Moves to the right of its trajectory while any warning is open."""

    right_m: float = number(30.0, 0.0, 1000.0)

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """To the right under a warning, else back."""
        target = np.zeros((len(memory), 3))
        target[seen["warning"].any(axis=1), 1] = self.right_m
        return towards(target, seen, self.params)
