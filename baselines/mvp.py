"""Modified voltage potential as a policy."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from rss_gym.avoidance.approach import keep
from rss_gym.avoidance.mvp import velocity_change
from rss_gym.baselines.located import Others
from rss_gym.baselines.velocity_rule import VelocityRule
from rss_gym.jit import kernel


@kernel
def _steer(known, position, velocity, radius, lookahead_s, speed, memory, out):
    """Rows of MVP."""
    for row in range(len(out)):
        vx, vy = out[row, 0], out[row, 1]
        x, y = vx, vy
        for k in range(known.shape[1]):
            side = 0.0
            if known[row, k]:
                px, py, r = position[row, k, 0], position[row, k, 1], radius[row, k]
                rx, ry = vx - velocity[row, k, 0], vy - velocity[row, k, 1]
                side = keep(memory[row, k], px, py, rx, ry, r, lookahead_s)
                dx, dy = velocity_change(px, py, rx, ry, r, lookahead_s, side)
                x, y = x + dx, y + dy
            memory[row, k] = side
        scale = speed / max(speed, sqrt(x * x + y * y))
        out[row, 0], out[row, 1] = x * scale, y * scale


@dataclass(frozen=True, kw_only=True)
class Mvp(VelocityRule):
    """Modified voltage potential (Hoekstra et al. 2002, as in BlueSky), in the horizontal plane.

    The change is made to the velocity of path following, not to the one flown: whether it is still needed is thereby
    asked anew at every decision, in place of BlueSky's separate test for resuming navigation.

    Parameters
    ----------
    radius_m, lookahead_s, sigmas, keep_side
        See `VelocityRule`.
    """

    def steer(
        self, own: np.ndarray, wanted: np.ndarray, others: Others, radius_m: np.ndarray, memory: np.ndarray
    ) -> None:
        """Add the changes for all intruders."""
        _steer(
            others.known,
            others.position_m,
            others.velocity_mps,
            radius_m,
            self.lookahead_s,
            self.world.aircraft.speed_max_mps,
            memory,
            wanted,
        )
