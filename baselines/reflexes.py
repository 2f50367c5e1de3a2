"""Reflexes to the warning alone: they expose scores that reward freezing or fleeing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rss_gym.baselines.policy import Scripted
from rss_gym.params import number


def homing(seen: dict[str, np.ndarray], gain_ps: float = 0.3) -> np.ndarray:
    """Velocity beside the planned one that leads back to the predefined trajectory, m/s, shape (n, 3)."""
    out = np.zeros((len(seen["time_s"]), 3))
    for axis, name in enumerate(("along", "right", "up")):
        if f"track_error_{name}_m" in seen:
            out[:, axis] = -gain_ps * seen[f"track_error_{name}_m"]
    return out


@dataclass(frozen=True, kw_only=True)
class Brake(Scripted):
    """Stops while any warning is open, then returns to the predefined trajectory."""

    def interface(self) -> dict[str, Any]:
        """Commands velocities."""
        return {"action": "velocity"}

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """Minus the planned velocity under a warning, else homing."""
        velocity = homing(seen)
        warned = seen["warning"].any(axis=1)
        velocity[warned] = 0.0
        velocity[warned, 0] = -seen["cruise_mps"][warned]
        return velocity / self.world.aircraft.speed_max_mps


@dataclass(frozen=True, kw_only=True)
class RightTurn(Scripted):
    """Moves to the right of its trajectory while any warning is open."""

    right_m: float = number(30.0, 0.0, 1000.0)

    def interface(self) -> dict[str, Any]:
        """A reach that holds the displacement."""
        return {"action": "displacement", "reach_m": max(self.right_m, 1.0)}

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """To the right under a warning."""
        actions = np.zeros((len(memory), 3))
        actions[seen["warning"].any(axis=1), 1] = self.right_m / self.world.interface.reach_m
        return actions
