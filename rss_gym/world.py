"""The world: reset, tick and decide, one row of the batch at a time; the single environment is a batch of one.

Order of a tick: everybody moves; events are read from the true motion; every link is ranged; every aircraft updates
its navigation solution; warnings open or close and messages arrive.
"""

from math import sqrt

import numpy as np

from rss_gym.encounters.sampler import draw, leg_at, planned
from rss_gym.jit import kernel
from rss_gym.params import MAX_INTRUDERS
from rss_gym.physics.geometry import assign, enters_cylinder, least_square_separation, zero
from rss_gym.physics.motion import clip, limit, regulate
from rss_gym.physics.noise import gauss_markov
from rss_gym.physics.path_loss import quantise, received_dbm
from rss_gym.physics.random import episode_key, fill_normals, normal, uniform
from rss_gym.positioning import trilaterate
from rss_gym.ranging import COLOURED, WHITE, coloured, inverse, white
from rss_gym.records import (
    DEAD_RECKONING,
    GNSS,
    NODES,
    RANGE,
    RSS,
    STREAM_AIRCRAFT,
    STREAM_LOSS,
    STREAM_START_AIRCRAFT,
    STREAM_START_LINK,
    STREAM_TICK,
    STREAM_WANDER,
    VELOCITY,
)
from rss_gym.safety import STD_TO_80_PERCENT, violates, zone_radius_m

LS_CEILING_M = 1000.0  # least squares inverts a deep fade to any distance; beyond this it says nothing
GAUSS_NEWTON_STEPS = 3

coloured_start, coloured_predict, coloured_update = coloured.start, coloured.predict, coloured.update
white_predict, white_update = white.predict, white.update
invert = inverse.invert


# -- reset ------------------------------------------------------------------------------------------------------------


@kernel
def reset_row(world, i, split, seed, number):
    """Start episode `number` of `seed` in row i: draw the encounter, the channel and every stationary error."""
    config, e, aircraft = world.config[0], world.episode[i], world.aircraft[i]
    links, contacts = world.links[i], world.contacts[i]
    key = episode_key(split, seed, number)
    e.split, e.seed, e.number, e.key = split, seed, number, key
    e.channel = min(int(uniform(key, STREAM_START_LINK, 8) * len(world.channels)), len(world.channels) - 1)
    span = config.intruders - config.intruders_min + 1
    e.intruders = config.intruders_min + min(int(uniform(key, STREAM_START_LINK, 9) * span), span - 1)
    e.family, e.approach_s, end_s = draw(key, config, world.families, aircraft, e.intruders)
    ticks = config.ticks_per_decision
    e.tick, e.ticks = 0, int(np.ceil(end_s / (ticks * config.tick_s) - 1e-9)) * ticks
    e.collision = e.snmac = e.zone = e.terminated = e.truncated = False
    e.deviation_m = e.deviation_max_m = e.flown_m = e.cost = e.closest_s = 0.0
    e.warned_s = -1.0
    e.false_alerts = e.missed = 0
    e.reward_tracking = e.reward_effort = e.reward_proximity = e.reward_collision = 0.0
    for a in range(1 + e.intruders):
        start_aircraft(config, aircraft[a], localisation(config, a), key, a)
    e.min_separation_m = np.inf
    for k in range(e.intruders):
        e.min_separation_m = min(e.min_separation_m, sqrt(separation_squared(aircraft[0], aircraft[1 + k])))
        clear_contact(config, contacts[k])
    e.zone = e.min_separation_m < config.radius_m
    channel = world.channels[e.channel]
    for link in range(len(links)):
        g = link if link < config.intruders else MAX_INTRUDERS + link - config.intruders
        start_link(channel, links[link], key, g)
    # The first measurement and the first solution exist before the first decision.
    refill_ticks(world, i)
    for a in range(1 + e.intruders):
        range_nodes(world, i, a)
        fix(world, i, a)
    for k in range(e.intruders):
        range_contact(world, i, k)
        warn(world, i, k)
        judge(config, e, contacts[k], links[k], separation_squared(aircraft[0], aircraft[1 + k]), False)


