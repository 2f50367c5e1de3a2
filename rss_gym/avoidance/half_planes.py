"""The velocity nearest to a preferred one that keeps to half-planes and a speed limit: the linear programs of ORCA.

Incremental algorithm of de Berg et al., "Computational Geometry", ch. 4, in the form of van den Berg, Guy, Lin and
Manocha, "Reciprocal n-body collision avoidance" (ISRR 2009, published 2011), sec. 5. A row of `planes` (m, 4) is a
point and a unit direction (px, py, dx, dy); velocities with dx (y - py) - dy (x - px) >= 0 are allowed.
"""

from math import sqrt

import numpy as np

from rss_gym.jit import kernel

TINY = 1e-5  # as in the library RVO2: lines this near to parallel count as parallel
TINY_M2 = 1e-18  # squared length without a direction


@kernel
def short_of(planes, n, x, y):
    """How far (x, y) is outside half-plane n, m/s; negative inside."""
    return planes[n, 2] * (planes[n, 1] - y) - planes[n, 3] * (planes[n, 0] - x)


@kernel
def along_line(planes, n, speed_mps, x, y, far):
    """On the edge of half-plane n, within those before it and the speed: the point nearest to (x, y), or farthest.

    Returns
    -------
    tuple
        Whether there is one, and its coordinates.
    """
    px, py, dx, dy = planes[n, 0], planes[n, 1], planes[n, 2], planes[n, 3]
    middle = px * dx + py * dy
    discriminant = middle * middle + speed_mps * speed_mps - px * px - py * py
    if discriminant < 0.0:
        return False, x, y
    low, high = -middle - sqrt(discriminant), -middle + sqrt(discriminant)
    for i in range(n):
        denominator = dx * planes[i, 3] - dy * planes[i, 2]
        numerator = planes[i, 2] * (py - planes[i, 1]) - planes[i, 3] * (px - planes[i, 0])
        if abs(denominator) <= TINY:
            if numerator < 0.0:
                return False, x, y
            continue
        t = numerator / denominator
        if denominator >= 0.0:
            high = min(high, t)
        else:
            low = max(low, t)
        if low > high:
            return False, x, y
    if far:
        t = high if x * dx + y * dy > 0.0 else low
    else:
        t = min(max(dx * (x - px) + dy * (y - py), low), high)
    return True, px + t * dx, py + t * dy


@kernel
def within(planes, count, speed_mps, x, y, far):
    """Nearest allowed velocity to (x, y), or the farthest allowed one in that unit direction.

    Returns
    -------
    tuple
        The number of the half-plane that cannot be kept, `count` if all can, and the velocity.
    """
    vx, vy = x, y
    square = x * x + y * y
    if far:
        vx, vy = x * speed_mps, y * speed_mps
    elif square > speed_mps * speed_mps:
        scale = speed_mps / sqrt(square)
        vx, vy = x * scale, y * scale
    for n in range(count):
        if short_of(planes, n, vx, vy) > 0.0:
            found, nx, ny = along_line(planes, n, speed_mps, x, y, far)
            if not found:
                return n, vx, vy
            vx, vy = nx, ny
    return count, vx, vy


@kernel
def nearest(planes, count, speed_mps, x, y, room):
    """The velocity nearest to (x, y) within the first `count` half-planes and the speed.

    Where they exclude each other, the velocity that is least far outside the worst of them. `room` (count, 4) is
    scratch.

    Returns
    -------
    tuple of float
        The velocity, m/s.
    """
    failed, vx, vy = within(planes, count, speed_mps, x, y, False)
    worst = 0.0
    for n in range(failed, count):
        if short_of(planes, n, vx, vy) <= worst:
            continue
        # The edges along which plane n and an earlier one are missed by as much.
        m = 0
        dx, dy = planes[n, 2], planes[n, 3]
        for i in range(n):
            ex, ey = planes[i, 2], planes[i, 3]
            determinant = dx * ey - dy * ex
            if abs(determinant) <= TINY:
                if dx * ex + dy * ey > 0.0:
                    continue
                room[m, 0], room[m, 1] = 0.5 * (planes[n, 0] + planes[i, 0]), 0.5 * (planes[n, 1] + planes[i, 1])
            else:
                t = (ex * (planes[n, 1] - planes[i, 1]) - ey * (planes[n, 0] - planes[i, 0])) / determinant
                room[m, 0], room[m, 1] = planes[n, 0] + t * dx, planes[n, 1] + t * dy
            ex, ey = ex - dx, ey - dy
            length = sqrt(ex * ex + ey * ey)
            room[m, 2], room[m, 3] = ex / length, ey / length
            m += 1
        kept, nx, ny = within(room, m, speed_mps, -dy, dx, True)
        if kept == m:  # else only rounding stands in the way, and the velocity so far is the answer
            vx, vy = nx, ny
        worst = short_of(planes, n, vx, vy)
    return vx, vy


@kernel
def put_plane(planes, n, x, y, normal_x, normal_y):
    """Write half-plane n: velocities on the side of (x, y) that the normal, of any length but zero, points to."""
    length = sqrt(normal_x * normal_x + normal_y * normal_y)
    planes[n, 0], planes[n, 1] = x, y
    planes[n, 2], planes[n, 3] = normal_y / length, -normal_x / length


def nearest_velocity(planes, speed_mps, preferred_mps):
    """`nearest` on arrays.

    Parameters
    ----------
    planes : (m, 4) array
        Points and unit directions.
    speed_mps : float
        Speed limit.
    preferred_mps : (2,) array

    Returns
    -------
    (2,) array
    """
    planes = np.ascontiguousarray(planes, dtype=np.float64).reshape(-1, 4)
    x, y = preferred_mps
    return np.array(nearest(planes, len(planes), float(speed_mps), float(x), float(y), np.zeros_like(planes)))
