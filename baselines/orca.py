"""Optimal reciprocal collision avoidance as a policy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rss_gym.avoidance.approach import keep
from rss_gym.avoidance.half_planes import nearest
from rss_gym.avoidance.orca import half_plane
from rss_gym.baselines.located import Others
from rss_gym.baselines.velocity_rule import VelocityRule
from rss_gym.jit import kernel
from rss_gym.params import number


@kernel
def _steer(own, known, position, velocity, radius, lookahead_s, period_s, responsibility, speed, memory, out):
    """Rows of ORCA."""
    intruders = known.shape[1]
    planes, room = np.zeros((intruders, 4)), np.zeros((intruders, 4))
    for row in range(len(out)):
        count = 0
        for k in range(intruders):
            side = 0.0
            if known[row, k]:
                x, y, r = position[row, k, 0], position[row, k, 1], radius[row, k]
                ox, oy = velocity[row, k, 0], velocity[row, k, 1]
                side = keep(memory[row, k], x, y, out[row, 0] - ox, out[row, 1] - oy, r, lookahead_s)
                vx, vy = own[row, 0], own[row, 1]
                half_plane(
                    x, y, vx - ox, vy - oy, vx, vy, r, lookahead_s, period_s, responsibility, side, planes, count
                )
                count += 1
            memory[row, k] = side
        if count:
            out[row, 0], out[row, 1] = nearest(planes, count, speed, out[row, 0], out[row, 1], room)


@dataclass(frozen=True, kw_only=True)
class Orca(VelocityRule):
    """Optimal reciprocal collision avoidance (van den Berg et al. 2011), in the horizontal plane.

    Parameters
    ----------
    radius_m, lookahead_s, sigmas, keep_side
        See `VelocityRule`; the look-ahead is tau.
    responsibility : float
        Share of the change that is taken: 1, as the others do not react.
    """

    responsibility: float = number(1.0, 0.0, 1.0)

    def steer(
        self, own: np.ndarray, wanted: np.ndarray, others: Others, radius_m: np.ndarray, memory: np.ndarray
    ) -> None:
        """The velocity nearest to `wanted` in all half-planes."""
        _steer(
            own,
            others.known,
            others.position_m,
            others.velocity_mps,
            radius_m,
            self.lookahead_s,
            self.world.clock.decision_s,
            self.responsibility,
            self.world.aircraft.speed_max_mps,
            memory,
            wanted,
        )
