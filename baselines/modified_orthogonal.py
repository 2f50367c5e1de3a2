"""The modified orthogonal rule of Sec. IX-A as a policy, on ranges and velocities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rss_gym.avoidance.modified_orthogonal import bearing_cosine, velocity
from rss_gym.baselines.policy import Scripted, vectors
from rss_gym.baselines.way_points import commanded, path_following
from rss_gym.jit import kernel
from rss_gym.params import number

# Columns of the memory.
OPENED, CLOCK, BEFORE, FLOWN, FLOWN_X, FLOWN_Y, OTHER_X, OTHER_Y, GO_X, GO_Y, DECIDED = range(11)


@kernel
def _steer(own_mps, heard, range_m, other_mps, hover_s, period_s, radius_m, memory, out):
    """Measure the triangle while the other hovers, then fly at right angles to its previous velocity.

    `own_mps` (n, 3); `heard` (n, K) says whose message is held, `range_m` (n, K) and `other_mps` (n, K, 3) are theirs.
    `memory` (n, 11) and `out` (n, 3) are written: a velocity (m/s), and 1 where it is to be flown.
    """
    for row in range(len(out)):
        m = memory[row]
        nearest = -1
        for k in range(heard.shape[1]):
            if heard[row, k] and (nearest < 0 or range_m[row, k] < range_m[row, nearest]):
                nearest = k
        if nearest < 0:
            m[:] = 0.0
            continue
        if m[OPENED] == 0.0:
            m[OPENED], m[BEFORE] = 1.0, range_m[row, nearest]
            m[OTHER_X], m[OTHER_Y] = other_mps[row, nearest, 0], other_mps[row, nearest, 1]
        elif m[DECIDED] == 0.0:
            m[CLOCK] += period_s
            m[FLOWN_X] += own_mps[row, 0] * period_s
            m[FLOWN_Y] += own_mps[row, 1] * period_s
        if m[DECIDED] == 0.0 and m[CLOCK] >= hover_s:
            flown_m = np.sqrt(m[FLOWN_X] * m[FLOWN_X] + m[FLOWN_Y] * m[FLOWN_Y])
            cosine = bearing_cosine(m[BEFORE], range_m[row, nearest], flown_m)
            m[GO_X], m[GO_Y] = velocity(m[OTHER_X], m[OTHER_Y], m[FLOWN_X], m[FLOWN_Y], cosine)
            m[DECIDED] = 1.0
        if m[DECIDED] == 1.0 and range_m[row, nearest] <= radius_m:
            out[row, 0], out[row, 1], out[row, 2] = m[GO_X], m[GO_Y], 1.0


@dataclass(frozen=True, kw_only=True)
class ModifiedOrthogonal(Scripted):
    """The modified orthogonal rule (Sec. IX-A) on two ranges and the other's previous velocity.

    Parameters
    ----------
    radius_m : float
        The velocity is held while the range is below this; beyond it the agent returns to its trajectory.
    """

    radius_m: float = number(120.0, 1.0, 1000.0)

    information = ("ranges",)
    columns = 11

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """The rule's velocity, or path following."""
        out = np.zeros((len(memory), 3))
        _steer(
            vectors(seen, "velocity", "mps"),
            (seen["warning"] > 0.5) & (seen["message_valid"] > 0.5),
            np.ascontiguousarray(seen["range_m"]),
            vectors(seen, "message_velocity", "mps"),
            self.params.zone.hover_s,
            self.params.clock.decision_s,
            self.radius_m,
            memory,
            out,
        )
        evading = out[:, 2] > 0.0
        velocity = path_following(seen, self.params)
        velocity[evading, :2] = out[evading, :2]
        return commanded(velocity, seen, self.params)
