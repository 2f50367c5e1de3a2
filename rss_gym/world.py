"""The world: a decision, or the start of an episode, in a block of rows; the single environment is a batch of one.

Order of a tick: everybody moves; every link gets its true length and its RSS; every aircraft updates its navigation
solution; every link is ranged; events are read from the true motion; warnings open or close and messages arrive.
Passes (`flight`, `links`, `navigation`) do one thing in all rows of the block; the rest goes row by row.
"""

from math import sqrt

import numpy as np

from rss_gym.alerts import judge, warn, witness
from rss_gym.encounters.sampler import draw
from rss_gym.flight import command, follow_plan, measure, meet, move, plan, steer
from rss_gym.jit import inner, kernel
from rss_gym.lanes import choose, load, load_leg, owner, store
from rss_gym.links import estimate, face_intruder, face_node, receive, start_filter, transmit
from rss_gym.navigation import assess, choose_nodes, localisation, navigate
from rss_gym.observation import write
from rss_gym.params import MAX_INTRUDERS
from rss_gym.physics.geometry import assign, zero
from rss_gym.physics.noise import gauss_markov
from rss_gym.physics.random import episode_key, fill_normals, normal, uniform
from rss_gym.records import DEAD_RECKONING, NODES, RSS, STREAM_START_AIRCRAFT, STREAM_START_LINK
from rss_gym.sensing import sense_row


@kernel
def run(world, own, others, planar, positions, mask, fresh, split, seeds, numbers, actions, observations, rewards):
    """Start an episode (`fresh`) or fly a decision in the rows of `mask`, and write their observations.

    Parameters
    ----------
    world : World
    own, others : arrays of OWN (n,) and OTHER (n, K)
        What each agent knows; overwritten.
    planar, positions : bool
        Layout of the observation.
    mask : (n,) bool array
    fresh : bool
    split, seeds, numbers : (n,) arrays
        The episodes to start.
    actions : (n, 3) array
        In [-1, 1]: along, right, up.
    observations, rewards : (n, d) float32 array, (n,) array
        Overwritten.

    Returns
    -------
    int
        The first row whose encounter could not be drawn, -1 if all could.
    """
    config, block, i = world.config[0], world.block[0], 0
    ticks = 0 if fresh else config.ticks_per_decision
    while i < len(mask):
        i = choose(block, mask, i)
        for r in range(block.rows):
            row = block.row[r]
            if fresh:
                reset_row(world, row, split[row], seeds[row], numbers[row])
                if world.episode[row].family < 0:
                    return row
            else:
                drift(world, row)
            load(world, r)
            begin(block, world.aircraft_lanes[0], r, actions[row])
        if fresh:
            listen(world, fresh)
        for tick in range(ticks):
            fly(world)
            listen(world, fresh)
            for r in range(block.rows):
                if block.flown[r] > tick:
                    note(world, r)
        for r in range(block.rows):
            if block.flown[r] < ticks:
                load(world, r)  # it stays where it collided; its lane went on without it
        for a in range(1 + config.intruders):
            if localisation(config, a) == RSS:
                choose_nodes(config, block, world.link_lanes, config.intruders + NODES * a)
            assess(config, block, world.aircraft_lanes[a], localisation(config, a))
        for r in range(block.rows):
            row = block.row[r]
            if fresh:
                alert(world, r)
            store(world, r)
            if not fresh:
                rewards[row] = conclude(config, block, world.episode[row], world.aircraft_lanes[0], r)
            sense_row(world, row, own[row], others[row])
            write(own[row], others[row], planar, positions, observations[row])
    return -1


# -- reset ------------------------------------------------------------------------------------------------------------


@inner
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


@inner
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


@inner
def clear_contact(config, contact):
    """Nothing heard yet."""
    contact.radius_m = config.radius_m
    contact.warning = contact.hovered = contact.valid = False
    contact.clear_s = contact.age_s = contact.std_m = 0.0
    contact.streak = contact.missed = 0
    zero(contact.position_m)
    zero(contact.velocity_mps)
    zero(contact.way_point_m)


