"""The closest approach of straight relative flight."""

from rss_gym.jit import kernel

TIME_MAX_S = 60.0
SLOW_MPS = 0.1  # a relative velocity below this counts as none


@kernel(forceinline=True)
def closest(x, y, z, vx, vy, vz):
    """Time of the closest approach within [0, 60] s, and the relative position then.

    t = -r . v / |v|^2, the minimum of |r + v t|.

    Parameters
    ----------
    x, y, z, vx, vy, vz : float
        Relative position (m) and velocity (m/s).

    Returns
    -------
    tuple of float
        t (s), x, y, z (m).
    """
    square = vx * vx + vy * vy + vz * vz
    t = 0.0
    if square > SLOW_MPS * SLOW_MPS:
        t = min(max(-(x * vx + y * vy + z * vz) / square, 0.0), TIME_MAX_S)
    return t, x + vx * t, y + vy * t, z + vz * t
