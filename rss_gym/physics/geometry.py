"""Vectors, and the separation of two points in straight relative motion, in closed form."""

from math import sqrt

from rss_gym.jit import kernel


@kernel(forceinline=True)
def assign(to, source):
    """Copy the three components of a vector; a slice assignment costs ten times as much."""
    to[0], to[1], to[2] = source[0], source[1], source[2]


@kernel(inline="always")
def zero(to):
    """Set the three components of a vector to zero."""
    to[0] = to[1] = to[2] = 0.0


@kernel(inline="always")
def turned(x, y, c, s):
    """A horizontal vector turned to the right by the angle of cosine `c` and sine `s`."""
    return x * c + y * s, y * c - x * s


@kernel
def entry_s(x, y, z, vx, vy, vz, radius_m):
    """Time >= 0 at which |r + v t| first is `radius_m`, s; without one, that of the least separation."""
    approach = -(x * vx + y * vy + z * vz)
    speed_squared = vx * vx + vy * vy + vz * vz
    if speed_squared == 0.0:
        return 0.0
    discriminant = approach * approach - speed_squared * (x * x + y * y + z * z - radius_m * radius_m)
    return max(0.0, (approach - sqrt(max(discriminant, 0.0))) / speed_squared)


@kernel(inline="always")
def least_square_separation(x, y, z, vx, vy, vz, period_s):
    """Least |r + v t|^2 over 0 <= t <= period_s, m^2: r the relative position, v the relative velocity."""
    approach = -(x * vx + y * vy + z * vz)
    speed_squared = vx * vx + vy * vy + vz * vz
    t = 0.0
    if approach > 0.0:
        t = period_s if approach >= speed_squared * period_s else approach / speed_squared
    x, y, z = x + vx * t, y + vy * t, z + vz * t
    return x * x + y * y + z * z


@kernel(inline="always")
def enters_cylinder(x, y, z, vx, vy, vz, period_s, radius_m, half_height_m):
    """Whether at one instant of 0 <= t <= period_s the horizontal and the vertical separation are both too small."""
    # Vertical: |z + vz t| < half height.
    if vz == 0.0:
        if abs(z) >= half_height_m:
            return False
        enter, leave = 0.0, period_s
    else:
        one, two = (-half_height_m - z) / vz, (half_height_m - z) / vz
        enter, leave = max(0.0, min(one, two)), min(period_s, max(one, two))
    # Horizontal: a t^2 + 2 b t + c < 0.
    a, b, c = vx * vx + vy * vy, x * vx + y * vy, x * x + y * y - radius_m * radius_m
    if a == 0.0:
        return c < 0.0 and enter < leave
    discriminant = b * b - a * c
    if discriminant <= 0.0:
        return False
    root = sqrt(discriminant)
    return max(enter, (-b - root) / a) < min(leave, (-b + root) / a)
