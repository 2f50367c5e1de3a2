"""The world: a decision, or the start of an episode, in a block of rows; the single environment is a batch of one.

Order of a tick: everybody moves; every link gets its true length and its RSS; every aircraft updates its navigation
solution; every link is ranged; events are read from the true motion; warnings open or close and messages arrive.
After the last tick of a decision the cost is added up, and tracks and observation are made of what was sensed.
Passes (`flight`, `links`, `navigation`) do one thing in all rows of the block; the rest goes row by row.
"""

from math import sqrt

import numpy as np

from rss_gym.alerts import add_up, alert, witness
from rss_gym.cost import conclude, is_finite, potential_m
from rss_gym.encounters.complication import complicate
from rss_gym.encounters.sampler import draw
from rss_gym.flight import command, follow_plan, measure, meet, move, plan, steer
from rss_gym.jit import inner, kernel
from rss_gym.lanes import choose, load, load_leg, owner, store
from rss_gym.links import estimate, face_intruder, face_node, receive, start_filter, transmit
from rss_gym.navigation import assess, localisation, navigate
from rss_gym.observation import transform, write
from rss_gym.physics.geometry import assign, zero
from rss_gym.physics.noise import gauss_markov
from rss_gym.physics.random import episode_key, fill_normals, normal, uniform
from rss_gym.records import DEAD_RECKONING, GNSS, ORACLE, RANGES, RSS
from rss_gym.sensing import reveal_track, sense_other, sense_own
from rss_gym.streams import MAX_INTRUDERS, NODES, STREAM_EPISODE, STREAM_START_AIRCRAFT, STREAM_START_LINK
from rss_gym.tracking.advance import advance


@kernel
def start(world, seen, mask, split, seeds, numbers, observations):
    """Start the given episodes in the rows of `mask`, a block at a time, and write their observations.

    The first measurement, solution and warning exist before the first decision. Returns the first row whose encounter
    could not be drawn, -1 if all could.
    """
    config, block, i = world.config[0], world.block[0], 0
    aircraft, contacts, links = world.aircraft_lanes, world.contact_lanes, world.link_lanes
    while i < len(mask):
        i = choose(block, mask, True, i)
        for r in range(block.rows):
            row = block.row[r]
            reset_row(world, row, split[row], seeds[row], numbers[row])
            if world.episode[row].family < 0:
                return row
            load(world, r)
            load_normals(world, r)
        listen(config, block, aircraft, contacts, links, world.used)
        if config.lossy:
            receive(config, world.channels, world.episode, world.contacts, block, links, world.used)
        for n in range(len(world.used)):
            start_filter(config, block, links[world.used[n]], world.used[n] >= config.intruders)
        assess(config, block, aircraft, links)
        for r in range(block.rows):
            row, e = block.row[r], world.episode[block.row[r]]
            for k in range(e.intruders):
                alert(
                    config, e, k, world.contacts[row, k], world.aircraft[row, 1 + k], aircraft[0], aircraft[1 + k],
                    contacts[k], links[k], world.mail[row, k, slot(config, 0)], world.mail[row, k, slot(config, 1)], r,
                )  # fmt: skip
            store(world, r)
            e.potential_m = potential_m(world, row)
        observe(world, seen, observations)
    return -1


@kernel
def decide(world, seen, skip, actions, observations, rewards):
    """Fly a decision in the rows that are not in `skip`, a block at a time, and write their observations.

    `actions` (n, 3) are in [-1, 1]: along, right, up. Returns the first row whose state is not finite, -1 if none.
    """
    config, block, i = world.config[0], world.block[0], 0
    aircraft, contacts, links = world.aircraft_lanes, world.contact_lanes, world.link_lanes
    failed = -1
    while i < len(skip):
        i = choose(block, skip, False, i)
        for r in range(block.rows):
            drift(world, block.row[r])
            world.episode[block.row[r]].deviation_m = 0.0
            load(world, r)
            begin(block, r, actions[block.row[r]])
        for tick in range(config.ticks_per_decision):
            for r in range(block.rows):
                e = world.episode[block.row[r]]
                if not e.collision:  # a row stays where it collided, though its lane goes on
                    e.tick += 1
                    block.tick[r], block.flown[r] = e.tick, tick + 1
                    for a in range(1 + e.intruders):
                        keep_time(config, e, world.aircraft[block.row[r], a], aircraft[a], r)
                    load_normals(world, r)
            fly(config, block, aircraft, contacts)
            listen(config, block, aircraft, contacts, links, world.used)
            if config.lossy:
                receive(config, world.channels, world.episode, world.contacts, block, links, world.used)
            for n in range(len(world.used)):
                estimate(config, block, links[world.used[n]])
            for r in range(block.rows):
                row, e = block.row[r], world.episode[block.row[r]]
                if block.flown[r] == tick + 1:
                    for k in range(e.intruders):
                        witness(config, block, e, contacts[k], r)
                    add_up(config, block, e, r)
                    now, oldest = slot(config, e.tick), slot(config, e.tick + 1)
                    for k in range(e.intruders):  # a function of the whole world would count references at every call
                        alert(
                            config, e, k, world.contacts[row, k], world.aircraft[row, 1 + k],
                            aircraft[0], aircraft[1 + k], contacts[k], links[k],
                            world.mail[row, k, now], world.mail[row, k, oldest], r,
                        )  # fmt: skip
                    if e.collision:
                        store(world, r)
        for r in range(block.rows):
            if block.flown[r] < config.ticks_per_decision:
                load(world, r)
        assess(config, block, aircraft, links)
        for r in range(block.rows):
            row = block.row[r]
            store(world, r)
            rewards[row] = conclude(world, row, block.flown[r])
        observe(world, seen, observations)
        for r in range(block.rows):
            if failed < 0 and not is_finite(world, block.row[r]):
                failed = block.row[r]
    return failed