@inner
def start_link(channel, link, key, g):
    """Stationary channel."""
    stream = STREAM_START_LINK + 10 + g
    link.coloured_db = channel.coloured_std_db * normal(key, stream, 0)
    link.wander = channel.wander_std * normal(key, stream, 1)
    link.coloured_hat_db = link.rate_mps = 0.0


@inner(forceinline=True)
def separation_squared(one, two):
    """Squared distance of two aircraft, m^2."""
    x = one.position_m[0] - two.position_m[0]
    y = one.position_m[1] - two.position_m[1]
    z = one.position_m[2] - two.position_m[2]
    return x * x + y * y + z * z


# -- decision ---------------------------------------------------------------------------------------------------------


@inner(forceinline=True)
def begin(block, agent, r, action):
    """Start the decision of lane r."""
    block.flown[r], block.deviation_m[r], block.nearest_squared_m2[r] = 0, 0.0, np.inf
    for axis in range(3):
        block.action[axis, r], block.before_mps[axis, r] = action[axis], agent.velocity_mps[axis, r]


@inner(forceinline=True)
def fly(world):
    """Everybody flies for one tick, but in rows that have collided."""
    config, block, aircraft = world.config[0], world.block[0], world.aircraft_lanes
    for r in range(block.rows):
        e = world.episode[block.row[r]]
        if not e.collision:
            e.tick += 1
            block.tick[r] = e.tick
            block.flown[r] += 1
            for a in range(1 + e.intruders):
                keep_time(config, aircraft[a], world.aircraft[block.row[r], a], r, (e.tick - 1) * config.tick_s)
    for a in range(1 + config.intruders):
        if a == 0:
            command(config, block, aircraft[0])
        else:
            follow_plan(config, block, aircraft[a])
        steer(config, block, aircraft[a])
    for k in range(config.intruders):
        meet(config, block, aircraft[0], aircraft[1 + k], world.contact_lanes[k])
    for a in range(1 + config.intruders):
        move(config, block, aircraft[a])
    measure(config, block, aircraft[0])


@inner(forceinline=True)
def keep_time(config, lanes, craft, r, now_s):
    """The clock of an aircraft on lane r, which stands still in a hover, and its leg."""
    if now_s < lanes.hover_until_s[r]:
        lanes.held_s[r] += config.tick_s
    lanes.clock_s[r] = now_s + config.tick_s - lanes.held_s[r]
    if lanes.clock_s[r] >= lanes.turn_s[r]:
        plan(craft, lanes.clock_s[r])
        load_leg(lanes, r, craft)


@inner
def listen(world, first):
    """One tick of the radio and of the navigation solutions; the `first` one of an episode starts the filters."""
    config, block = world.config[0], world.block[0]
    aircraft, links = world.aircraft_lanes, world.link_lanes
    for r in range(block.rows):
        take_normals(world, r)
    for a in range(1 + config.intruders):
        mode = localisation(config, a)
        if mode == RSS:
            for j in range(NODES):
                face_node(config, block, aircraft[a], config.nodes_m[j], links[config.intruders + NODES * a + j])
        navigate(config, block, aircraft[a], mode)
    for k in range(config.intruders):
        face_intruder(config, block, aircraft[0], aircraft[1 + k], world.contact_lanes[k], links[k])
    for n in range(len(world.used)):
        s = world.used[n]
        transmit(block, links[s])
        if config.lossy:
            receive(config, world.channels, world.episode, block, s, links[s])
        if first:
            start_filter(config, block, links[s], s >= config.intruders)
        else:
            estimate(config, block, links[s])


