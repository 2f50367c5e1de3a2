"""highway-env's traffic, compiled: what a decision's ticks do to vehicles on straight and sine lanes.

The equations, their order and the constants are highway-env's (`road.road`, `vehicle.behavior`, `vehicle.controller`,
`vehicle.kinematics`, `utils.are_polygons_intersecting`); only the last bit of a trigonometric function can differ.
Scores are driven by highway-env itself; trainings, which need many times as many decisions, by this.
"""

from math import asin, atan, cos, hypot, inf, pi, sin, sqrt, tan

import numpy as np

from rss_gym.jit import inner, kernel

f8, i8, b1 = np.float64, np.int64, np.bool_

CONNECTED_MAX = 8  # lanes before and after a lane
LANE = np.dtype(
    [
        ("start_m", f8, 2), ("direction", f8, 2), ("heading", f8), ("length_m", f8), ("width_m", f8),
        ("speed_limit_mps", f8), ("forbidden", b1),
        ("amplitude_m", f8), ("pulsation", f8), ("phase", f8),  # of a sine lane, else zero
        ("left", i8), ("right", i8),  # the lanes beside it on its road; -1: none
        ("next", i8, CONNECTED_MAX), ("next_count", i8),  # that a vehicle may go on to: the nearest is taken
        ("connected", i8, CONNECTED_MAX), ("offset_m", f8, CONNECTED_MAX), ("connected_count", i8),  # itself first
    ]
)  # fmt: skip
CONTROLLED, IDM, OBSTACLE = range(3)
VEHICLE = np.dtype(
    [
        ("position_m", f8, 2), ("heading", f8), ("speed_mps", f8), ("length_m", f8), ("width_m", f8),
        ("kind", i8), ("lane", i8), ("target_lane", i8), ("target_mps", f8), ("exponent", f8), ("timer_s", f8),
        ("steering", f8), ("acceleration", f8), ("crashed", b1), ("checks", b1), ("hit", b1), ("impact_m", f8, 2),
    ]
)  # fmt: skip

# highway-env's: of IDMVehicle, ControlledVehicle, Vehicle and the lanes
ACC_MAX, COMFORT_ACC_MAX, COMFORT_ACC_MIN, DISTANCE_WANTED, TIME_WANTED = 6.0, 3.0, -5.0, 10.0, 1.5
POLITENESS, LANE_CHANGE_MIN_ACC_GAIN, LANE_CHANGE_MAX_BRAKING_IMPOSED, LANE_CHANGE_DELAY = 0.0, 0.2, 2.0, 1.0
KP_A, KP_HEADING, KP_LATERAL, TAU_PURSUIT, MAX_STEERING = 1.0 / 0.6, 1.0 / 0.2, 1.0 / 0.6, 0.5 * 0.2, pi / 3.0
MAX_SPEED, VEHICLE_LENGTH = 40.0, 5.0


@kernel
def drive(vehicles, agent, lanes, ticks, tick_s, states, roads):
    """Drive for some ticks.

    Parameters
    ----------
    vehicles : (n,) VEHICLE
        In the order of the road, the objects last.
    agent : int
        Its row.
    lanes : (m,) LANE
    ticks : int
    tick_s : float
    states : (ticks, n, 4) array
        Written: x (m), y (m), heading (rad) and speed (m/s) after each tick.
    roads : (ticks, 3) array
        Written: direction of the agent's lane (cosine, sine), and how far (m) the agent is to the right of its centre.
    """
    for t in range(ticks):
        for i in range(len(vehicles)):
            if vehicles[i].kind == CONTROLLED:
                act_controlled(vehicles[i], lanes)
            elif vehicles[i].kind == IDM:
                act_idm(i, vehicles, lanes)
        for i in range(len(vehicles)):
            if vehicles[i].kind != OBSTACLE:
                move(vehicles[i], lanes, tick_s)
        for i in range(len(vehicles)):
            if vehicles[i].kind != OBSTACLE:
                for j in range(i + 1, len(vehicles)):
                    collide(vehicles[i], vehicles[j], tick_s)
        for i in range(len(vehicles)):
            v = vehicles[i]
            states[t, i, 0], states[t, i, 1] = v.position_m[0], v.position_m[1]
            states[t, i, 2], states[t, i, 3] = v.heading, v.speed_mps
        v = vehicles[agent]
        along_m, roads[t, 2] = coordinates(lanes[v.lane], v.position_m)
        heading = heading_at(lanes[v.lane], along_m)
        roads[t, 0], roads[t, 1] = cos(heading), sin(heading)


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


