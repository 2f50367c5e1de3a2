"""The orthogonal rule, (43)-(45), in closed form.

With r = u_j - u_i, a = r . v_i / |v_i| and p = r - a v_i / |v_i|, the point of (45) is
u_j' = u_i + a v_i / |v_i| + sqrt(S^2 - a^2) p / |p|, a displacement of sqrt(S^2 - a^2) - |p| along p.
"""

from math import sqrt

from rss_gym.jit import kernel

TINY_M = 1e-9


@kernel
def side_of(rx, ry, rz, vx, vy, vz):
    """The side of U_i on which U_j is: p / |p|, a unit vector at right angles to v_i.

    Parameters
    ----------
    rx, ry, rz : float
        u_j - u_i, m, in axes whose z is up and whose y is to the right of x.
    vx, vy, vz : float
        Velocity of U_i, m/s.

    Notes
    -----
    Edges: p = 0 is the right of v_i in the horizontal plane; v_i = 0 is along r, and to the right if r = 0 as well.
    """
    square = vx * vx + vy * vy + vz * vz
    share = (rx * vx + ry * vy + rz * vz) / square if square > 0.0 else 0.0
    px, py, pz = rx - share * vx, ry - share * vy, rz - share * vz
    p, level = sqrt(px * px + py * py + pz * pz), sqrt(vx * vx + vy * vy)
    if p > TINY_M:
        return px / p, py / p, pz / p
    if level > 0.0:
        return -vy / level, vx / level, 0.0
    return 0.0, 1.0, 0.0


@kernel
def displacement(rx, ry, rz, vx, vy, vz, radius_m, side_x, side_y, side_z):
    """Smallest displacement of u_j, at right angles to v_i, that puts it on the edge of the zone round u_i.

    Parameters
    ----------
    rx, ry, rz : float
        u_j - u_i, m, in axes whose z is up and whose y is to the right of x.
    vx, vy, vz : float
        Velocity of U_i, m/s.
    radius_m : float
        S.
    side_x, side_y, side_z : float
        Unit vector of the side of U_i to be on, or zero for the nearer one.

    Returns
    -------
    tuple of float
        The displacement (m); zeros when nothing is to be done.

    Notes
    -----
    Edges: outside the zone (43) or beyond its reach (|a| > S) no change; see `side_of` for p = 0 and v_i = 0. Outside
    the zone on the other side, with |a| < S, the way back would lead past U_i, so the side is held (this halves the
    collisions).
    """
    speed = sqrt(vx * vx + vy * vy + vz * vz)
    ux = uy = uz = a = 0.0
    if speed > 0.0:
        ux, uy, uz = vx / speed, vy / speed, vz / speed
        a = rx * ux + ry * uy + rz * uz
    px, py, pz = rx - a * ux, ry - a * uy, rz - a * uz
    crossed = px * side_x + py * side_y + pz * side_z < 0.0
    outside = rx * rx + ry * ry + rz * rz >= radius_m * radius_m
    if abs(a) >= radius_m or (outside and not crossed):
        return 0.0, 0.0, 0.0
    nx, ny, nz = side_of(rx, ry, rz, vx, vy, vz)
    if crossed:
        # The part of the side at right angles to v_i.
        along = side_x * ux + side_y * uy + side_z * uz
        kx, ky, kz = side_x - along * ux, side_y - along * uy, side_z - along * uz
        length = sqrt(kx * kx + ky * ky + kz * kz)
        if length > TINY_M:
            nx, ny, nz = kx / length, ky / length, kz / length
    reach = sqrt(radius_m * radius_m - a * a)
    return reach * nx - px, reach * ny - py, reach * nz - pz
