"""What a tick means for one row: events of the true motion, warnings, messages, and whether the warnings are right."""

from math import sqrt

import numpy as np

from rss_gym.encounters.sampler import leg_at, planned
from rss_gym.jit import inner
from rss_gym.lanes import is_fresh, load_message
from rss_gym.links import in_outage
from rss_gym.physics.geometry import assign, enters_cylinder, turned
from rss_gym.physics.random import uniform
from rss_gym.safety import STD_TO_80_PERCENT, violates, zone_radius_m
from rss_gym.state import RANGES
from rss_gym.streams import STREAM_MESSAGE


@inner(forceinline=True)
def detect_events(config, block, e, lanes, r):
    """Least separation (m) and events of the tick between the agent and an intruder, on lane r."""
    block.nearest_m[r] = min(block.nearest_m[r], lanes.least_m[r])
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
def add_closeness(config, block, e, r):
    """Add the tick's squared closeness and depth inside the zone (no unit) to the sums of the flight, on lane r."""
    closeness = max(0.0, 1.0 - block.nearest_m[r] / config.comfort_m)
    e.proximity_sum += closeness * closeness
    e.severity_sum += max(0.0, 1.0 - block.nearest_m[r] / config.radius_m)
    block.nearest_m[r] = np.inf


@inner(forceinline=True)
def update_contact(config, e, k, contact, path, agent, intruder, lanes, link, leaving, arriving, r):
    """Warning and messages of intruder k after a tick.

    `contact`, `path` (its aircraft), `leaving` and `arriving` (its messages of now and of `latency_ticks` ago, the same
    without latency) are records of the row.
    """
    warned = contact.warning
    if config.zone_adaptive:
        contact.radius_m = adaptive_radius_m(config, contact, agent, link, r)
    update_warning(config, contact, link.range_m[r])
    if contact.warning and not in_outage(contact, e.tick * config.tick_s):
        if config.information == RANGES and not contact.hovered:
            contact.hovered, path.hover_until_s = True, e.tick * config.tick_s + config.hover_s
            intruder.hover_until_s[r] = path.hover_until_s
        send_message(config, e, k, contact, path, intruder, leaving, r)
    else:
        leaving.sent = False
    if arriving.sent:
        store_message(config, contact, arriving)
        load_message(lanes, r, contact, config.information != RANGES)
    elif not is_fresh(contact):
        lanes.known[r] = 0.0
    score_warning(config, e, contact, link.distance_squared_m2[r], link.range_m[r], warned)


@inner(forceinline=True)
def update_warning(config, contact, range_m):
    """Open or close a warning by (29) with hysteresis."""
    violated = violates(range_m, contact.radius_m)
    contact.consecutive_warnings = contact.consecutive_warnings + 1 if violated else 0
    near = violates(range_m, config.warning_close_ratio * contact.radius_m)
    contact.clear_s = 0.0 if near else contact.clear_s + config.tick_s
    contact.age_s += config.tick_s
    if violated:
        contact.warning = True
    elif contact.warning and contact.clear_s > config.warning_close_s:
        contact.warning = False


@inner(forceinline=True)
def planned_ahead(path, lanes, ahead_s, r):
    """Where an aircraft plans to be `ahead_s` from now, relative to where it plans to be now: x, y, z."""
    later_s, v = lanes.clock_s[r] + ahead_s, lanes.planned_mps
    if later_s < lanes.turn_s[r]:
        return v[0, r] * ahead_s, v[1, r] * ahead_s, v[2, r] * ahead_s
    x, y, z, _, _, _ = planned(path, leg_at(path, path.leg, later_s), later_s)
    return x - lanes.planned_m[0, r], y - lanes.planned_m[1, r], z - lanes.planned_m[2, r]


@inner(forceinline=True)
def send_message(config, e, k, contact, path, sender, message, r):
    """An intruder states its own solution: where it is, how fast, how sure, and where it plans to be.

    The next way point is the planned way over `announce_s` from now, displaced as the sender's solution is and led
    astray by the error of its velocity, so that it carries no more than the sender knows of itself.
    """
    message.sent = config.message_loss <= 0.0 or uniform(e.key, STREAM_MESSAGE + k, e.tick) >= config.message_loss
    message.std_m = sender.solution_std_m[r]
    ahead = planned_ahead(path, sender, config.announce_s, r)
    for axis in range(3):
        message.velocity_mps[axis] = sender.solution_mps[axis, r]
        message.position_m[axis] = sender.solution_m[axis, r]
        error_m = config.announce_s * sender.velocity_error_mps[axis, r]
        message.way_point_m[axis] = sender.solution_m[axis, r] + (ahead[axis] + error_m)
    if contact.false_turn[1] != 0.0 and path.leg > 0:
        falsify_message(contact, message)


@inner(forceinline=True)
def store_message(config, contact, message):
    """A message arrives and replaces the one held."""
    contact.valid, contact.age_s = True, config.latency_ticks * config.tick_s
    assign(contact.velocity_mps, message.velocity_mps)
    if config.information != RANGES:
        contact.std_m = message.std_m
        assign(contact.position_m, message.position_m)
        assign(contact.way_point_m, message.way_point_m)


@inner(forceinline=True)
def falsify_message(contact, message):
    """Turn velocity and way point of a message; the position stays true."""
    v, p, w = message.velocity_mps, message.position_m, message.way_point_m
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
def score_warning(config, e, contact, distance_squared_m2, range_m, warned_before):
    """Compare the warning with the true separation: first warning, false alerts, missed detections."""
    inside = distance_squared_m2 <= config.radius_m * config.radius_m
    if contact.warning and not warned_before:
        if e.warned_s < 0.0:
            e.warned_s = e.tick * config.tick_s
        if not inside:
            e.false_alerts += 1
    contact.missed = contact.missed + 1 if inside and range_m > config.radius_m else 0
    e.missed = max(e.missed, contact.missed)
