"""Draws one encounter: predefined trajectories built from the closest approach backwards.

The origin is the planned closest approach of the first intruder. All paths are level polylines, each leg flown at a
constant cruise speed; a draw that breaks a stated limit (closing speed, time, start range, an earlier and closer
approach) is drawn again.
"""

from math import pi, sqrt

import numpy as np

from rss_gym.jit import inner
from rss_gym.physics.elementary import cos, sin
from rss_gym.physics.geometry import least_square_separation, turned
from rss_gym.physics.random import uniform
from rss_gym.streams import MAX_INTRUDERS, STREAM_SAMPLER

ATTEMPTS = 20000
FAMILY_ATTEMPTS = 1000  # then the family is drawn again: the agent's path, once laid, may leave no room for it
RESTARTS = 16  # of an encounter whose first intruders leave no room for a later one
DRAWS = 16  # uniforms reserved for one attempt of one intruder
BEYOND_S = 60.0  # how long the last leg of a path goes on after the closest approach; beyond its end flight goes on
STAGGER_S = 6.0  # merging intruders arrive so long after one another
APART_M = 10.0  # and are planned to stay this far from each other


@inner
def between(u, low, high):
    """A value uniform in [low, high], from one uniform `u`."""
    return low + (high - low) * u


@inner
def signed(u, low, high):
    """A value of random sign with magnitude uniform in [low, high], from one uniform `u`."""
    if u < 0.5:
        return -(low + 2.0 * u * (high - low))
    return low + (2.0 * u - 1.0) * (high - low)


@inner
def lay_path(aircraft, x, y, z, vx, vy, approach_s, bends, bend_s, wx, wy):
    """Predefined trajectory through (x, y, z) at `approach_s` with velocity (vx, vy).

    If it `bends`, there is a way point `bend_s` before that, and the velocity was (wx, wy) before it; with a negative
    `bend_s` the way point comes after (x, y, z), and the velocity is (wx, wy) from it on. Writes the way points, the
    times they are due and the number of points. The last leg goes on for `BEYOND_S`, so no leg has the length zero.
    """
    points, times = aircraft.path_m, aircraft.path_s
    last = 2 if bends else 1
    first_x, first_y, next_x, next_y = vx, vy, vx, vy  # velocities before and after the way point
    if bends and bend_s >= 0.0:
        first_x, first_y = wx, wy
    elif bends:
        next_x, next_y = wx, wy
    times[0], times[last] = 0.0, approach_s + BEYOND_S
    turn_s = approach_s - bend_s if bends else 0.0
    turn_x, turn_y = x + vx * (turn_s - approach_s), y + vy * (turn_s - approach_s)
    points[0, 0], points[0, 1], points[0, 2] = turn_x - first_x * turn_s, turn_y - first_y * turn_s, z
    if bends:
        points[1, 0], points[1, 1], points[1, 2], times[1] = turn_x, turn_y, z, turn_s
    rest_s = times[last] - turn_s
    points[last, 0], points[last, 1], points[last, 2] = turn_x + next_x * rest_s, turn_y + next_y * rest_s, z
    aircraft.path_points = last + 1


@inner
def lay_script(family, agent, intruder, altitude_m, heading_rad):
    """Predefined trajectories of a hand-written encounter, turned to `heading_rad`."""
    c, s = cos(heading_rad), sin(heading_rad)
    lay_path(agent, 0.0, 0.0, altitude_m, family.own_mps * c, family.own_mps * s, 0.0, False, 0.0, 0.0, 0.0)
    # Axes along and to the right of the heading.
    x, y = family.start_m[0] * c + family.start_m[1] * s, family.start_m[0] * s - family.start_m[1] * c
    v, w = family.velocity_mps[0], family.velocity_mps[1]
    vx, vy = v * c + w * s, v * s - w * c
    lay_path(intruder, x, y, altitude_m + family.start_m[2], vx, vy, 0.0, False, 0.0, 0.0, 0.0)


@inner
def approach_of(one, two, end_s):
    """Time (s) of the closest approach of two straight predefined trajectories, within [0, end_s]."""
    ax, ay, az, avx, avy, avz = planned(one, 0, 0.0)
    bx, by, bz, bvx, bvy, bvz = planned(two, 0, 0.0)
    vx, vy, vz = bvx - avx, bvy - avy, bvz - avz
    square = vx * vx + vy * vy + vz * vz
    if square == 0.0:
        return 0.0
    return min(max(-((bx - ax) * vx + (by - ay) * vy + (bz - az) * vz) / square, 0.0), end_s)


@inner(forceinline=True)
def planned(aircraft, leg, time_s):
    """u^d (m) and its velocity (m/s) at `time_s` on leg `leg`: x, y, z, vx, vy, vz. The last leg has no end."""
    p, t = aircraft.path_m, aircraft.path_s
    span_s = t[leg + 1] - t[leg]
    vx, vy = (p[leg + 1, 0] - p[leg, 0]) / span_s, (p[leg + 1, 1] - p[leg, 1]) / span_s
    vz = (p[leg + 1, 2] - p[leg, 2]) / span_s
    s = time_s - t[leg]
    return p[leg, 0] + vx * s, p[leg, 1] + vy * s, p[leg, 2] + vz * s, vx, vy, vz


