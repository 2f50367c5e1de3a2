"""Base of the rules that choose a velocity: path following, and a radius with the estimate's spread."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rss_gym.baselines.located import Others, check_radius, locate, vectors
from rss_gym.baselines.policy import Scripted
from rss_gym.params import number

HEIGHT_M = 15.0  # in space an intruder farther above or below is no matter: three std of two altitudes and a collision
HOMING_PS = 0.1  # slower than the autopilot, so that a velocity on the way back holds for some seconds


@dataclass(frozen=True, kw_only=True)
class VelocityRule(Scripted):
    """A rule that changes the velocity of path following where it would lead to a conflict.

    The commanded velocity is that of the way point, which the world integrates and the autopilot follows with a lag of
    about a second: without gusts the aircraft's velocity is 0.5-0.8 m/s from the commanded one, on average, where that
    is 1.6-1.8 m/s from the planned one (12 encounters a rule). A displacement has the way point dash at its greatest
    speed and then wait, within every decision.

    Parameters
    ----------
    radius_m : float
        Separation wanted.
    lookahead_s : float
        Time within which conflicts count.
    sigmas : float
        The radius grows by this many standard deviations of the other's position.
    """

    radius_m: float = number(25.0, 1.0, 1000.0)
    lookahead_s: float = number(20.0, 0.5, 600.0)
    sigmas: float = number(1.0, 0.0, 10.0)

    reads_positions = True

    def __post_init__(self) -> None:
        """Check the radius against the world's zone."""
        super().__post_init__()
        check_radius(self.radius_m, self.world)

    def interface(self) -> dict[str, Any]:
        """Commands velocities."""
        return {"action": "velocity"}

    def steer(
        self,
        flown: np.ndarray,
        cruise_mps: np.ndarray,
        wanted: np.ndarray,
        others: Others,
        radius_m: np.ndarray,
        memory: np.ndarray,
    ) -> None:
        """Change the velocities `wanted` (n, 3) in place; those flown (n, 3), planned speeds (n,), radii (n, K)."""
        raise NotImplementedError

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """The rule's change of path following."""
        return self.steered(seen, memory, path_following(seen, self.world.aircraft.speed_max_mps))

    def steered(self, seen: dict[str, np.ndarray], memory: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        """Actions that fly the velocities `wanted` (n, 3) where the rule does not object."""
        others = locate(seen, self.world)
        near = others.known & (np.abs(others.position_m[..., 2]) < HEIGHT_M)
        others = Others(near, others.position_m, others.velocity_mps, others.std_m)
        radius = np.minimum(self.radius_m + self.sigmas * others.std_m, self.world.zone.radius_m)
        self.steer(vectors(seen, "velocity", "mps"), seen["cruise_mps"], wanted, others, radius, memory)
        wanted[:, 0] -= seen["cruise_mps"]
        limits = self.world.aircraft
        return wanted / [limits.speed_max_mps, limits.speed_max_mps, limits.vertical_speed_max_mps]


def path_following(seen: dict[str, np.ndarray], speed_max_mps: float) -> np.ndarray:
    """Velocity of the way point that leads it back to the predefined trajectory, (n, 3)."""
    velocity = -HOMING_PS * vectors(seen, "way_point", "m")
    velocity[:, 0] += seen["cruise_mps"]
    level = np.hypot(velocity[:, 0], velocity[:, 1])
    velocity[:, :2] *= (speed_max_mps / np.maximum(level, speed_max_mps))[:, None]
    return velocity
