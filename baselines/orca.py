"""Optimal reciprocal collision avoidance as a policy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rss_gym.avoidance.half_planes import nearest
from rss_gym.avoidance.orca import half_plane
from rss_gym.baselines.intruders import Intruders
from rss_gym.baselines.velocity_rule import VelocityRule
from rss_gym.jit import kernel
from rss_gym.params import number


@kernel
def _steer(flown, known, position, velocity, radius, lookahead_s, period_s, responsibility, speed, out):
    """ORCA in every row: the wanted velocities `out` (n, 3), m/s, become the nearest allowed ones.

    `flown` (n, 3) is the own velocity, `known` (n, K) says who counts; `position`, `velocity` (n, K, 3) and `radius`
    (n, K) are in m and m/s.
    """
    intruders = known.shape[1]
    planes, room = np.zeros((intruders, 4)), np.zeros((intruders, 4))
    for row in range(len(out)):
        count = 0
        for k in range(intruders):
            if known[row, k]:
                x, y, vx, vy = position[row, k, 0], position[row, k, 1], flown[row, 0], flown[row, 1]
                rx, ry = vx - velocity[row, k, 0], vy - velocity[row, k, 1]
                half_plane(x, y, rx, ry, vx, vy, radius[row, k], lookahead_s, period_s, responsibility, planes, count)
                count += 1
        if count:
            out[row, 0], out[row, 1] = nearest(planes, count, speed, out[row, 0], out[row, 1], room)


@dataclass(frozen=True, kw_only=True)
class Orca(VelocityRule):
    """Optimal reciprocal collision avoidance (van den Berg et al. 2011), in the horizontal plane.

    Parameters
    ----------
    radius_m, lookahead_s, sigmas
        See `VelocityRule`; the look-ahead is tau.
    responsibility : float
        Share of the change that is taken: 1, as the others do not react.
    """

    lookahead_s: float = number(10.0, 0.5, 600.0)
    responsibility: float = number(1.0, 0.0, 1.0)

    def steer(
        self,
        flown: np.ndarray,
        cruise_mps: np.ndarray,
        wanted: np.ndarray,
        others: Intruders,
        radius_m: np.ndarray,
        memory: np.ndarray,
    ) -> None:
        """The velocity nearest to `wanted` in all half-planes."""
        _steer(
            flown,
            others.known,
            others.position_m,
            others.velocity_mps,
            radius_m,
            self.lookahead_s,
            self.params.clock.decision_s,
            self.responsibility,
            self.params.aircraft.speed_max_mps,
            wanted,
        )