@inner
def follow_road(v, lanes):
    """At the end of the target lane, go on to the next one."""
    lane = lanes[v.target_lane]
    along_m, _ = coordinates(lane, v.position_m)
    if along_m <= lane.length_m - VEHICLE_LENGTH / 2.0 or lane.next_count == 0:
        return
    x = lane.start_m[0] + along_m * lane.direction[0]
    y = lane.start_m[1] + along_m * lane.direction[1]
    across_m = lane.amplitude_m * sin(lane.pulsation * along_m + lane.phase)
    projected_m = (x - across_m * lane.direction[1], y + across_m * lane.direction[0])
    nearest, nearest_m = lane.next[0], inf
    for k in range(lane.next_count):
        d = distance_m(lanes[lane.next[k]], projected_m)
        if d < nearest_m:
            nearest, nearest_m = lane.next[k], d
    v.target_lane = nearest


@inner
def steering(v, lanes):
    """The steering angle that leads to the target lane."""
    lane = lanes[v.target_lane]
    along_m, right_m = coordinates(lane, v.position_m)
    future = heading_at(lane, along_m + v.speed_mps * TAU_PURSUIT)
    command = asin(clipped(-KP_LATERAL * right_m / not_zero(v.speed_mps), -1.0, 1.0))
    reference = future + clipped(command, -pi / 4.0, pi / 4.0)
    rate = KP_HEADING * wrapped(reference - v.heading)
    slip = asin(clipped(VEHICLE_LENGTH / 2.0 / not_zero(v.speed_mps) * rate, -1.0, 1.0))
    return clipped(atan(2.0 * tan(slip)), -MAX_STEERING, MAX_STEERING)


@inner
def act_controlled(v, lanes):
    """Hold the target lane and speed."""
    follow_road(v, lanes)
    v.steering = steering(v, lanes)
    v.acceleration = KP_A * (v.target_mps - v.speed_mps)


@inner
def act_idm(i, vehicles, lanes):
    """The intelligent driver model for the speed, MOBIL for the lane."""
    v = vehicles[i]
    if v.crashed:
        return
    follow_road(v, lanes)
    change_lane(i, vehicles, lanes)
    v.steering = steering(v, lanes)
    front, _ = neighbours(i, v.lane, vehicles, lanes)
    wanted = idm(v.exponent, i, front, vehicles, lanes)
    if v.lane != v.target_lane:
        front, _ = neighbours(i, v.target_lane, vehicles, lanes)
        wanted = min(wanted, idm(v.exponent, i, front, vehicles, lanes))
    v.acceleration = clipped(wanted, -ACC_MAX, ACC_MAX)


@inner
def neighbours(i, lane_number, vehicles, lanes):
    """Who is before and behind vehicle i on a lane and those connected with it; -1: nobody."""
    lane = lanes[lane_number]
    own_m, _ = coordinates(lane, vehicles[i].position_m)
    front, rear, front_m, rear_m = -1, -1, inf, -inf
    for j in range(len(vehicles)):
        if j == i:
            continue
        for k in range(lane.connected_count):
            searched = lanes[lane.connected[k]]
            along_m, right_m = coordinates(searched, vehicles[j].position_m)
            if not (
                abs(right_m) <= searched.width_m / 2.0 + 1.0
                and -VEHICLE_LENGTH <= along_m
                and along_m < searched.length_m + VEHICLE_LENGTH
            ):
                continue
            along_m += lane.offset_m[k]
            if own_m <= along_m and along_m <= front_m:
                front, front_m = j, along_m
            if along_m < own_m and along_m > rear_m:
                rear, rear_m = j, along_m
            break
    return front, rear


