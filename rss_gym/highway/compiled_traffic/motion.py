"""How vehicles move, and how they collide."""

from math import atan, cos, hypot, inf, sin, sqrt, tan

import numpy as np

from rss_gym.highway.compiled_traffic.geometry import coordinates, heading_at, wrapped
from rss_gym.highway.compiled_traffic.records import IDM, OBSTACLE, VEHICLE_LENGTH
from rss_gym.jit import inner

MAX_SPEED = 40.0  # highway-env's, m/s, either way


@inner
def move(v, lanes, tick_s):
    """A step of the bicycle model."""
    if v.kind == IDM:
        v.timer_s += tick_s
    if v.crashed:
        v.steering, v.acceleration = 0.0, -1.0 * v.speed_mps
    if v.speed_mps > MAX_SPEED:
        v.acceleration = min(v.acceleration, MAX_SPEED - v.speed_mps)
    elif v.speed_mps < -MAX_SPEED:
        v.acceleration = max(v.acceleration, -MAX_SPEED - v.speed_mps)
    slip = atan(0.5 * tan(v.steering))
    v.position_m[0] += v.speed_mps * cos(v.heading + slip) * tick_s
    v.position_m[1] += v.speed_mps * sin(v.heading + slip) * tick_s
    if v.hit:
        v.position_m[0] += v.impact_m[0]
        v.position_m[1] += v.impact_m[1]
        v.crashed, v.hit = True, False
    v.heading += v.speed_mps * sin(slip) / (VEHICLE_LENGTH / 2.0) * tick_s
    v.speed_mps += v.acceleration * tick_s
    least = inf
    for k in range(len(lanes)):
        along_m, right_m = coordinates(lanes[k], v.position_m)
        d = abs(right_m) + max(along_m - lanes[k].length_m, 0.0) + max(0.0 - along_m, 0.0)
        d += abs(wrapped(v.heading - heading_at(lanes[k], along_m)))
        if d < least:
            least, v.lane = d, k


@inner
def corners(v, out):
    """The corners of a vehicle's rectangle, the first one again at the end."""
    c, s = cos(v.heading), sin(v.heading)
    half_m, across_m = v.length_m / 2.0, v.width_m / 2.0
    for k in range(5):
        x = half_m if k in (2, 3) else -half_m
        y = across_m if k in (1, 2) else -across_m
        out[k, 0], out[k, 1] = x * c - y * s + v.position_m[0], x * s + y * c + v.position_m[1]


@inner
def extent(polygon, x, y):
    """Ends of a polygon's shadow on a direction."""
    low, high = inf, -inf
    for k in range(5):
        p = polygon[k, 0] * x + polygon[k, 1] * y
        low, high = min(low, p), max(high, p)
    return low, high


@inner
def collide(v, other, tick_s):
    """Two vehicles that touch, or will within a tick, crash."""
    if not (v.checks or other.checks):
        return
    apart_m = hypot(other.position_m[0] - v.position_m[0], other.position_m[1] - v.position_m[1])
    diagonals_m = sqrt(v.length_m**2 + v.width_m**2) + sqrt(other.length_m**2 + other.width_m**2)
    if apart_m > diagonals_m / 2.0 + v.speed_mps * tick_s:
        return
    polygons = np.empty((2, 5, 2))
    corners(v, polygons[0])
    corners(other, polygons[1])
    ahead_x = (v.speed_mps * cos(v.heading) - other.speed_mps * cos(other.heading)) * tick_s
    ahead_y = (v.speed_mps * sin(v.heading) - other.speed_mps * sin(other.heading)) * tick_s
    touches, will, least_m, axis_x, axis_y = True, True, inf, 0.0, 0.0
    for p in range(2):
        for k in range(4):
            x = polygons[p, k, 1] - polygons[p, k + 1, 1]
            y = polygons[p, k + 1, 0] - polygons[p, k, 0]
            norm = hypot(x, y)
            x, y = x / norm, y / norm
            low, high = extent(polygons[0], x, y)
            other_low, other_high = extent(polygons[1], x, y)
            if (other_low - high if low < other_low else low - other_high) > 0.0:
                touches = False
            shift = x * ahead_x + y * ahead_y
            if shift < 0.0:
                low += shift
            else:
                high += shift
            d = other_low - high if low < other_low else low - other_high
            if d > 0.0:
                will = False
            if not touches and not will:
                break
            if abs(d) < least_m:
                least_m = abs(d)
                dx, dy = v.position_m[0] - other.position_m[0], v.position_m[1] - other.position_m[1]
                sign = 1.0 if dx * x + dy * y > 0.0 else -1.0
                axis_x, axis_y = sign * x, sign * y
    if will:
        if other.kind == OBSTACLE:
            v.hit, v.impact_m[0], v.impact_m[1] = True, least_m * axis_x, least_m * axis_y
        else:
            v.hit, v.impact_m[0], v.impact_m[1] = True, least_m * axis_x / 2.0, least_m * axis_y / 2.0
            other.hit = True
            other.impact_m[0], other.impact_m[1] = -least_m * axis_x / 2.0, -least_m * axis_y / 2.0
    if touches:
        v.crashed = other.crashed = True
