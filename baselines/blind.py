"""Manoeuvres that do not listen to the radio: no distribution of encounters may let them win."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rss_gym.baselines.policy import Scripted
from rss_gym.baselines.way_points import commanded, towards
from rss_gym.params import number


@dataclass(frozen=True, kw_only=True)
class Constant(Scripted):
    """Flies to a displacement from the predefined trajectory and stays there, for the whole flight."""

    along_m: float = number(0.0, -1000.0, 1000.0)
    right_m: float = number(30.0, -1000.0, 1000.0)
    up_m: float = number(0.0, -1000.0, 1000.0)

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """Towards the displacement."""
        return towards(np.tile([self.along_m, self.right_m, self.up_m], (len(memory), 1)), seen, self.params)


@dataclass(frozen=True, kw_only=True)
class Climb(Scripted):
    """A constant height above the predefined trajectory (below, if negative), as far as the altitude band reaches."""

    up_m: float = number(15.0, -1000.0, 1000.0)

    in_space = True

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """Towards the height."""
        return towards(np.tile([0.0, 0.0, self.up_m], (len(memory), 1)), seen, self.params)


@dataclass(frozen=True, kw_only=True)
class Velocity(Scripted):
    """A constant velocity along the leg, to its right, and up, for the whole flight."""

    along_mps: float = number(0.0, -50.0, 50.0)
    right_mps: float = number(3.0, -50.0, 50.0)
    up_mps: float = number(0.0, -20.0, 20.0)

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """The velocity."""
        return commanded(np.tile([self.along_mps, self.right_mps, self.up_mps], (len(memory), 1)), seen, self.params)


@dataclass(frozen=True, kw_only=True)
class Stop(Scripted):
    """Brakes to a standstill for good."""

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """No velocity."""
        return commanded(np.zeros((len(memory), 3)), seen, self.params)


@dataclass(frozen=True, kw_only=True)
class Back(Scripted):
    """Runs back along its path for good, as fast as an action can say."""

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """The greatest change against the leg."""
        return np.tile([-1.0, 0.0, 0.0], (len(memory), 1))


@dataclass(frozen=True, kw_only=True)
class Blind(Scripted):
    """One fixed manoeuvre at a fixed time: a displacement to the right, held from `at_s` for `for_s`."""

    right_m: float = number(30.0, -1000.0, 1000.0)
    at_s: float = number(10.0, 0.0, 600.0)
    for_s: float = number(30.0, 0.0, 600.0)

    columns = 1

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """To the displacement while it is time, and back; memory counts the seconds."""
        target, now_s = np.zeros((len(memory), 3)), memory[:, 0]
        target[(now_s >= self.at_s) & (now_s < self.at_s + self.for_s), 1] = self.right_m
        memory[:, 0] += self.params.clock.decision_s
        return towards(target, seen, self.params)