@inner(forceinline=True)
def leg_at(aircraft, leg, time_s):
    """Number of the leg flown at `time_s`, searched from `leg` on."""
    while leg + 2 < aircraft.path_points and time_s >= aircraft.path_s[leg + 1]:
        leg += 1
    return leg


@inner
def least_planned_separation_m(one, two, end_s):
    """Least separation (m) of two predefined trajectories over [0, end_s], exact on each pair of legs."""
    start_s, leg_one, leg_two, least = 0.0, 0, 0, np.inf
    while start_s < end_s:
        leg_one, leg_two = leg_at(one, leg_one, start_s), leg_at(two, leg_two, start_s)
        stop_s = end_s
        if leg_one + 2 < one.path_points:
            stop_s = min(stop_s, one.path_s[leg_one + 1])
        if leg_two + 2 < two.path_points:
            stop_s = min(stop_s, two.path_s[leg_two + 1])
        ax, ay, az, avx, avy, avz = planned(one, leg_one, start_s)
        bx, by, bz, bvx, bvy, bvz = planned(two, leg_two, start_s)
        square = least_square_separation(bx - ax, by - ay, bz - az, bvx - avx, bvy - avy, bvz - avz, stop_s - start_s)
        least = min(least, square)
        start_s = stop_s
    return sqrt(least)


@inner
def start_separation_m(one, two):
    """Distance (m) of the first way points of two predefined trajectories."""
    square = 0.0
    for axis in range(3):
        step = one.path_m[0, axis] - two.path_m[0, axis]
        square += step * step
    return sqrt(square)


@inner
def course(aircraft, speed_mps):
    """Horizontal velocity (x, y, m/s) at `speed_mps` in the direction of the last leg of a predefined trajectory."""
    _, _, _, vx, vy, _ = planned(aircraft, aircraft.path_points - 2, 0.0)
    scale = speed_mps / sqrt(vx * vx + vy * vy)
    return vx * scale, vy * scale


@inner
def choose_family(u, families):
    """Index of the family that one uniform `u` falls to, by the cumulative weights."""
    index = 0
    while u > families[index].weight:
        index += 1
    return index


@inner
def miss(config, family, conflict, u, v):
    """Planned horizontal and vertical miss, m, signed, from two uniforms: small for a conflict, else the family's."""
    if conflict:
        horizontal = signed(u, 0.0, config.conflict_offset_m)
        vertical = signed(v, 0.0, 0.5 * config.conflict_offset_m)
    else:
        horizontal = signed(u, family.offset_min_m, family.offset_max_m)
        vertical = signed(v, 0.0, config.vertical_offset_m)
    return horizontal, 0.0 if config.planar else vertical


@inner
def within_limits(config, agent, intruder, miss_squared_m2, end_s, is_late):
    """Whether two trajectories start at the right range and are never nearer than the planned miss.

    An intruder that `is_late`, as it merges behind others, may start from farther away.
    """
    start_m = start_separation_m(agent, intruder)
    # An offset lengthens the start range by the miss distance; the limits are on the range along the approach.
    high_m = sqrt(config.start_max_m * config.start_max_m + miss_squared_m2)
    if start_m < config.start_min_m - 1e-6 or (start_m > high_m + 1e-6 and not is_late):
        return False
    return least_planned_separation_m(agent, intruder, end_s) >= sqrt(miss_squared_m2) - 0.1


@inner
def all_apart(aircraft, k, end_s):
    """Whether intruder `k` is planned to stay clear of those before it."""
    for other in range(k):
        if least_planned_separation_m(aircraft[1 + other], aircraft[1 + k], end_s) < APART_M:
            return False
    return True


