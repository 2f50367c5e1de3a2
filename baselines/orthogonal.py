"""The paper's orthogonal rule as a policy, flown on what the agent is told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rss_gym.avoidance.orthogonal import displacement
from rss_gym.baselines.located import check_radius, vectors
from rss_gym.baselines.policy import Scripted
from rss_gym.jit import kernel
from rss_gym.params import number

STILL_MPS = 0.5  # an intruder slower than this counts as hovering
# Columns of the memory: the intruder obeyed + 1, whether it was moving, the side kept in the axes of its flight.
OBEYED, MOVING, ALONG, RIGHT, UP, HEADING_ALONG, HEADING_RIGHT = range(7)
COS_TURNED = 0.8660254037844386  # 30 degrees: after such a turn, of either, the side is chosen anew


@kernel
def _steer(error_m, cruise_mps, told, position_m, velocity_mps, age_s, radius_m, lookahead_s, memory, out):
    """Rows of (45), centred on the other's predicted position; the nearest predicted intruder is obeyed."""
    for row in range(len(out)):
        nearest, near, nx, ny, nz = -1, np.inf, 0.0, 0.0, 0.0
        warned = False
        for k in range(told.shape[1]):
            if not told[row, k]:
                continue
            warned = True
            ahead_s = age_s[row, k] + lookahead_s
            # From u_i(n+1) to u_j^d(n+1), in the axes of the leg: `position` is relative to the own solution.
            x = cruise_mps[row] * lookahead_s - error_m[row, 0] - position_m[row, k, 0]
            y = -error_m[row, 1] - position_m[row, k, 1]
            z = -error_m[row, 2] - position_m[row, k, 2]
            x, y, z = (
                x - velocity_mps[row, k, 0] * ahead_s,
                y - velocity_mps[row, k, 1] * ahead_s,
                z - velocity_mps[row, k, 2] * ahead_s,
            )
            square = x * x + y * y + z * z
            if square < near:
                nearest, near, nx, ny, nz = k, square, x, y, z
        if not warned:
            memory[row, :] = 0.0
        if nearest < 0:
            continue
        vx, vy, vz = velocity_mps[row, nearest, 0], velocity_mps[row, nearest, 1], velocity_mps[row, nearest, 2]
        # Below this the announced direction is mostly error and gusts.
        moving = vx * vx + vy * vy + vz * vz >= STILL_MPS * STILL_MPS
        if not moving:
            vx = vy = vz = 0.0
        # The axes of the other's flight, to its right: the own leg may turn while a side is kept.
        level = np.sqrt(vx * vx + vy * vy)
        ax, ay = (vx / level, vy / level) if level > 0.0 else (1.0, 0.0)
        m = memory[row]
        turned = ax * m[HEADING_ALONG] + ay * m[HEADING_RIGHT] < COS_TURNED
        if m[OBEYED] != nearest + 1.0 or m[MOVING] != moving or turned:
            m[:] = 0.0
            m[OBEYED], m[MOVING], m[HEADING_ALONG], m[HEADING_RIGHT] = nearest + 1.0, moving, ax, ay
        side_x, side_y = m[ALONG] * ax - m[RIGHT] * ay, m[ALONG] * ay + m[RIGHT] * ax
        out[row, 0], out[row, 1], out[row, 2], side_x, side_y, m[UP] = displacement(
            nx, ny, nz, vx, vy, vz, radius_m, side_x, side_y, m[UP]
        )
        m[ALONG], m[RIGHT] = side_x * ax + side_y * ay, side_y * ax - side_x * ay


@dataclass(frozen=True, kw_only=True)
class Orthogonal(Scripted):
    """The orthogonal rule (43)-(45) on the exchanged positions, keeping the side it chose first.

    Parameters
    ----------
    radius_m : float
        S of (44)-(45); at most the zone radius, within which messages arrive.
    lookahead_s : float
        Time from n to n + 1: the zone is centred on where the other will be.
    """

    radius_m: float = number(60.0, 1.0, 1000.0)
    lookahead_s: float = number(0.5, 0.0, 60.0)

    reads_positions = True
    columns = 7

    def interface(self) -> dict[str, Any]:
        """Messages, and a reach to the far edge of the zone."""
        return {"action": "displacement", "reach_m": 2.0 * self.radius_m}

    def __post_init__(self) -> None:
        """Check the radius against the world's zone."""
        super().__post_init__()
        check_radius(self.radius_m, self.world)

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """The rule's displacement over the reach."""
        out = np.zeros((len(memory), 3))
        _steer(
            vectors(seen, "track_error", "m"),
            seen["cruise_mps"],
            (seen["warning"] > 0.5) & (seen["message_valid"] > 0.5),
            vectors(seen, "message_position", "m"),
            vectors(seen, "message_velocity", "mps"),
            seen["message_age_s"],
            self.radius_m,
            self.lookahead_s,
            memory,
            out,
        )
        return out / self.world.interface.reach_m