@inner(forceinline=True)
def slot(config, tick):
    """Where the message of a tick lies in the ring of those on their way."""
    return tick % (config.latency_ticks + 1) if config.latency_ticks > 0 else 0


@inner
def observe(world, seen, observations):
    """Sense, track and write the observations of the rows of the block."""
    block, config = world.block[0], world.config[0]
    for r in range(block.rows):
        i = block.row[r]
        own, e = seen.own[i], world.episode[i]
        sense_own(config, e, world.aircraft[i, 0], own)
        for k in range(config.intruders):
            other, track = seen.others[i, k], world.tracks[i, k]
            if k >= e.intruders:
                other.present = False
                continue
            sense_other(
                config, e, world.channels[e.channel], world.contacts[i, k], world.links[i, k],
                world.aircraft[i, 1 + k], own, other,
            )  # fmt: skip
            if config.information == ORACLE:
                reveal_track(own, other, track)
            else:
                advance(config.tracker, own, other, world.memories[i, k], track, world.model[0])
        write(own, seen.others[i], world.tracks[i], config.planar, config.information != RANGES, seen.raw)
        transform(seen.raw, seen.table, observations[i])


# -- reset ------------------------------------------------------------------------------------------------------------


@inner
def reset_row(world, i, split, seed, number):
    """Start episode `number` of `seed` in row i: draw the encounter, the channel and every stationary error."""
    config, e, aircraft = world.config[0], world.episode[i], world.aircraft[i]
    links, contacts = world.links[i], world.contacts[i]
    key = episode_key(split, seed, number)
    e.split, e.seed, e.number, e.key = split, seed, number, key
    e.channel = min(int(uniform(key, STREAM_EPISODE, 0) * len(world.channels)), len(world.channels) - 1)
    span = config.intruders - config.intruders_min + 1
    e.intruders = config.intruders_min + min(int(uniform(key, STREAM_EPISODE, 1) * span), span - 1)
    tail_s = config.tail_min_s + (config.tail_max_s - config.tail_min_s) * uniform(key, STREAM_EPISODE, 2)
    e.family, e.approach_s, end_s = draw(key, config, world.families, aircraft, e.intruders, tail_s)
    ticks = config.ticks_per_decision
    e.tick, e.ticks = 0, max(int(np.ceil(end_s / (ticks * config.tick_s) - 1e-9)), 1) * ticks
    e.collision = e.snmac = e.zone = e.terminated = e.truncated = False
    e.deviation_m = e.deviation_max_m = e.flown_m = e.closest_s = 0.0
    e.deviation_sum_m = e.proximity_sum = e.severity_sum = 0.0
    e.cost_m = e.cost_deviation_m = e.cost_snmac_m = e.cost_proximity_m = 0.0
    e.deviation_mean_m = e.zone_severity = 0.0
    e.warned_s = -1.0
    e.false_alerts = e.missed = 0
    e.reward_deviation = e.reward_snmac = e.reward_collision = e.reward_proximity = e.reward_shaping = 0.0
    for a in range(1 + e.intruders):
        start_aircraft(config, aircraft[a], localisation(config, a), key, a)
    e.min_separation_m = np.inf
    for k in range(e.intruders):
        e.min_separation_m = min(e.min_separation_m, sqrt(separation_squared(aircraft[0], aircraft[1 + k])))
        clear_contact(config, contacts[k])
        world.memories[i, k, :] = 0.0
        world.tracks[i, k].valid = False
        for slot in range(world.mail.shape[2]):
            world.mail[i, k, slot].sent = False
    e.zone = e.min_separation_m < config.radius_m
    channel = world.channels[e.channel]
    for link in range(len(links)):
        g = link if link < config.intruders else MAX_INTRUDERS + link - config.intruders
        start_link(channel, links[link], key, g)
    for k in range(e.intruders):
        law = world.families[aircraft[1 + k].law]
        complicate(law, config.radius_m, key, k, aircraft[0], aircraft[1 + k], contacts[k], links[k])


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
    stream = STREAM_START_LINK + g
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
def begin(block, r, action):
    """Start the decision of lane r."""
    block.flown[r], block.nearest_m[r] = 0, np.inf
    for axis in range(3):
        block.action[axis, r] = action[axis]