@inner
def draw(key, config, families, aircraft, intruders, tail_s):
    """Lay the predefined trajectories of the agent (`aircraft[0]`) and of `intruders` intruders.

    The flight ends `tail_s` after the last of their planned closest approaches.

    Returns
    -------
    tuple
        Index of the first intruder's family (-1 if no draw met the limits), time of its closest approach (s), end of
        the flight (s).
    """
    agent = aircraft[0]
    family_index = 0
    first_approach_s = 0.0
    end_s = 0.0
    own_speed = config.cruise_min_mps  # drawn with the first intruder, kept for the others
    k = restart = 0
    while k < intruders:
        intruder = aircraft[1 + k]
        index = (restart * MAX_INTRUDERS + k) * ATTEMPTS * DRAWS
        drawn_index, family, conflict = 0, families[0], False
        accepted = False
        for attempt in range(ATTEMPTS):
            at = index + attempt * DRAWS
            if attempt % FAMILY_ATTEMPTS == 0:
                drawn_index = choose_family(uniform(key, STREAM_SAMPLER, at), families)
                family = families[drawn_index]
                conflict = uniform(key, STREAM_SAMPLER, at + 1) < family.conflict_share
                intruder.family = drawn_index
            if family.scripted:
                heading = 2.0 * pi * uniform(key, STREAM_SAMPLER, at + 2)
                lay_script(family, agent, intruder, config.altitude_m, heading)
                return drawn_index, approach_of(agent, intruder, family.end_s), family.end_s
            speed_span = config.cruise_max_mps - config.cruise_min_mps
            speed = config.cruise_min_mps + speed_span * uniform(key, STREAM_SAMPLER, at + 2)
            crossing = signed(uniform(key, STREAM_SAMPLER, at + 3), family.crossing_min_rad, family.crossing_max_rad)
            start_m = config.start_min_m + (config.start_max_m - config.start_min_m) * uniform(
                key, STREAM_SAMPLER, at + 4
            )
            horizontal, vertical = miss(
                config, family, conflict, uniform(key, STREAM_SAMPLER, at + 5), uniform(key, STREAM_SAMPLER, at + 6)
            )
            bend_s = between(uniform(key, STREAM_SAMPLER, at + 7), family.bend_min_s, family.bend_max_s)
            turn = signed(uniform(key, STREAM_SAMPLER, at + 8), family.turn_min_rad, family.turn_max_rad)
            before = speed
            if family.speed_change_max_mps > 0.0:
                before += signed(
                    uniform(key, STREAM_SAMPLER, at + 13), family.speed_change_min_mps, family.speed_change_max_mps
                )
                if before < config.cruise_min_mps or before > config.cruise_max_mps:
                    continue
            # The agent's state at the closest approach: drawn with the first intruder, given for the others.
            if k == 0:
                own_heading = 2.0 * pi * uniform(key, STREAM_SAMPLER, at + 9)
                own_speed = config.cruise_min_mps + speed_span * uniform(key, STREAM_SAMPLER, at + 10)
                ovx, ovy = own_speed * cos(own_heading), own_speed * sin(own_heading)
                ox, oy, oz = 0.0, 0.0, config.altitude_m
            else:
                # The same law of time; the agent's leg at that time gives its position and heading.
                square = own_speed * own_speed + speed * speed - 2.0 * own_speed * speed * cos(crossing)
                own_s = start_m / sqrt(max(square, config.closing_min_mps * config.closing_min_mps))
                if family.merging:
                    own_s = first_approach_s + k * STAGGER_S
                ox, oy, oz, ovx, ovy, _ = planned(agent, leg_at(agent, 0, own_s), own_s)
            if family.faster and speed <= own_speed:
                continue
            c, s = cos(crossing), sin(crossing)
            ux, uy = ovx / own_speed, ovy / own_speed
            dx, dy = ux * c - uy * s, uy * c + ux * s  # the intruder's direction
            rx, ry = speed * dx - ovx, speed * dy - ovy
            closing = sqrt(rx * rx + ry * ry)
            if closing < config.closing_min_mps:
                continue
            approach_s = start_m / closing if k == 0 else own_s
            is_late = family.merging and k > 0
            if approach_s > config.time_to_approach_max_s and not is_late:
                continue
            # Miss perpendicular to the relative velocity, so that this is the closest approach.
            ix, iy = ox - horizontal * ry / closing, oy + horizontal * rx / closing
            iz = oz + vertical
            own_end_s = approach_s + tail_s
            if k == 0:
                own_bend_s = between(
                    uniform(key, STREAM_SAMPLER, at + 11),
                    family.own_bend_min_s,
                    min(family.own_bend_max_s, 0.6 * approach_s),
                )
                own_turn = signed(
                    uniform(key, STREAM_SAMPLER, at + 12), family.own_turn_min_rad, family.own_turn_max_rad
                )
                wx, wy = turned(ovx, ovy, cos(own_turn), sin(own_turn))
                lay_path(agent, ox, oy, oz, ovx, ovy, approach_s, own_turn != 0.0, own_bend_s, wx, wy)
            ivx, ivy = speed * dx, speed * dy
            if family.merging:  # the way point is the closest approach
                wx, wy, bend_s = ivx, ivy, 0.0
                if k > 0:
                    ivx, ivy = course(aircraft[1], speed)
            else:
                wx, wy = turned(ivx * (before / speed), ivy * (before / speed), cos(turn), sin(turn))
            lay_path(
                intruder, ix, iy, iz, ivx, ivy, approach_s,
                family.bends, min(bend_s, 0.6 * approach_s), wx, wy,
            )  # fmt: skip
            miss_squared_m2 = horizontal * horizontal + vertical * vertical
            if not within_limits(config, agent, intruder, miss_squared_m2, own_end_s, is_late):
                continue
            if family.merging and not all_apart(aircraft, k, own_end_s):
                continue
            accepted = True
            if k == 0:
                family_index, first_approach_s = drawn_index, approach_s
            end_s = max(end_s, own_end_s)
            break
        k += 1
        if not accepted:
            restart += 1
            if k == 1 or restart > RESTARTS:
                return -1, 0.0, 0.0
            k, end_s = 0, 0.0
    return family_index, first_approach_s, end_s
