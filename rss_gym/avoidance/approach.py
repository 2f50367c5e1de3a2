"""Conflicts in the horizontal plane, and the side on which an intruder is passed."""

from rss_gym.jit import kernel
from rss_gym.tracking.approach import closest


@kernel
def side_of(x, y, vx, vy):
    """Side of the relative velocity on which the other is: the sign of the determinant of the two, never 0.

    Parameters
    ----------
    x, y : float
        Position of the other relative to the own aircraft, m.
    vx, vy : float
        Own velocity relative to the other, m/s.
    """
    return 1.0 if x * vy - y * vx > 0.0 else -1.0


@kernel
def conflict(x, y, vx, vy, radius_m, lookahead_s):
    """Whether the other is within the radius, or will be within the look-ahead; arguments as for `side_of`."""
    t, cx, cy, _ = closest(x, y, 0.0, -vx, -vy, 0.0)
    reach = radius_m * radius_m
    return x * x + y * y < reach or (0.0 < t <= lookahead_s and cx * cx + cy * cy < reach)
