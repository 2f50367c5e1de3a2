"""What a tick means for one row: events of the true motion, warnings, messages, and how far the warnings are right."""

from math import sqrt

from rss_gym.jit import inner
from rss_gym.lanes import load_message
from rss_gym.links import silent
from rss_gym.physics.geometry import enters_cylinder, turned
from rss_gym.records import RANGE
from rss_gym.safety import STD_TO_80_PERCENT, violates, zone_radius_m


@inner(forceinline=True)
def witness(config, block, e, lanes, link, r):
    """Events of the tick between the agent and an intruder, on lane r."""
    block.nearest_squared_m2[r] = min(block.nearest_squared_m2[r], link.distance_squared_m2[r])
    if lanes.least_m[r] < e.min_separation_m:
        e.min_separation_m, e.closest_s = lanes.least_m[r], (e.tick - 1) * config.tick_s + config.tick_s
    square = lanes.least_squared_m2[r]
    if square < config.collision_m * config.collision_m:
        e.collision = True
    if square < config.radius_m * config.radius_m:
        e.zone = True
    height, radius = config.snmac_vertical_m, config.snmac_horizontal_m
    if square < radius * radius + height * height:
        u, v = lanes.relative_m, lanes.relative_mps
        e.snmac |= enters_cylinder(u[0, r], u[1, r], u[2, r], v[0, r], v[1, r], v[2, r], config.tick_s, radius, height)


@inner(forceinline=True)
def alert(config, e, contact, path, agent, craft, lanes, link, r):
    """Warning and message of an intruder after a tick; `contact` and `path` (its aircraft) are records of the row."""
    warned = contact.warning
    if config.zone_adaptive:
        contact.radius_m = adaptive_radius_m(config, contact, agent, link, r)
    warn(config, contact, link.range_m[r])
    lanes.known[r] = 0.0
    if contact.warning and not silent(contact, e.tick * config.tick_s):
        if config.track == RANGE and not contact.hovered:
            contact.hovered, path.hover_until_s = True, e.tick * config.tick_s + config.hover_s
            craft.hover_until_s[r] = path.hover_until_s
        tell(contact, path, craft, r, config.track != RANGE)
        load_message(lanes, r, contact, config.track != RANGE)
    judge(config, e, contact, link.distance_squared_m2[r], link.range_m[r], warned)


@inner(forceinline=True)
def warn(config, contact, range_m):
    """Open or close a warning by (29) with hysteresis."""
    violated = violates(range_m, contact.radius_m)
    contact.streak = contact.streak + 1 if violated else 0
    near = violates(range_m, config.warning_close_ratio * contact.radius_m)
    contact.clear_s = 0.0 if near else contact.clear_s + config.tick_s
    contact.age_s += config.tick_s
    if violated:
        contact.warning = True
    elif contact.warning and contact.clear_s > config.warning_close_s:
        contact.warning = False


@inner(forceinline=True)
def tell(contact, path, craft, r, positions):
    """A message arrives: the sender's own solution and, with `positions`, where it is and its next way point."""
    contact.valid, contact.age_s, contact.std_m = True, 0.0, craft.solution_std_m[r]
    for axis in range(3):
        contact.velocity_mps[axis] = craft.solution_mps[axis, r]
        if positions:
            contact.position_m[axis] = craft.solution_m[axis, r]
            # The next way point, displaced as the sender's own solution is.
            ahead_m = path.path_m[path.leg + 1, axis] - craft.position_m[axis, r]
            contact.way_point_m[axis] = craft.solution_m[axis, r] + ahead_m
    if contact.false_turn[1] != 0.0 and path.leg > 0:
        mislead(contact)


@inner(forceinline=True)
def mislead(contact):
    """Turn what a message tells of the way ahead; where the sender is stays true."""
    v, p, w = contact.velocity_mps, contact.position_m, contact.way_point_m
    c, s = contact.false_turn[0], contact.false_turn[1]
    v[0], v[1] = turned(v[0], v[1], c, s)
    x, y = turned(w[0] - p[0], w[1] - p[1], c, s)
    w[0], w[1] = p[0] + x, p[1] + y


@inner(forceinline=True)
def adaptive_radius_m(config, contact, agent, link, r):
    """(40) with delta from the filter's variance, and the relative speed from the exchanged velocities once known."""
    speed = 2.0 * config.speed_max_mps
    if contact.valid:
        own, other = agent.solution_mps, contact.velocity_mps
        x, y, z = other[0] - own[0, r], other[1] - own[1, r], other[2] - own[2, r]
        speed = sqrt(x * x + y * y + z * z)
    delta_m = STD_TO_80_PERCENT * sqrt(link.p_dd[r])
    return zone_radius_m(delta_m, config.range_error_probability, speed, config.reaction_s, config.trials)


@inner(forceinline=True)
def judge(config, e, contact, distance_squared_m2, range_m, warned_before):
    """Compare the warning with the true separation: first warning, false alerts, missed detections."""
    inside = distance_squared_m2 <= config.radius_m * config.radius_m
    if contact.warning and not warned_before:
        if e.warned_s < 0.0:
            e.warned_s = e.tick * config.tick_s
        if not inside:
            e.false_alerts += 1
    contact.missed = contact.missed + 1 if inside and range_m > config.radius_m else 0
    e.missed = max(e.missed, contact.missed)