@kernel
def start_aircraft(config, craft, mode, key, a):
    """Put an aircraft on the start of its path, with stationary errors of its navigation."""
    stream = STREAM_START_AIRCRAFT + a
    craft.leg, craft.held_s, craft.hover_until_s = 0, 0.0, 0.0
    craft.along[0], craft.along[1], craft.along[2] = 1.0, 0.0, 0.0
    plan(craft, 0.0)
    up = 0.0 if config.planar else 1.0
    for axis in range(3):
        free = 1.0 if axis < 2 else up
        craft.position_m[axis] = craft.planned_m[axis]
        craft.velocity_mps[axis] = craft.planned_mps[axis]
        craft.way_point_m[axis] = craft.planned_m[axis]
        craft.gust_mps[axis] = free * config.gust_mps * normal(key, stream, axis)
        craft.gnss_error_m[axis] = free * normal(key, stream, 3 + axis)  # unit variance, scaled per axis where used
        std = config.drift_mps if mode == DEAD_RECKONING else config.velocity_error_mps
        craft.velocity_error_mps[axis] = free * std * normal(key, stream, 6 + axis)
        craft.drift_m[axis] = 0.0
    craft.barometer_error_m = up * config.barometer_m * normal(key, stream, 9)
    craft.datum_error_m = up * config.barometer_datum_m * normal(key, stream, 10)
    assign(craft.solution_m, craft.planned_m)
    navigate(config, craft, mode)


@kernel
def clear_contact(config, contact):
    """Nothing heard yet."""
    contact.radius_m = config.radius_m
    contact.warning = contact.hovered = contact.valid = False
    contact.clear_s = contact.age_s = contact.std_m = 0.0
    contact.streak = contact.missed = 0
    zero(contact.position_m)
    zero(contact.velocity_mps)
    zero(contact.way_point_m)


@kernel
def start_link(channel, link, key, g):
    """Stationary channel."""
    stream = STREAM_START_LINK + 10 + g
    link.coloured_db = channel.coloured_std_db * normal(key, stream, 0)
    link.wander = channel.wander_std * normal(key, stream, 1)
    link.coloured_hat_db = link.rate_mps = 0.0


# -- noise ------------------------------------------------------------------------------------------------------------


@kernel(forceinline=True)
def refill_ticks(world, i):
    """Draw the standard normals of the next four ticks of every link in use."""
    config, e = world.config[0], world.episode[i]
    k, block, normals = config.intruders, e.tick // 4, world.tick_normals[i]
    fill_normals(e.key, STREAM_TICK, block, normals[: 2 * e.intruders])
    for a in range(1 + e.intruders):
        if localisation(config, a) == RSS:
            first = 2 * NODES * a
            fill_normals(
                e.key, STREAM_TICK + 2 * MAX_INTRUDERS + first, block, normals[2 * k + first : 2 * (k + NODES) + first]
            )


@kernel
def refill_decisions(world, i):
    """Draw the standard normals of the next four decisions."""
    config, e = world.config[0], world.episode[i]
    k, block, normals = config.intruders, e.tick // (4 * config.ticks_per_decision), world.decision_normals[i]
    aircraft = k + NODES * (1 + k)
    fill_normals(e.key, STREAM_WANDER, block, normals[: e.intruders])
    for a in range(1 + e.intruders):
        if localisation(config, a) == RSS:
            first = NODES * a
            fill_normals(e.key, STREAM_WANDER + MAX_INTRUDERS + first, block, normals[k + first : k + first + NODES])
        fill_normals(e.key, STREAM_AIRCRAFT + 10 * a, block, normals[aircraft + 10 * a : aircraft + 10 * a + 10])


@kernel(forceinline=True)
def localisation(config, a):
    """How aircraft `a` knows its position."""
    return config.agent_localisation if a == 0 else config.intruder_localisation


