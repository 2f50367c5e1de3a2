"""Manoeuvres that do not listen to the radio: no encounter distribution may let them win."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rss_gym.baselines.policy import Scripted
from rss_gym.params import number


@dataclass(frozen=True, kw_only=True)
class Constant(Scripted):
    """A constant displacement from the predefined trajectory, for the whole flight."""

    along_m: float = number(0.0, -1000.0, 1000.0)
    right_m: float = number(30.0, -1000.0, 1000.0)
    up_m: float = number(0.0, -1000.0, 1000.0)

    def interface(self) -> dict[str, Any]:
        """A reach that holds the displacement."""
        return {"action": "displacement", "reach_m": max(abs(self.along_m), abs(self.right_m), abs(self.up_m), 1.0)}

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """The displacement."""
        displacement = np.array([self.along_m, self.right_m, self.up_m]) / self.world.interface.reach_m
        return np.tile(displacement, (len(memory), 1))


@dataclass(frozen=True, kw_only=True)
class Climb(Scripted):
    """A constant height above the predefined trajectory, as far as the altitude band reaches."""

    up_m: float = number(15.0, -1000.0, 1000.0)

    in_space = True

    def interface(self) -> dict[str, Any]:
        """A reach that holds the height."""
        return {"action": "displacement", "reach_m": max(abs(self.up_m), 1.0)}

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """The height."""
        return np.tile([0.0, 0.0, self.up_m / self.world.interface.reach_m], (len(memory), 1))


@dataclass(frozen=True, kw_only=True)
class Blind(Scripted):
    """One fixed manoeuvre at a fixed time: a displacement held from `at_s` for `for_s`."""

    right_m: float = number(30.0, -1000.0, 1000.0)
    at_s: float = number(10.0, 0.0, 600.0)
    for_s: float = number(30.0, 0.0, 600.0)

    columns = 1

    def interface(self) -> dict[str, Any]:
        """A reach that holds the displacement."""
        return {"action": "displacement", "reach_m": max(abs(self.right_m), 1.0)}

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """The displacement while it is time; memory counts the seconds."""
        actions = np.zeros((len(memory), 3))
        now_s = memory[:, 0]
        due = (now_s >= self.at_s) & (now_s < self.at_s + self.for_s)
        actions[due, 1] = self.right_m / self.world.interface.reach_m
        memory[:, 0] += self.world.clock.decision_s
        return actions