@inner(forceinline=True)
def keep_time(config, e, craft, lanes, r):
    """The clock of an aircraft on lane r, which stands still in a hover, and its leg."""
    now_s = (e.tick - 1) * config.tick_s
    if now_s < lanes.hover_until_s[r]:
        lanes.held_s[r] += config.tick_s
    lanes.clock_s[r] = now_s + config.tick_s - lanes.held_s[r]
    if lanes.clock_s[r] >= lanes.turn_s[r]:
        plan(craft, lanes.clock_s[r])
        load_leg(lanes, r, craft)


@inner(forceinline=True)
def load_normals(world, r):
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
def fly(config, block, aircraft, contacts):
    """Everybody flies for one tick."""
    agent = aircraft[0]
    command(config, block, agent)
    for k in range(config.intruders):
        follow_plan(config, block, aircraft[1 + k])
    for a in range(1 + config.intruders):
        steer(config, block, aircraft[a])
    for k in range(config.intruders):
        meet(config, block, agent, aircraft[1 + k], contacts[k])
    for a in range(1 + config.intruders):
        move(config, block, aircraft[a])
    measure(config, block, agent)


@inner
def listen(config, block, aircraft, contacts, links, used):
    """One tick of the radio, up to the RSS of every link, and of the navigation solutions."""
    intruders = config.intruders
    for a in range(1 + intruders):
        if localisation(config, a) == RSS:
            for j in range(NODES):
                face_node(config, block, aircraft[a], config.nodes_m[j], links[intruders + NODES * a + j])
        navigate(config, block, aircraft[a], localisation(config, a))
    for k in range(intruders):
        face_intruder(config, block, aircraft[0], aircraft[1 + k], contacts[k], links[k])
    for n in range(len(used)):
        transmit(block, links[used[n]])


@inner(forceinline=True)
def drift(world, i):
    """Advance the slow processes by one decision: path loss factors, gusts, errors of navigation."""
    config, e = world.config[0], world.episode[i]
    number, channel = e.tick // config.ticks_per_decision, world.channels[e.channel]
    if number % 4 == 0:
        fill_normals(e.key, world.decision_streams, number // 4, world.decision_normals[i])
    at = number % 4  # of the normals, in the order of `records.normal_streams`: four of each
    if config.wanders:
        for n in range(len(world.used)):
            if owner(config, world.used[n]) <= e.intruders:
                link = world.links[i, world.used[n]]
                normal_ = world.decision_normals[i, at]
                link.wander = gauss_markov(link.wander, channel.wander_decay, channel.wander_drive, normal_)
            at += 4
    for a in range(1 + e.intruders):
        # The velocity is known from dead reckoning, or from the radio's broadcast solution.
        mode, velocity_a, velocity_drive = localisation(config, a), config.velocity_decay, config.velocity_drive
        if mode == DEAD_RECKONING:
            velocity_a, velocity_drive = config.drift_decay, config.drift_drive
        craft = world.aircraft[i, a]
        gust, gnss, velocity = craft.gust_mps, craft.gnss_error_m, craft.velocity_error_mps
        for axis in range(2 if config.planar else 3):  # in the plane nothing has errors upwards
            first, second = world.decision_normals[i, at], world.decision_normals[i, at + 4]
            gust[axis] = gauss_markov(gust[axis], config.gust_decay, config.gust_drive_mps, first)
            velocity[axis] = gauss_markov(velocity[axis], velocity_a, velocity_drive, second)
            at += 8
            if mode == GNSS:
                third = world.decision_normals[i, at]
                gnss[axis] = gauss_markov(gnss[axis], config.gnss_decay, config.gnss_drive, third)
                at += 4
        if not config.planar:
            craft.barometer_error_m = gauss_markov(
                craft.barometer_error_m,
                config.barometer_decay,
                config.barometer_drive,
                world.decision_normals[i, at],
            )
            at += 4
