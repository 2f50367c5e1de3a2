"""Closest approach in the horizontal plane at constant velocities, and the side on which an intruder is passed."""

from rss_gym.jit import kernel


@kernel
def closest(x, y, vx, vy):
    """Time and place of the closest approach, the place relative to the own aircraft.

    Parameters
    ----------
    x, y : float
        Position of the other relative to the own aircraft, m.
    vx, vy : float
        Own velocity relative to the other, m/s.

    Returns
    -------
    tuple of float
        Time (s), negative once it is past and 0 without relative motion, and the other's relative position then (m).
    """
    square = vx * vx + vy * vy
    t = (x * vx + y * vy) / square if square > 0.0 else 0.0
    return t, x - vx * t, y - vy * t


@kernel
def side_of(x, y, vx, vy):
    """Side of the relative velocity on which the other is: the sign of the determinant of the two, never 0."""
    return 1.0 if x * vy - y * vx > 0.0 else -1.0


@kernel
def keep(side, x, y, vx, vy, radius_m, lookahead_s):
    """The side to hold: the one held while the wanted velocity leads to a conflict, the nearer one at its start, 0 without.

    Near a head-on the sign of a noisy offset changes from decision to decision; a velocity chosen anew each time then
    goes to neither side.

    Parameters
    ----------
    side : float
        Held so far; 0 none.
    x, y, vx, vy : float
        As for `closest`, with the wanted velocity.
    radius_m, lookahead_s : float
        A conflict is an approach closer than this within this time.
    """
    t, cx, cy = closest(x, y, vx, vy)
    if x * x + y * y >= radius_m * radius_m and (t <= 0.0 or t > lookahead_s or cx * cx + cy * cy >= radius_m * radius_m):
        return 0.0
    return side if side != 0.0 else side_of(x, y, vx, vy)
