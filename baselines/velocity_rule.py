"""Base of the rules that choose a velocity: path following, and a radius with the track's spread."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rss_gym.baselines.intruders import Intruders, check_radius, intruders
from rss_gym.baselines.policy import Scripted, vectors
from rss_gym.baselines.way_points import commanded, path_following
from rss_gym.params import number
from rss_gym.tracking.approach import TIME_MAX_S

HEIGHT_M = 15.0  # in space an intruder farther above or below is no matter: three std of two altitudes and a collision


@dataclass(frozen=True, kw_only=True)
class VelocityRule(Scripted):
    """A rule that changes the velocity of path following where it would lead to a conflict.

    The commanded velocity is that of the way point, which the world integrates and the autopilot follows with a lag of
    about a second.

    Told to it: the own velocity and way point, and the tracks.

    Parameters
    ----------
    radius_m : float
        Separation wanted.
    lookahead_s : float
        Time within which conflicts count.
    sigmas : float
        The radius grows by this many standard deviations of the track's position.
    """

    radius_m: float = number(20.0, 1.0, 1000.0)
    lookahead_s: float = number(20.0, 0.5, TIME_MAX_S)
    sigmas: float = number(1.0, 0.0, 10.0)

    def __post_init__(self) -> None:
        """Check the radius against the world's zone."""
        super().__post_init__()
        check_radius(self.radius_m, self.params)

    def steer(
        self,
        flown: np.ndarray,
        cruise_mps: np.ndarray,
        wanted: np.ndarray,
        others: Intruders,
        radius_m: np.ndarray,
        memory: np.ndarray,
    ) -> None:
        """Change the velocities `wanted` (n, 3) in place; those flown (n, 3), planned speeds (n,), radii (n, K)."""
        raise NotImplementedError

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """The rule's change of path following."""
        return self.steered(seen, memory, path_following(seen, self.params))

    def steered(self, seen: dict[str, np.ndarray], memory: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        """Actions that fly the velocities `wanted` (n, 3) where the rule does not object."""
        others = intruders(seen)
        others = replace(others, known=others.known & (np.abs(others.position_m[..., 2]) < HEIGHT_M))
        radius = np.minimum(self.radius_m + self.sigmas * others.std_m, self.params.zone.radius_m)
        self.steer(vectors(seen, "velocity", "mps"), seen["cruise_mps"], wanted, others, radius, memory)
        return commanded(wanted, seen, self.params)