@kernel(forceinline=True)
def drift(world, i):
    """Advance the slow processes by one decision: path loss factors, gusts, errors of navigation."""
    config, e = world.config[0], world.episode[i]
    if e.tick % (4 * config.ticks_per_decision) == 0:
        refill_decisions(world, i)
    channel = world.channels[e.channel]
    normals = world.decision_normals[i]
    k, slot = config.intruders, (e.tick // config.ticks_per_decision) % 4
    links = k + NODES * (1 + k)
    for link in range(e.intruders):
        advance_wander(channel, world.links[i, link], normals[link, slot])
    up = 0.0 if config.planar else 1.0
    for a in range(1 + e.intruders):
        mode = localisation(config, a)
        if mode == RSS:
            for j in range(NODES):
                link = k + NODES * a + j
                advance_wander(channel, world.links[i, link], normals[link, slot])
        # The velocity is known from dead reckoning, or from the radio's broadcast solution.
        velocity_a, velocity_drive = config.velocity_decay, config.velocity_drive
        if mode == DEAD_RECKONING:
            velocity_a, velocity_drive = config.drift_decay, config.drift_drive
        craft, first = world.aircraft[i, a], links + 10 * a
        for axis in range(3):
            free = 1.0 if axis < 2 else up
            craft.gust_mps[axis] = gauss_markov(
                craft.gust_mps[axis], config.gust_decay, config.gust_drive_mps, free * normals[first + axis, slot]
            )
            craft.gnss_error_m[axis] = gauss_markov(
                craft.gnss_error_m[axis], config.gnss_decay, config.gnss_drive, free * normals[first + 3 + axis, slot]
            )
            craft.velocity_error_mps[axis] = gauss_markov(
                craft.velocity_error_mps[axis], velocity_a, velocity_drive, free * normals[first + 6 + axis, slot]
            )
        craft.barometer_error_m = gauss_markov(
            craft.barometer_error_m, config.barometer_decay, config.barometer_drive, up * normals[first + 9, slot]
        )


@kernel(forceinline=True)
def advance_wander(channel, link, n):
    """One decision of the Gauss-Markov path loss factor."""
    link.wander = gauss_markov(link.wander, channel.wander_decay, channel.wander_drive, n)


# -- motion -----------------------------------------------------------------------------------------------------------


@kernel(forceinline=True)
def plan(craft, time_s):
    """Write u^d, its velocity and the direction of the current leg at `time_s` of the aircraft's own clock."""
    craft.leg = leg_at(craft, craft.leg, time_s)
    x, y, z, vx, vy, vz = planned(craft, craft.leg, time_s)
    p, v, along = craft.planned_m, craft.planned_mps, craft.along
    p[0], p[1], p[2] = x, y, z
    v[0], v[1], v[2] = vx, vy, vz
    speed = sqrt(vx * vx + vy * vy)
    if speed > 0.0:  # a hovering aircraft keeps its axes
        along[0], along[1], along[2] = vx / speed, vy / speed, 0.0


@kernel(forceinline=True)
def command(config, craft, action):
    """Move the agent's way point: towards the displaced trajectory, or at the commanded velocity."""
    along, p, v, w = craft.along, craft.planned_m, craft.planned_mps, craft.way_point_m
    ax, ay = along[0], along[1]
    # The axes of the leg: along = (ax, ay, 0), right = (ay, -ax, 0), up.
    x, y, z = action[0] * ax + action[1] * ay, action[0] * ay - action[1] * ax, action[2]
    if config.action == VELOCITY:
        vx = v[0] + config.speed_max_mps * x
        vy = v[1] + config.speed_max_mps * y
        vz = v[2] + config.vertical_speed_max_mps * z
        vx, vy, vz = limit(vx, vy, vz, config.speed_max_mps, config.vertical_speed_max_mps)
        step_x, step_y, step_z = vx * config.tick_s, vy * config.tick_s, vz * config.tick_s
    else:
        reach = config.reach_m
        height = clip(reach * z, -config.altitude_band_m, config.altitude_band_m)
        step_x, step_y, step_z = limit(
            p[0] + reach * x - w[0],
            p[1] + reach * y - w[1],
            p[2] + height - w[2],
            config.speed_max_mps * config.tick_s,
            config.vertical_speed_max_mps * config.tick_s,
        )
    w[0] += step_x
    w[1] += step_y
    w[2] = clip(w[2] + step_z, p[2] - config.altitude_band_m, p[2] + config.altitude_band_m)
    return step_x / config.tick_s, step_y / config.tick_s, step_z / config.tick_s


@kernel(forceinline=True)
def steer(config, craft, wx_mps, wy_mps, wz_mps):
    """One tick of the autopilot towards the way point, which moves at (wx, wy, wz). Returns the ground velocity."""
    u, v, w, gust = craft.position_m, craft.velocity_mps, craft.way_point_m, craft.gust_mps
    k1, k2 = config.position_gain_ps2, config.velocity_gain_ps
    ax, ay, az = limit(
        regulate(w[0] - u[0], wx_mps - v[0], k1, k2),
        regulate(w[1] - u[1], wy_mps - v[1], k1, k2),
        regulate(w[2] - u[2], wz_mps - v[2], k1, k2),
        config.acceleration_max_mps2,
        config.acceleration_max_mps2,
    )
    t = config.tick_s
    v[0], v[1], v[2] = limit(
        v[0] + ax * t, v[1] + ay * t, v[2] + az * t, config.speed_max_mps, config.vertical_speed_max_mps
    )
    return v[0] + gust[0], v[1] + gust[1], v[2] + gust[2]


@kernel(forceinline=True)
def move(world, i, action):
    """Everybody flies one tick; events are read from the true relative motion inside it."""
    config, e, aircraft = world.config[0], world.episode[i], world.aircraft[i]
    t, now_s = config.tick_s, (e.tick - 1) * config.tick_s
    agent = aircraft[0]
    plan(agent, now_s + t)
    wx, wy, wz = command(config, agent, action)
    ovx, ovy, ovz = steer(config, agent, wx, wy, wz)
    own = agent.position_m
    for k in range(e.intruders):
        craft = aircraft[1 + k]
        hover = now_s < craft.hover_until_s
        if hover:
            craft.held_s += t
        plan(craft, now_s + t - craft.held_s)
        p, v, w = craft.planned_m, craft.planned_mps, craft.way_point_m
        w[0], w[1], w[2] = p[0], p[1], p[2]
        go = 0.0 if hover else 1.0
        vx, vy, vz = steer(config, craft, go * v[0], go * v[1], go * v[2])
        u = craft.position_m
        x, y, z = u[0] - own[0], u[1] - own[1], u[2] - own[2]
        square = least_square_separation(x, y, z, vx - ovx, vy - ovy, vz - ovz, t)
        separation_m = sqrt(square)
        if separation_m < e.min_separation_m:
            e.min_separation_m, e.closest_s = separation_m, now_s + t
        if square < config.collision_m * config.collision_m:
            e.collision = True
        if square < config.radius_m * config.radius_m:
            e.zone = True
        height, radius = config.snmac_vertical_m, config.snmac_horizontal_m
        if square < radius * radius + height * height:
            e.snmac |= enters_cylinder(x, y, z, vx - ovx, vy - ovy, vz - ovz, t, radius, height)
        u[0], u[1], u[2] = u[0] + vx * t, u[1] + vy * t, u[2] + vz * t
    own[0], own[1], own[2] = own[0] + ovx * t, own[1] + ovy * t, own[2] + ovz * t
    e.flown_m += t * sqrt(ovx * ovx + ovy * ovy + ovz * ovz)


@kernel(forceinline=True)
def separation_squared(one, two):
    """Squared distance of two aircraft, m^2."""
    x = one.position_m[0] - two.position_m[0]
    y = one.position_m[1] - two.position_m[1]
    z = one.position_m[2] - two.position_m[2]
    return x * x + y * y + z * z


# -- radio ------------------------------------------------------------------------------------------------------------


@kernel(forceinline=True)
def listen(world, i, index, distance_squared_m2, psi_m, process_noise_m2):
    """One tick of a link: coloured noise, RSS (2), and the estimator of range."""
    config, e = world.config[0], world.episode[i]
    channel, link = world.channels[e.channel], world.links[i, index]
    normals = world.tick_normals[i]
    slot = e.tick % 4
    a, drive = channel.coloured_decay, channel.coloured_drive_db
    link.coloured_db = gauss_markov(link.coloured_db, a, drive, normals[2 * index, slot])
    gamma = channel.path_loss_factor
    rss = received_dbm(channel.offset_dbm, gamma + link.wander, max(distance_squared_m2, 0.01))
    rss += link.coloured_db + channel.white_std_db * normals[2 * index + 1, slot]
    rss = quantise(rss, channel.quantisation_db)
    heard = rss >= channel.sensitivity_dbm
    if channel.packet_loss > 0.0:
        g = index if index < config.intruders else MAX_INTRUDERS + index - config.intruders
        heard &= uniform(e.key, STREAM_LOSS + g, e.tick) >= channel.packet_loss
    if e.tick == 0:
        start_filter(config, channel, link, rss, heard, index >= config.intruders)
        return
    before_m = link.range_m
    offset, r, floor_m = channel.offset_dbm, channel.white_variance_db2, config.range_floor_m
    if config.estimator == COLOURED:
        d, phi, p_dd, p_dp, p_pp = coloured_predict(
            link.range_m, link.coloured_hat_db, link.p_dd, link.p_dp, link.p_pp, psi_m, process_noise_m2, a, drive
        )
        d = max(d, floor_m)
        if heard:
            d, phi, p_dd, p_dp, p_pp = coloured_update(d, phi, p_dd, p_dp, p_pp, rss, offset, gamma, r, floor_m)
        link.range_m, link.coloured_hat_db = d, phi
        link.p_dd, link.p_dp, link.p_pp = p_dd, p_dp, p_pp
    elif config.estimator == WHITE:
        d, p_dd = white_predict(link.range_m, link.p_dd, psi_m, process_noise_m2)
        d = max(d, floor_m)
        if heard:
            total = r + channel.coloured_variance_db2
            d, p_dd = white_update(d, p_dd, rss, offset, gamma, total, floor_m)
        link.range_m, link.p_dd = d, p_dd
    elif heard:
        total = r + channel.coloured_variance_db2
        link.range_m, link.p_dd = invert(rss, offset, gamma, total, floor_m, LS_CEILING_M)
    link.rate_mps += config.rate_gain * ((link.range_m - before_m) / config.tick_s - link.rate_mps)


@kernel(forceinline=True)
def start_filter(config, channel, link, rss_dbm, heard, to_node):
    """The estimator after the first sample: the prior of the range, updated where the measurement is linear."""
    prior_m, prior_std_m = config.prior_range_m, config.prior_std_m
    if to_node:
        prior_m, prior_std_m = config.node_prior_range_m, config.node_prior_std_m
    s = channel.coloured_variance_db2 if config.estimator == COLOURED else 0.0
    # A sample that was not received has no weight: the prior stays.
    r = channel.white_variance_db2 + channel.coloured_variance_db2 - s if heard else np.inf
    link.range_m, link.coloured_hat_db, link.p_dd, link.p_dp, link.p_pp = coloured_start(
        prior_m, prior_std_m, s, rss_dbm, channel.offset_dbm, channel.path_loss_factor, r
    )


@kernel(forceinline=True)
def closing(config, rx, ry, rz, vx, vy, vz, bearing_std_m):
    """Control input psi of (12) and its Var(w), from a relative position, a relative velocity and the position's uncertainty.

    psi is the velocity along the bearing times the tick. An error of the bearing by std / range turns some of the
    velocity across it into range; it persists, so its variance is inflated as a random walk must be to cover it.
    """
    d = sqrt(rx * rx + ry * ry + rz * rz) + 1e-9
    radial = (rx * vx + ry * vy + rz * vz) / d
    speed_squared = vx * vx + vy * vy + vz * vz
    angle = min(bearing_std_m / d, 1.0)
    across = max(speed_squared - radial * radial, 0.0) + speed_squared * angle * angle
    t = config.tick_s
    noise = config.process_noise_psi_m2 + config.bearing_inflation * across * angle * angle * t * t
    return radial * t, min(noise, config.process_noise_m2)


@kernel(forceinline=True)
def range_contact(world, i, k):
    """Range the link agent-intruder k, with psi while the warning keeps messages coming."""
    config, aircraft, contact = world.config[0], world.aircraft[i], world.contacts[i, k]
    agent = aircraft[0]
    psi, noise = 0.0, config.process_noise_m2
    if contact.warning and contact.valid and config.track != RANGE:
        own, ov, p, v = agent.solution_m, agent.solution_mps, contact.position_m, contact.velocity_mps
        std = sqrt(contact.std_m * contact.std_m + agent.solution_std_m * agent.solution_std_m)
        psi, noise = closing(
            config, p[0] - own[0], p[1] - own[1], p[2] - own[2], v[0] - ov[0], v[1] - ov[1], v[2] - ov[2], std
        )
    listen(world, i, k, separation_squared(agent, aircraft[1 + k]), psi, noise)


@kernel(forceinline=True)
def range_nodes(world, i, a):
    """Range the links of an `rss`-localised aircraft to the reference nodes, with psi from its own solution."""
    config, craft = world.config[0], world.aircraft[i, a]
    if localisation(config, a) != RSS:
        return
    u, s, v = craft.position_m, craft.solution_m, craft.solution_mps
    for j in range(NODES):
        node = config.nodes_m[j]
        x, y, z = u[0] - node[0], u[1] - node[1], u[2] - node[2]
        psi, noise = closing(
            config, s[0] - node[0], s[1] - node[1], s[2] - node[2], v[0], v[1], v[2], craft.solution_std_m
        )
        listen(world, i, config.intruders + NODES * a + j, x * x + y * y + z * z, psi, noise)


# -- navigation -------------------------------------------------------------------------------------------------------


@kernel(forceinline=True)
def navigate(config, craft, mode):
    """One tick of an aircraft's own solution; an `rss` solution is dead-reckoned between its fixes."""
    u, v = craft.position_m, craft.velocity_mps
    s, sv = craft.solution_m, craft.solution_mps
    for axis in range(3):
        sv[axis] = v[axis] + craft.gust_mps[axis] + craft.velocity_error_mps[axis]
        if mode == GNSS:
            scale = config.gnss_m if axis < 2 else config.gnss_vertical_m
            s[axis] = u[axis] + scale * craft.gnss_error_m[axis]
        elif mode == DEAD_RECKONING:
            craft.drift_m[axis] += craft.velocity_error_mps[axis] * config.tick_s
            s[axis] = u[axis] + craft.drift_m[axis]
        else:
            s[axis] += sv[axis] * config.tick_s


@kernel(forceinline=True)
def fix(world, i, a):
    """Uncertainty of the solution, once a decision; for `rss` also a fix by (1) from the three strongest nodes."""
    config, craft = world.config[0], world.aircraft[i, a]
    mode = localisation(config, a)
    if mode == GNSS:
        craft.solution_std_m = config.gnss_m
        return
    if mode == DEAD_RECKONING:
        craft.solution_std_m = config.drift_mps * world.episode[i].tick * config.tick_s
        return
    first = config.intruders + NODES * a
    links = world.links[i]
    # The strongest signals come from the nearest nodes: leave the farthest out (Sec. IX-A).
    weakest = 0
    for j in range(1, NODES):
        if links[first + j].range_m > links[first + weakest].range_m:
            weakest = j
    j0 = 1 if weakest == 0 else 0
    j1 = 2 if weakest <= 1 else 1
    j2 = 3 if weakest <= 2 else 2
    one, two, three = links[first + j0], links[first + j1], links[first + j2]
    nodes = config.nodes_m[j0], config.nodes_m[j1], config.nodes_m[j2]
    ranges = one.range_m, two.range_m, three.range_m
    variances = one.p_dd, two.p_dd, three.p_dd
    s = craft.solution_m
    s[2] = craft.position_m[2] + craft.barometer_error_m + craft.datum_error_m
    s[0], s[1], craft.solution_std_m = trilaterate(nodes, ranges, variances, s[2], GAUSS_NEWTON_STEPS)


# -- warnings and messages --------------------------------------------------------------------------------------------


@kernel(forceinline=True)
def warn(world, i, k):
    """Open or close the warning of intruder k by (29) with hysteresis; while it is open a message arrives."""
    config, e = world.config[0], world.episode[i]
    agent, craft = world.aircraft[i, 0], world.aircraft[i, 1 + k]
    contact, link = world.contacts[i, k], world.links[i, k]
    if config.zone_adaptive:
        contact.radius_m = adaptive_radius_m(config, agent, contact, link)
    violated = violates(link.range_m, contact.radius_m)
    contact.streak = contact.streak + 1 if violated else 0
    contact.clear_s = (
        0.0
        if violates(link.range_m, config.warning_close_ratio * contact.radius_m)
        else (contact.clear_s + config.tick_s)
    )
    if violated:
        contact.warning = True
    elif contact.warning and contact.clear_s > config.warning_close_s:
        contact.warning = False
    contact.age_s += config.tick_s
    if not contact.warning:
        return
    now_s = e.tick * config.tick_s
    if config.track == RANGE and not contact.hovered:
        contact.hovered, craft.hover_until_s = True, now_s + config.hover_s
    contact.valid, contact.age_s, contact.std_m = True, 0.0, craft.solution_std_m
    for axis in range(3):
        contact.velocity_mps[axis] = craft.solution_mps[axis]
        if config.track != RANGE:
            contact.position_m[axis] = craft.solution_m[axis]
            # The next way point, displaced as the sender's own solution is.
            ahead_m = craft.path_m[craft.leg + 1, axis] - craft.position_m[axis]
            contact.way_point_m[axis] = craft.solution_m[axis] + ahead_m


@kernel(forceinline=True)
def adaptive_radius_m(config, agent, contact, link):
    """(40) with delta from the filter's variance, and the relative speed from the exchanged velocities once known."""
    speed = 2.0 * config.speed_max_mps
    if contact.valid:
        own, other = agent.solution_mps, contact.velocity_mps
        x, y, z = other[0] - own[0], other[1] - own[1], other[2] - own[2]
        speed = sqrt(x * x + y * y + z * z)
    delta_m = STD_TO_80_PERCENT * sqrt(link.p_dd)
    return zone_radius_m(delta_m, config.range_error_probability, speed, config.reaction_s, config.trials)


# -- decision ---------------------------------------------------------------------------------------------------------


@kernel
def decide_row(world, i, action):
    """Fly row i for one decision with `action` in [-1, 1]^3 (along, right, up). Returns the reward."""
    config, e, agent = world.config[0], world.episode[i], world.aircraft[i, 0]
    ticks = config.ticks_per_decision
    vx, vy, vz = agent.velocity_mps[0], agent.velocity_mps[1], agent.velocity_mps[2]
    drift(world, i)
    deviation_m, flown, nearest_squared = 0.0, 0, np.inf
    while flown < ticks and not e.collision:
        e.tick += 1
        flown += 1
        if e.tick % 4 == 0:
            refill_ticks(world, i)
        move(world, i, action)
        here_m = deviation(agent)
        deviation_m += here_m
        e.deviation_max_m = max(e.deviation_max_m, here_m)
        for a in range(1 + e.intruders):
            range_nodes(world, i, a)
            navigate(config, world.aircraft[i, a], localisation(config, a))
        for k in range(e.intruders):
            square = separation_squared(agent, world.aircraft[i, 1 + k])
            nearest_squared = min(nearest_squared, square)
            warned = world.contacts[i, k].warning
            range_contact(world, i, k)
            warn(world, i, k)
            judge(config, e, world.contacts[i, k], world.links[i, k], square, warned)
    for a in range(1 + e.intruders):
        fix(world, i, a)
    e.deviation_m = deviation_m / flown
    e.terminated, e.truncated = e.collision, e.tick >= e.ticks and not e.collision
    vx, vy, vz = agent.velocity_mps[0] - vx, agent.velocity_mps[1] - vy, agent.velocity_mps[2] - vz
    return reward(config, e, sqrt(vx * vx + vy * vy + vz * vz), sqrt(nearest_squared))


@kernel(forceinline=True)
def judge(config, e, contact, link, separation_squared_m2, warned_before):
    """Compare the warning with the true separation: first warning, false alerts, missed detections."""
    inside = separation_squared_m2 <= config.radius_m * config.radius_m
    if contact.warning and not warned_before:
        if e.warned_s < 0.0:
            e.warned_s = e.tick * config.tick_s
        if not inside:
            e.false_alerts += 1
    contact.missed = contact.missed + 1 if inside and link.range_m > config.radius_m else 0
    e.missed = max(e.missed, contact.missed)


@kernel(forceinline=True)
def deviation(craft):
    """|u - u^d|, m."""
    x = craft.position_m[0] - craft.planned_m[0]
    y = craft.position_m[1] - craft.planned_m[1]
    z = craft.position_m[2] - craft.planned_m[2]
    return sqrt(x * x + y * y + z * z)


@kernel(forceinline=True)
def reward(config, e, velocity_change_mps, nearest_m):
    """-(q |u - u^d| + kappa |dv|) of (42), a soft proximity cost, and a collision cost that a crash never escapes.

    A collision also pays q S for every decision that the flight had left, as if it had gone on at a deviation of S.
    """
    closeness = max(0.0, 1.0 - nearest_m / config.comfort_m)
    e.cost = 1.0 if e.collision else closeness * closeness
    e.reward_tracking = -config.tracking_pm * e.deviation_m
    e.reward_effort = -config.effort_spm * velocity_change_mps
    e.reward_proximity = -config.proximity * closeness * closeness
    e.reward_collision = 0.0
    if e.collision:
        left = (e.ticks - e.tick) // config.ticks_per_decision
        e.reward_collision = -(config.collision + config.tracking_pm * config.radius_m * left)
    return e.reward_tracking + e.reward_effort + e.reward_proximity + e.reward_collision
