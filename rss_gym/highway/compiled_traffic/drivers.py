"""What vehicles want: to hold a lane and a speed, to follow another (IDM), to change lanes (MOBIL)."""

from math import asin, atan, cos, inf, pi, sin, sqrt, tan

from rss_gym.highway.compiled_traffic.geometry import clipped, coordinates, distance_m, heading_at, not_zero, wrapped
from rss_gym.highway.compiled_traffic.records import OBSTACLE, VEHICLE_LENGTH
from rss_gym.jit import inner

# highway-env's, of IDMVehicle and ControlledVehicle
ACC_MAX, COMFORT_ACC_MAX, COMFORT_ACC_MIN, DISTANCE_WANTED, TIME_WANTED = 6.0, 3.0, -5.0, 10.0, 1.5
POLITENESS, LANE_CHANGE_MIN_ACC_GAIN, LANE_CHANGE_MAX_BRAKING_IMPOSED, LANE_CHANGE_DELAY = 0.0, 0.2, 2.0, 1.0
KP_A, KP_HEADING, KP_LATERAL, TAU_PURSUIT, MAX_STEERING = 1.0 / 0.6, 1.0 / 0.2, 1.0 / 0.6, 0.5 * 0.2, pi / 3.0


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
