"""The paper's orthogonal rule as a policy, flown on the tracks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rss_gym.avoidance.orthogonal import displacement, side_of
from rss_gym.baselines.intruders import check_radius, intruders
from rss_gym.baselines.policy import Scripted, vectors
from rss_gym.baselines.way_points import towards
from rss_gym.jit import kernel
from rss_gym.params import MAX_INTRUDERS, number

STILL_MPS = 0.5  # an intruder slower than this counts as hovering: the direction of its track is mostly error
SWEEPS = 4  # over all intruders, in search of a way point outside every zone
CLOSE_M = 1e-6  # a displacement below this is none
# Columns of the memory of an intruder: whether a side is kept, whether the intruder was moving, its heading in the axes
# of the leg, and the side in the axes of its flight.
KEPT, MOVING, HEADING_ALONG, HEADING_RIGHT, ALONG, RIGHT, UP, WIDTH = range(8)
COS_TURNED = 0.8660254037844386  # 30 degrees: after such a turn, of either, the side is chosen anew


@kernel
def _sweep(order, count, r, v, side, reach_m, memory, out):
    """Displace the way point by `out` (3,): from each intruder in turn, again until it is outside every zone."""
    for _ in range(SWEEPS if count > 1 else count):
        is_outside = True
        for n in range(count):
            k = order[n]
            x, y, z = r[k, 0] + out[0], r[k, 1] + out[1], r[k, 2] + out[2]
            if memory[k, KEPT] == 0.0 and x * x + y * y + z * z >= reach_m[k] * reach_m[k]:
                continue  # (43)
            if memory[k, KEPT] == 0.0 and (out[0] != 0.0 or out[1] != 0.0 or out[2] != 0.0):
                # By the point that the nearer ones have displaced.
                ax, ay = memory[k, HEADING_ALONG], memory[k, HEADING_RIGHT]
                sx, sy, sz = side_of(x, y, z, v[k, 0], v[k, 1], v[k, 2])
                side[k, 0], side[k, 1], side[k, 2] = sx, sy, sz
                memory[k, ALONG], memory[k, RIGHT], memory[k, UP] = sx * ax + sy * ay, sy * ax - sx * ay, sz
            x, y, z = displacement(x, y, z, v[k, 0], v[k, 1], v[k, 2], reach_m[k], side[k, 0], side[k, 1], side[k, 2])
            if x * x + y * y + z * z > CLOSE_M * CLOSE_M:
                memory[k, KEPT] = 1.0  # until the warning closes
                out[0] += x
                out[1] += y
                out[2] += z
                is_outside = False
        if is_outside:
            break


@kernel
def _steer(planned, cruise_mps, known, position_m, velocity_mps, radius_m, lookahead_s, level, memory, out):
    """Rows of (45): `out` (n, 3) becomes the displacement from the predefined trajectory.

    `planned` (n, 3) is the predefined trajectory now, relative to the own position; `memory` (n, K, WIDTH).
    """
    intruders = known.shape[1]
    # Of each intruder: from where it will be to the predefined way point, its velocity, the side to be on, and the
    # zone's radius in the plane that counts.
    r, v, side = np.zeros((intruders, 3)), np.zeros((intruders, 3)), np.zeros((intruders, 3))
    order, far, reach_m = np.zeros(intruders, np.int64), np.zeros(intruders), np.zeros(intruders)
    for row in range(len(out)):
        count = 0
        for k in range(intruders):
            m, u = memory[row, k], position_m[row, k]
            if not known[row, k]:
                m[:] = 0.0
                continue
            for axis in range(3):
                v[k, axis] = velocity_mps[row, k, axis]
                r[k, axis] = planned[row, axis] - u[axis] - v[k, axis] * lookahead_s
            r[k, 0] += cruise_mps[row] * lookahead_s
            ux, uy, uz, reach_m[k] = u[0], u[1], u[2], radius_m
            if level:  # the zone's section at the height of the way point
                reach_m[k] = np.sqrt(max(radius_m * radius_m - r[k, 2] * r[k, 2], 0.0))
                r[k, 2] = v[k, 2] = uz = 0.0
            moving = v[k, 0] * v[k, 0] + v[k, 1] * v[k, 1] + v[k, 2] * v[k, 2] >= STILL_MPS * STILL_MPS
            if not moving:
                v[k, :] = 0.0
            # The axes of the other's flight, to its right: the own leg may turn while a side is kept.
            speed = np.sqrt(v[k, 0] * v[k, 0] + v[k, 1] * v[k, 1])
            ax, ay = (v[k, 0] / speed, v[k, 1] / speed) if speed > 0.0 else (1.0, 0.0)
            turned = ax * m[HEADING_ALONG] + ay * m[HEADING_RIGHT] < COS_TURNED
            if m[KEPT] == 0.0 or m[MOVING] != moving or turned:
                # On which side of the other the aircraft itself is; one that is displaced already stays there.
                x, y, z = side_of(-ux, -uy, -uz, v[k, 0], v[k, 1], v[k, 2])
                m[MOVING], m[HEADING_ALONG], m[HEADING_RIGHT] = moving, ax, ay
                m[ALONG], m[RIGHT], m[UP] = x * ax + y * ay, y * ax - x * ay, z
            side[k, 0], side[k, 1] = m[ALONG] * ax - m[RIGHT] * ay, m[ALONG] * ay + m[RIGHT] * ax
            side[k, 2] = m[UP]
            square, at = ux * ux + uy * uy + uz * uz, count
            while at > 0 and far[at - 1] > square:
                order[at], far[at] = order[at - 1], far[at - 1]
                at -= 1
            order[at], far[at] = k, square
            count += 1
        _sweep(order, count, r, v, side, reach_m, memory[row], out[row])


@dataclass(frozen=True, kw_only=True)
class Orthogonal(Scripted):
    """The orthogonal rule (43)-(45) on the tracks, keeping the side on which it was when a zone was first in its way.

    The predefined trajectory is where the commanded way point says, which is known exactly. All intruders are obeyed,
    from the nearest on, each by the way point that those before it have displaced, and on the side on which that is:
    with sides by the own position alone 35 in place of 30 of 2,000 encounters with three intruders ended in a collision
    (`validation`, seed 0, 40 m). The sweep is repeated until the way point is outside every zone, four times at most:
    between two zones that overlap, with a side kept of each that leads into the other, it never is.

    With the side of the way point to come in place of the aircraft's own, let go outside the zone, and no displacement
    beyond 2 S, 68 in place of 4 of 20,000 encounters (`validation`, seed 0) ended in a collision at 40 m, and 37 in
    place of 2 at 80 m, at nearly the same deviation. What is left are turns of either aircraft.

    Parameters
    ----------
    radius_m : float
        S of (44)-(45); at most the zone radius, within which messages arrive.
    lookahead_s : float
        Time from n to n + 1: the zone is centred on where the other will be.
    level : float
        In space, 1 displaces the way point in the horizontal plane only, 0 at right angles to the other's velocity. At
        30 and 40 m the cost is 10.9 and 15.7 m level, 29.3 and 20.4 m otherwise (4,000 encounters as above).
    """

    radius_m: float = number(40.0, 1.0, 1000.0)
    lookahead_s: float = number(0.5, 0.0, 60.0)
    level: float = number(1.0, 0.0, 1.0)

    columns = WIDTH * MAX_INTRUDERS

    def __post_init__(self) -> None:
        """Check the radius against the world's zone."""
        super().__post_init__()
        check_radius(self.radius_m, self.params)

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """Towards the rule's way point."""
        others, out = intruders(seen), np.zeros((len(memory), 3))
        level = self.level > 0.0 or self.params.encounter.planar
        _steer(
            -vectors(seen, "way_point", "m"),
            np.ascontiguousarray(seen["cruise_mps"]),
            others.known,
            others.position_m,
            others.velocity_mps,
            self.radius_m,
            self.lookahead_s,
            level,
            memory.reshape(len(memory), -1, WIDTH),
            out,
        )
        return towards(out, seen, self.params)
