"""The regulator of (42) made predictive: candidate way points flown ahead against the exchanged trajectory.

A candidate is a displacement from the predefined trajectory, held over the horizon. Its flight follows the world's own
autopilot; its cost is (42), the time mean of q |u - u^d| plus kappa |dv|, and a penalty where the predicted separation
is less than a radius that grows with the uncertainty of the other's position.
"""

from math import sqrt

from rss_gym.jit import kernel
from rss_gym.physics.motion import limit, regulate


@kernel
def cost(
    ux, uy, uz, vx, vy, vz, wx, wy, wz, tx, ty, tz,
    cruise_mps, others, count, radius_m, sigmas, drift_mps, height_m,
    steps, step_s, speed_mps, vertical_mps, most_mps2, k1, k2, effort_s, penalty_m, least_m,
):  # fmt: skip
    """Cost of flying to the displacement (tx, ty, tz) and holding it, in metres of deviation.

    Parameters
    ----------
    ux, uy, uz, vx, vy, vz, wx, wy, wz : float
        Own position and the commanded way point beside the predefined trajectory (m), own velocity (m/s), in the axes
        of the leg.
    tx, ty, tz : float
        The candidate (m).
    cruise_mps : float
        Speed of the predefined trajectory along the leg.
    others : (m, 7) array
        Position (0-2, m, in the same axes and from the same origin), velocity (3-5, m/s), the position's std (6, m).
    count, radius_m, sigmas, drift_mps, height_m
        How many of these; the separation wanted is radius_m + sigmas times the std, which grows by drift_mps; others
        farther away in height than height_m are no matter.
    steps, step_s, speed_mps, vertical_mps, most_mps2, k1, k2
        Horizon, and the autopilot: limits and gains.
    effort_s : float
        kappa / q.
    penalty_m : float
        Metres of deviation that a whole radius of missing separation costs.
    least_m : float
        Cost of the best candidate so far: a flight that has come to as much is not flown on.
    """
    total, lack = 0.0, 0.0
    for n in range(1, steps + 1):
        dx, dy, dz = limit(tx - wx + cruise_mps * step_s, ty - wy, tz - wz, speed_mps * step_s, vertical_mps * step_s)
        wx, wy, wz = wx + dx - cruise_mps * step_s, wy + dy, wz + dz
        ax, ay, az = limit(
            regulate(wx - ux, dx / step_s - vx, k1, k2),
            regulate(wy - uy, dy / step_s - vy, k1, k2),
            regulate(wz - uz, dz / step_s - vz, k1, k2),
            most_mps2, most_mps2,
        )  # fmt: skip
        bx, by, bz = vx, vy, vz
        vx, vy, vz = limit(vx + ax * step_s, vy + ay * step_s, vz + az * step_s, speed_mps, vertical_mps)
        ux, uy, uz = ux + (vx - cruise_mps) * step_s, uy + vy * step_s, uz + vz * step_s
        bx, by, bz = vx - bx, vy - by, vz - bz
        total += sqrt(ux * ux + uy * uy + uz * uz) + effort_s * sqrt(bx * bx + by * by + bz * bz) / step_s
        ahead_s = n * step_s
        for k in range(count):
            o = others[k]
            x, y = o[0] + o[3] * ahead_s - cruise_mps * ahead_s - ux, o[1] + o[4] * ahead_s - uy
            z = o[2] + o[5] * ahead_s - uz
            if abs(z) >= height_m:
                continue
            wanted = radius_m + sigmas * (o[6] + drift_mps * ahead_s)
            square = x * x + y * y
            if square < wanted * wanted:
                lack = max(lack, 1.0 - sqrt(square) / wanted)
        if total / steps + penalty_m * lack >= least_m:
            break
    return total / steps + penalty_m * lack