@inner(forceinline=True)
def take_normals(world, r):
    """Put the normals of the tick on lane r; they are drawn for four ticks at once."""
    i = world.block[0].row[r]
    e, slot = world.episode[i], world.episode[i].tick % 4
    if slot == 0:
        fill_normals(e.key, world.tick_streams, e.tick // 4, world.tick_normals[i])
    for n in range(len(world.used)):
        link = world.link_lanes[world.used[n]]
        link.coloured_normal[r] = world.tick_normals[i, 8 * n + slot]
        link.white_normal[r] = world.tick_normals[i, 8 * n + 4 + slot]


@inner(forceinline=True)
def note(world, r):
    """What the tick means for lane r."""
    block = world.block[0]
    e = world.episode[block.row[r]]
    for k in range(e.intruders):
        witness(world.config[0], e, world.contact_lanes[k], r)
        square = world.link_lanes[k].distance_squared_m2[r]
        block.nearest_squared_m2[r] = min(block.nearest_squared_m2[r], square)
    alert(world, r)
    if e.collision:
        store(world, r)


@inner(forceinline=True)
def alert(world, r):
    """Warnings and messages of lane r."""
    config, i = world.config[0], world.block[0].row[r]
    e, agent = world.episode[i], world.aircraft_lanes[0]
    for k in range(e.intruders):
        contact, link = world.contacts[i, k], world.link_lanes[k]
        craft, lanes, warned = world.aircraft_lanes[1 + k], world.contact_lanes[k], contact.warning
        warn(config, e, contact, world.aircraft[i, 1 + k], agent, craft, link, lanes, r)
        judge(config, e, contact, link, r, warned)


@inner(forceinline=True)
def conclude(config, block, e, agent, r):
    """End the decision of lane r, whose row is stored. Returns the reward."""
    e.deviation_m /= block.flown[r]
    e.terminated, e.truncated = e.collision, e.tick >= e.ticks and not e.collision
    v, before = agent.velocity_mps, block.before_mps
    vx, vy, vz = v[0, r] - before[0, r], v[1, r] - before[1, r], v[2, r] - before[2, r]
    return reward(config, e, sqrt(vx * vx + vy * vy + vz * vz), sqrt(block.nearest_squared_m2[r]))


@inner(forceinline=True)
def drift(world, i):
    """Advance the slow processes by one decision: path loss factors, gusts, errors of navigation."""
    config, e, normals = world.config[0], world.episode[i], world.decision_normals[i]
    number, channel = e.tick // config.ticks_per_decision, world.channels[e.channel]
    if number % 4 == 0:
        fill_normals(e.key, world.decision_streams, number // 4, normals)
    at = number % 4  # of the normals, in the order of `records.streams`: four of each
    for n in range(len(world.used)):
        if owner(config, world.used[n]) <= e.intruders:
            link = world.links[i, world.used[n]]
            link.wander = gauss_markov(link.wander, channel.wander_decay, channel.wander_drive, normals[at])
        at += 4
    for a in range(1 + e.intruders):
        # The velocity is known from dead reckoning, or from the radio's broadcast solution.
        velocity_a, velocity_drive = config.velocity_decay, config.velocity_drive
        if localisation(config, a) == DEAD_RECKONING:
            velocity_a, velocity_drive = config.drift_decay, config.drift_drive
        craft = world.aircraft[i, a]
        gust, gnss, velocity = craft.gust_mps, craft.gnss_error_m, craft.velocity_error_mps
        for axis in range(2 if config.planar else 3):  # in the plane nothing has errors upwards
            gust[axis] = gauss_markov(gust[axis], config.gust_decay, config.gust_drive_mps, normals[at])
            gnss[axis] = gauss_markov(gnss[axis], config.gnss_decay, config.gnss_drive, normals[at + 4])
            velocity[axis] = gauss_markov(velocity[axis], velocity_a, velocity_drive, normals[at + 8])
            at += 12
        if not config.planar:
            craft.barometer_error_m = gauss_markov(
                craft.barometer_error_m, config.barometer_decay, config.barometer_drive, normals[at]
            )
            at += 4


@inner(forceinline=True)
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
