"""Closest approach of a straight relative flight."""

from rss_gym.jit import kernel

TIME_MAX_S = 60.0  # a closest approach is not sought beyond this
STILL = 1e-6  # m^2/s^2: a slower relative motion has no closest approach to come


@kernel(forceinline=True)
def closest(x, y, z, vx, vy, vz):
    """Least |r + v t| over 0 <= t <= 60 s: t = -r.v / |v|^2, clipped.

    Parameters
    ----------
    x, y, z : float
        Relative position r of the other, m.
    vx, vy, vz : float
        Relative velocity v of the other, m/s.

    Returns
    -------
    tuple of float
        t (s) and the relative position r + v t then (m).
    """
    square = vx * vx + vy * vy + vz * vz
    t = 0.0
    if square > STILL:
        t = min(max(-(x * vx + y * vy + z * vz) / square, 0.0), TIME_MAX_S)
    return t, x + vx * t, y + vy * t, z + vz * t
