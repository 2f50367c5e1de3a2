"""Where things are on lanes, and angles."""

from math import atan, cos, pi, sin

from rss_gym.jit import inner


@inner(forceinline=True)
def coordinates(lane, position_m):
    """Where a position is along a lane and to the right of its centre (m)."""
    x, y = position_m[0] - lane.start_m[0], position_m[1] - lane.start_m[1]
    along_m = x * lane.direction[0] + y * lane.direction[1]
    right_m = y * lane.direction[0] - x * lane.direction[1]
    return along_m, right_m - lane.amplitude_m * sin(lane.pulsation * along_m + lane.phase)


@inner(forceinline=True)
def heading_at(lane, along_m):
    """The heading (rad) of a lane."""
    slope = lane.amplitude_m * lane.pulsation * cos(lane.pulsation * along_m + lane.phase)
    return lane.heading + atan(slope)


@inner(forceinline=True)
def wrapped(angle):
    """An angle in [-pi, pi)."""
    return ((angle + pi) % (2.0 * pi)) - pi


@inner(forceinline=True)
def not_zero(x):
    """A value to divide by."""
    if abs(x) > 1e-2:
        return x
    return 1e-2 if x >= 0.0 else -1e-2


@inner(forceinline=True)
def clipped(x, low, high):
    """Within two limits."""
    return min(max(x, low), high)


@inner(forceinline=True)
def distance_m(lane, position_m):
    """L1 distance of a position from a lane."""
    along_m, right_m = coordinates(lane, position_m)
    return abs(right_m) + max(along_m - lane.length_m, 0.0) + max(0.0 - along_m, 0.0)
