"""Optimal reciprocal collision avoidance (ORCA) in the plane.

van den Berg, Guy, Lin and Manocha, "Reciprocal n-body collision avoidance" (ISRR 2009, published 2011), sec. 4: the
velocity obstacle VO^tau of two discs, the least change u that leads out of it, the half-plane through v_A + share u.
"""

from math import sqrt

from rss_gym.jit import kernel

TINY_MPS = 1e-9


@kernel
def half_plane(x, y, vx, vy, own_x, own_y, radius_m, lookahead_s, period_s, responsibility, planes, n):
    """Write ORCA^tau of one other into row n of `planes`.

    Parameters
    ----------
    x, y : float
        Position of the other relative to the own aircraft, m.
    vx, vy : float
        Own velocity relative to the other, m/s.
    own_x, own_y : float
        Own velocity, m/s.
    radius_m, lookahead_s : float
        Sum of the radii, and tau.
    period_s : float
        Within the radius already, the discs are to be apart after this time.
    responsibility : float
        Share of u that is taken: 0.5 if the other does the same, 1 if it does not react.
    planes, n
        See `half_planes`.
    """
    square, reach = x * x + y * y, radius_m * radius_m
    horizon_s = lookahead_s if square > reach else period_s
    wx, wy = vx - x / horizon_s, vy - y / horizon_s  # from the centre of the cut-off disc
    towards = wx * x + wy * y
    w2 = wx * wx + wy * wy
    if square <= reach or (towards < 0.0 and towards * towards > reach * w2):
        w = sqrt(w2)
        nx, ny = (wx / w, wy / w) if w > TINY_MPS else (0.0, 1.0)
        grow = radius_m / horizon_s - w
        dx, dy, ux, uy = ny, -nx, grow * nx, grow * ny
    else:
        leg = sqrt(square - reach)
        sign = 1.0 if x * wy - y * wx > 0.0 else -1.0
        dx, dy = (sign * x * leg - y * radius_m) / square, (x * radius_m + sign * y * leg) / square
        dot = vx * dx + vy * dy
        ux, uy = dot * dx - vx, dot * dy - vy
    planes[n, 0], planes[n, 1] = own_x + responsibility * ux, own_y + responsibility * uy
    planes[n, 2], planes[n, 3] = dx, dy
