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
def conflict(x, y, vx, vy, radius_m, lookahead_s):
    """Whether the other is within the radius, or will be within the look-ahead; arguments as for `closest`."""
    t, cx, cy = closest(x, y, vx, vy)
    reach = radius_m * radius_m
    return x * x + y * y < reach or (0.0 < t <= lookahead_s and cx * cx + cy * cy < reach)