@inner
def gap_wanted_m(ego, front):
    """The gap that the intelligent driver model wants."""
    c, s = cos(ego.heading), sin(ego.heading)
    x = ego.speed_mps * c - front.speed_mps * cos(front.heading)
    y = ego.speed_mps * s - front.speed_mps * sin(front.heading)
    closing_mps = x * c + y * s
    braking = 2.0 * sqrt(-COMFORT_ACC_MAX * COMFORT_ACC_MIN)
    return DISTANCE_WANTED + ego.speed_mps * TIME_WANTED + ego.speed_mps * closing_mps / braking


@inner
def ahead_m(ego, other, lanes):
    """How far another is ahead along the own lane."""
    there_m, _ = coordinates(lanes[ego.lane], other.position_m)
    here_m, _ = coordinates(lanes[ego.lane], ego.position_m)
    return there_m - here_m


@inner
def idm(exponent, i, front, vehicles, lanes):
    """Acceleration of vehicle i behind another by the intelligent driver model; 0 for nobody."""
    if i < 0 or vehicles[i].kind == OBSTACLE:
        return 0.0
    ego = vehicles[i]
    target_mps = clipped(ego.target_mps, 0.0, lanes[ego.lane].speed_limit_mps)
    found = COMFORT_ACC_MAX * (1.0 - (max(ego.speed_mps, 0.0) / abs(not_zero(target_mps))) ** exponent)
    if front >= 0:
        d = ahead_m(ego, vehicles[front], lanes)
        found -= COMFORT_ACC_MAX * (gap_wanted_m(ego, vehicles[front]) / not_zero(d)) ** 2
    return found


@inner
def change_lane(i, vehicles, lanes):
    """Give up a change if another has begun the same before one, or begin one."""
    v = vehicles[i]
    if v.lane != v.target_lane:
        target = v.target_lane
        if beside(lanes, v.lane, target):
            for j in range(len(vehicles)):
                other = vehicles[j]
                if j == i or other.kind == OBSTACLE or other.lane == target or other.target_lane != target:
                    continue
                d = ahead_m(v, other, lanes)
                if 0.0 < d and d < gap_wanted_m(v, other):
                    v.target_lane = v.lane
                    break
        return
    if v.timer_s <= LANE_CHANGE_DELAY:
        return
    v.timer_s = 0.0
    lane = lanes[v.lane]
    for side in (lane.left, lane.right):
        if side < 0 or lanes[side].forbidden:
            continue
        along_m, right_m = coordinates(lanes[side], v.position_m)
        if abs(right_m) > 2.0 * lanes[side].width_m or along_m < 0.0:
            continue
        if along_m >= lanes[side].length_m + VEHICLE_LENGTH or abs(v.speed_mps) < 1.0:
            continue
        if mobil(i, side, vehicles, lanes):
            v.target_lane = side


@inner
def beside(lanes, lane, target):
    """Whether two lanes are of one road."""
    at = lane
    while at >= 0:
        if at == target:
            return True
        at = lanes[at].left
    at = lane
    while at >= 0:
        if at == target:
            return True
        at = lanes[at].right
    return False


@inner
def mobil(i, side, vehicles, lanes):
    """Whether a change of lane gains more acceleration than it costs, and does not make who follows brake."""
    v = vehicles[i]
    front, rear = neighbours(i, side, vehicles, lanes)
    rear_a = idm(v.exponent, rear, front, vehicles, lanes)
    rear_then_a = idm(v.exponent, rear, i, vehicles, lanes)
    if rear_then_a < -LANE_CHANGE_MAX_BRAKING_IMPOSED:
        return False
    old_front, old_rear = neighbours(i, v.lane, vehicles, lanes)
    then_a = idm(v.exponent, i, front, vehicles, lanes)
    now_a = idm(v.exponent, i, old_front, vehicles, lanes)
    old_rear_a = idm(v.exponent, old_rear, i, vehicles, lanes)
    old_rear_then_a = idm(v.exponent, old_rear, old_front, vehicles, lanes)
    gain = then_a - now_a + POLITENESS * (rear_then_a - rear_a + old_rear_then_a - old_rear_a)
    return gain >= LANE_CHANGE_MIN_ACC_GAIN


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
