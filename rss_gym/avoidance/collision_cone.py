"""Collision-cone control barrier function: the half-plane of velocities that keep the relative one out of the cone.

Thontepu et al., "Collision cone control barrier functions for kinematic obstacle avoidance in UGVs" (2022,
arXiv 2209.11524), and Tayal et al. for UAVs (arXiv 2303.15871). With p the other's relative position, v the own
velocity relative to it, s = sqrt(|p|^2 - R^2): h = |v| s - p . v >= 0 outside the cone, and a = (u - v_A) / response
has to keep dh/dt >= -alpha h. A barrier on the distance alone can only push back along p, so near a head-on it yields
no side.
"""

from math import sqrt

from rss_gym.avoidance.half_planes import put_plane
from rss_gym.jit import kernel

TINY = 1e-9


@kernel
def half_plane(x, y, vx, vy, own_x, own_y, radius_m, rate_ps, response_s, planes, n):
    """Write the barrier's half-plane for the commanded velocity into row n of `planes`.

    Parameters
    ----------
    x, y : float
        Position of the other relative to the own aircraft, m.
    vx, vy : float
        Own velocity relative to the other, m/s.
    own_x, own_y : float
        Own velocity, m/s.
    radius_m : float
        R.
    rate_ps : float
        alpha: the share of the barrier that may be lost in a second.
    response_s : float
        Time in which the autopilot takes up a commanded velocity.
    planes, n
        See `half_planes`.
    """
    distance, speed = sqrt(x * x + y * y), sqrt(vx * vx + vy * vy)
    if distance <= radius_m or speed <= TINY:
        # Within the radius there is no cone: leave, the faster the deeper.
        away = (radius_m - distance) * rate_ps
        nx, ny = (-x / distance, -y / distance) if distance > TINY else (0.0, 1.0)
        put_plane(planes, n, own_x - vx + away * nx, own_y - vy + away * ny, nx, ny)
        return
    tangent = sqrt(distance * distance - radius_m * radius_m)
    ux, uy = vx / speed, vy / speed
    along = x * ux + y * uy
    barrier = speed * (tangent - along)
    drift = speed * speed * (1.0 - along / tangent)
    gx, gy = tangent * ux - x, tangent * uy - y
    square = gx * gx + gy * gy
    if square <= TINY:
        gx, gy, square = -uy, ux, 1.0
    lack = response_s * (rate_ps * barrier + drift)
    put_plane(planes, n, own_x - lack * gx / square, own_y - lack * gy / square, gx, gy)
