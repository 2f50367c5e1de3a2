"""The world: a step, or the start of an episode, in a block of rows; the single environment is a batch of one.

How a step runs. `reset` and `step` take the rows of a mask in blocks of 16 (`lanes`), each row on a lane:
 1. the slow errors (gusts, navigation, path loss factor) advance by a step (`advance_slow_noise`);
 2. the rows are copied to lanes, with their actions;
 3. then, on each of the step's ticks of the radio:
    a. clocks advance, and the normals of the tick are drawn as functions of (episode key, stream, tick);
    b. everybody flies (`flight`): commanded way point, autopilot, true relative motion, positions;
    c. every aircraft dead-reckons its own solution (`navigation`), every link gets its true length, its control input
       and its RSS (`links`), and every estimator of range is updated;
    d. in each row that still flies: events are read from the true motion, warnings open or close, and messages are
       sent, lost and received (`alerts`);
 4. solutions by radio get a fix from their ranges (`navigation.update_fixes`), and the lanes are copied back;
 5. the cost is added up, which gives the reward (`cost.finish_step`);
 6. what the agent may know is copied into `sensed` records (`sensing`), the tracker advances on these alone
    (`tracking`), and `observation` writes both as one vector.
Passes over a block do one thing in all its rows, in loops over lanes; the rest goes row by row.
"""

from math import sqrt

import numpy as np

from rss_gym.alerts import add_closeness, detect_events, update_contact
from rss_gym.cost import finish_step, is_finite, potential_m
from rss_gym.encounters.complication import complicate
from rss_gym.encounters.sampler import draw
from rss_gym.flight import command, follow_plan, measure_path, move, relative_motion, steer, update_plan
from rss_gym.jit import inner, kernel
from rss_gym.lanes import gather_rows, link_aircraft, load, load_leg, store
from rss_gym.links import estimate, link_geometry_intruder, link_geometry_node, receive, start_filter, transmit
from rss_gym.navigation import localisation, navigate, update_fixes
from rss_gym.observation import transform, write
from rss_gym.physics.geometry import assign, zero
from rss_gym.physics.noise import gauss_markov
from rss_gym.physics.random import episode_key, fill_normals, normal, uniform
from rss_gym.sensing import reveal_track, sense_other, sense_own
from rss_gym.state import DEAD_RECKONING, GNSS, ORACLE, RANGES, RSS
from rss_gym.streams import MAX_INTRUDERS, NODES, STREAM_EPISODE, STREAM_START_AIRCRAFT, STREAM_START_LINK
from rss_gym.tracking.advance import advance


@kernel
def reset(state, seen, mask, split, seeds, numbers, observations):
    """Start an episode in each row of `mask`, a block at a time, and write their observations.

    The first measurement, solution and warning exist before the first step.

    Parameters
    ----------
    state : State
    seen : core.Seen
    mask : (n,) bool array
    split, seeds, numbers : (n,) int64, uint64 and uint64 arrays
        The split, the seed and the number of each row's episode.
    observations : (n, d) float32 array
        Written in the rows of `mask`.

    Returns
    -------
    int
        The first row whose encounter could not be drawn, -1 if all could.
    """
    config, block, i = state.config[0], state.block[0], 0
    aircraft, contacts, links = state.aircraft_lanes, state.contact_lanes, state.link_lanes
    while i < len(mask):
        i = gather_rows(block, mask, i)
        for r in range(block.rows):
            row = block.row[r]
            reset_row(state, row, split[row], seeds[row], numbers[row])
            if state.episode[row].family < 0:
                return row
            load(state, r)
            load_normals(state, r)
        update_radio(config, block, aircraft, contacts, links, state.used)
        if config.lossy:
            receive(config, state.channels, state.episode, state.contacts, block, links, state.used)
        for n in range(len(state.used)):
            start_filter(config, block, links[state.used[n]], state.used[n] >= config.intruders)
        update_fixes(config, block, aircraft, links)
        for r in range(block.rows):
            row, e = block.row[r], state.episode[block.row[r]]
            for k in range(e.intruders):
                update_contact(
                    config, e, k, state.contacts[row, k], state.aircraft[row, 1 + k], aircraft[0], aircraft[1 + k],
                    contacts[k], links[k], state.mail[row, k, slot(config, 0)], state.mail[row, k, slot(config, 1)], r,
                )  # fmt: skip
            store(state, r)
            e.potential_m = potential_m(state, row)
        write_observations(state, seen, observations)
    return -1


@kernel
def step(state, seen, mask, actions, observations, rewards):
    """Fly one step in each row of `mask`, a block at a time, and write their observations and rewards.

    Parameters
    ----------
    state : State
    seen : core.Seen
    mask : (n,) bool array
    actions : (n, 3) float64 array
        In [-1, 1]: along, right, up, in shares of the speed limits.
    observations, rewards : (n, d) float32 and (n,) float64 arrays
        Written in the rows of `mask`; a reward is minus the cost of the step, m.

    Returns
    -------
    int
        The first row whose state is not finite, -1 if none.
    """
    config, block, i = state.config[0], state.block[0], 0
    aircraft, contacts, links = state.aircraft_lanes, state.contact_lanes, state.link_lanes
    failed = -1
    while i < len(mask):
        i = gather_rows(block, mask, i)
        for r in range(block.rows):
            advance_slow_noise(state, block.row[r])
            state.episode[block.row[r]].deviation_m = 0.0
            load(state, r)
            load_action(block, r, actions[block.row[r]])
        for tick in range(config.ticks_per_decision):
            for r in range(block.rows):
                e = state.episode[block.row[r]]
                if not e.collision:  # a row stays where it collided, though its lane goes on
                    e.tick += 1
                    block.tick[r], block.flown[r] = e.tick, tick + 1
                    for a in range(1 + e.intruders):
                        advance_clock(config, e, state.aircraft[block.row[r], a], aircraft[a], r)
                    load_normals(state, r)
            move_aircraft(config, block, aircraft, contacts)
            update_radio(config, block, aircraft, contacts, links, state.used)
            if config.lossy:
                receive(config, state.channels, state.episode, state.contacts, block, links, state.used)
            for n in range(len(state.used)):
                estimate(config, block, links[state.used[n]])
            for r in range(block.rows):
                row, e = block.row[r], state.episode[block.row[r]]
                if block.flown[r] == tick + 1:
                    for k in range(e.intruders):
                        detect_events(config, block, e, contacts[k], r)
                    add_closeness(config, block, e, r)
                    now, oldest = slot(config, e.tick), slot(config, e.tick + 1)
                    for k in range(e.intruders):  # a function of the whole state would count references at every call
                        update_contact(
                            config, e, k, state.contacts[row, k], state.aircraft[row, 1 + k],
                            aircraft[0], aircraft[1 + k], contacts[k], links[k],
                            state.mail[row, k, now], state.mail[row, k, oldest], r,
                        )  # fmt: skip
                    if e.collision:
                        store(state, r)
        for r in range(block.rows):
            if block.flown[r] < config.ticks_per_decision:
                load(state, r)
        update_fixes(config, block, aircraft, links)
        for r in range(block.rows):
            row = block.row[r]
            store(state, r)
            rewards[row] = finish_step(state, row, block.flown[r])
        write_observations(state, seen, observations)
        for r in range(block.rows):
            if failed < 0 and not is_finite(state, block.row[r]):
                failed = block.row[r]
    return failed


@inner(forceinline=True)
def slot(config, tick):
    """Where the message of a tick lies in the ring of those on their way."""
    return tick % (config.latency_ticks + 1) if config.latency_ticks > 0 else 0


@inner
def write_observations(state, seen, observations):
    """Sense, track and write the observations of the rows of the block."""
    block, config = state.block[0], state.config[0]
    for r in range(block.rows):
        i = block.row[r]
        own, e = seen.own[i], state.episode[i]
        sense_own(config, e, state.aircraft[i, 0], own)
        for k in range(config.intruders):
            other, track = seen.others[i, k], state.tracks[i, k]
            if k >= e.intruders:
                other.present = False
                continue
            sense_other(
                config, e, state.channels[e.channel], state.contacts[i, k], state.links[i, k],
                state.aircraft[i, 1 + k], own, other,
            )  # fmt: skip
            if config.information == ORACLE:
                reveal_track(own, other, track)
            else:
                advance(config.tracker, own, other, state.memories[i, k], track, state.model[0])
        write(own, seen.others[i], state.tracks[i], config.planar, config.information != RANGES, seen.raw)
        transform(seen.raw, seen.table, observations[i])


# -- reset ------------------------------------------------------------------------------------------------------------


@inner
def reset_row(state, i, split, seed, number):
    """Start episode `number` of `seed` in row i: draw the encounter, the channel and every stationary error."""
    config, e, aircraft = state.config[0], state.episode[i], state.aircraft[i]
    links, contacts = state.links[i], state.contacts[i]
    key = episode_key(split, seed, number)
    e.split, e.seed, e.number, e.key = split, seed, number, key
    e.channel = min(int(uniform(key, STREAM_EPISODE, 0) * len(state.channels)), len(state.channels) - 1)
    span = config.intruders - config.intruders_min + 1
    e.intruders = config.intruders_min + min(int(uniform(key, STREAM_EPISODE, 1) * span), span - 1)
    tail_s = config.tail_min_s + (config.tail_max_s - config.tail_min_s) * uniform(key, STREAM_EPISODE, 2)
    e.family, e.approach_s, end_s = draw(key, config, state.families, aircraft, e.intruders, tail_s)
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
        e.min_separation_m = min(e.min_separation_m, sqrt(squared_separation_m2(aircraft[0], aircraft[1 + k])))
        clear_contact(config, contacts[k])
        state.memories[i, k, :] = 0.0
        state.tracks[i, k].valid = False
        for slot in range(state.mail.shape[2]):
            state.mail[i, k, slot].sent = False
    e.zone = e.min_separation_m < config.radius_m
    channel = state.channels[e.channel]
    for link in range(len(links)):
        g = link if link < config.intruders else MAX_INTRUDERS + link - config.intruders
        start_link(channel, links[link], key, g)
    for k in range(e.intruders):
        family = state.families[aircraft[1 + k].family]
        complicate(family, config.radius_m, key, k, aircraft[0], aircraft[1 + k], contacts[k], links[k])


@inner
def start_aircraft(config, aircraft, mode, key, a):
    """Put an aircraft on the start of its path, with stationary errors of its navigation."""
    stream = STREAM_START_AIRCRAFT + a
    aircraft.leg, aircraft.held_s, aircraft.hover_until_s = 0, 0.0, 0.0
    aircraft.along[0], aircraft.along[1], aircraft.along[2] = 1.0, 0.0, 0.0
    update_plan(aircraft, 0.0)
    up = 0.0 if config.planar else 1.0
    for axis in range(3):
        free = 1.0 if axis < 2 else up
        aircraft.position_m[axis] = aircraft.planned_m[axis]
        aircraft.velocity_mps[axis] = aircraft.planned_mps[axis]
        aircraft.way_point_m[axis] = aircraft.planned_m[axis]
        aircraft.gust_mps[axis] = free * config.gust_mps * normal(key, stream, axis)
        aircraft.gnss_error_m[axis] = free * normal(key, stream, 3 + axis)  # unit variance, scaled per axis where used
        std = config.drift_mps if mode == DEAD_RECKONING else config.velocity_error_mps
        aircraft.velocity_error_mps[axis] = free * std * normal(key, stream, 6 + axis)
        aircraft.drift_m[axis] = 0.0
    aircraft.barometer_error_m = up * config.barometer_m * normal(key, stream, 9)
    aircraft.datum_error_m = up * config.barometer_datum_m * normal(key, stream, 10)
    assign(aircraft.solution_m, aircraft.planned_m)


@inner
def clear_contact(config, contact):
    """Make a contact one of which nothing has been heard, with its warning closed."""
    contact.radius_m = config.radius_m
    contact.warning = contact.hovered = contact.valid = False
    contact.clear_s = contact.age_s = contact.std_m = 0.0
    contact.consecutive_warnings = contact.missed = 0
    zero(contact.position_m)
    zero(contact.velocity_mps)
    zero(contact.way_point_m)


@inner
def start_link(channel, link, key, g):
    """Draw the coloured noise (dB) and the path loss factor's wander of a link from their stationary laws."""
    stream = STREAM_START_LINK + g
    link.coloured_db = channel.coloured_std_db * normal(key, stream, 0)
    link.wander = channel.wander_std * normal(key, stream, 1)
    link.coloured_hat_db = link.rate_mps = 0.0


@inner(forceinline=True)
def squared_separation_m2(one, two):
    """Squared distance of two aircraft, m^2."""
    x = one.position_m[0] - two.position_m[0]
    y = one.position_m[1] - two.position_m[1]
    z = one.position_m[2] - two.position_m[2]
    return x * x + y * y + z * z


# -- step -------------------------------------------------------------------------------------------------------------


@inner(forceinline=True)
def load_action(block, r, action):
    """Put the action (3,) of a row on lane r, whose step begins."""
    block.flown[r], block.nearest_m[r] = 0, np.inf
    for axis in range(3):
        block.action[axis, r] = action[axis]


@inner(forceinline=True)
def advance_clock(config, e, aircraft, lanes, r):
    """The clock of an aircraft on lane r, which stands still in a hover, and its leg."""
    now_s = (e.tick - 1) * config.tick_s
    if now_s < lanes.hover_until_s[r]:
        lanes.held_s[r] += config.tick_s
    lanes.clock_s[r] = now_s + config.tick_s - lanes.held_s[r]
    if lanes.clock_s[r] >= lanes.turn_s[r]:
        update_plan(aircraft, lanes.clock_s[r])
        load_leg(lanes, r, aircraft)


@inner(forceinline=True)
def load_normals(state, r):
    """Put the normals of the tick on lane r; they are drawn for four ticks at once."""
    i = state.block[0].row[r]
    e, slot = state.episode[i], state.episode[i].tick % 4
    if slot == 0:
        fill_normals(e.key, state.tick_streams, e.tick // 4, state.tick_normals[i])
    for n in range(len(state.used)):
        link = state.link_lanes[state.used[n]]
        link.coloured_normal[r] = state.tick_normals[i, 8 * n + slot]
        link.white_normal[r] = state.tick_normals[i, 8 * n + 4 + slot]


@inner(forceinline=True)
def move_aircraft(config, block, aircraft, contacts):
    """Fly everybody for one tick; `aircraft` (1 + K,) and `contacts` (K,) are lanes."""
    agent = aircraft[0]
    command(config, block, agent)
    for k in range(config.intruders):
        follow_plan(config, block, aircraft[1 + k])
    for a in range(1 + config.intruders):
        steer(config, block, aircraft[a])
    for k in range(config.intruders):
        relative_motion(config, block, agent, aircraft[1 + k], contacts[k])
    for a in range(1 + config.intruders):
        move(config, block, aircraft[a])
    measure_path(config, block, agent)


@inner
def update_radio(config, block, aircraft, contacts, links, used):
    """One tick of the navigation solutions and of the radio, up to the RSS of every link in `used`; all are lanes."""
    intruders = config.intruders
    for a in range(1 + intruders):
        if localisation(config, a) == RSS:
            for j in range(NODES):
                link_geometry_node(config, block, aircraft[a], config.nodes_m[j], links[intruders + NODES * a + j])
        navigate(config, block, aircraft[a], localisation(config, a))
    for k in range(intruders):
        link_geometry_intruder(config, block, aircraft[0], aircraft[1 + k], contacts[k], links[k])
    for n in range(len(used)):
        transmit(block, links[used[n]])


@inner(forceinline=True)
def advance_slow_noise(state, i):
    """Advance the slow processes of row i by one step: path loss factors, gusts, errors of navigation."""
    config, e = state.config[0], state.episode[i]
    number, channel = e.tick // config.ticks_per_decision, state.channels[e.channel]
    if number % 4 == 0:
        fill_normals(e.key, state.decision_streams, number // 4, state.decision_normals[i])
    at = number % 4  # of the normals, in the order of `state.normal_streams`: four of each
    if config.wanders:
        for n in range(len(state.used)):
            if link_aircraft(config, state.used[n]) <= e.intruders:
                link = state.links[i, state.used[n]]
                normal_ = state.decision_normals[i, at]
                link.wander = gauss_markov(link.wander, channel.wander_decay, channel.wander_drive, normal_)
            at += 4
    for a in range(1 + e.intruders):
        # The velocity is known from dead reckoning, or from the radio's broadcast solution.
        mode, velocity_a, velocity_drive = localisation(config, a), config.velocity_decay, config.velocity_drive
        if mode == DEAD_RECKONING:
            velocity_a, velocity_drive = config.drift_decay, config.drift_drive
        aircraft = state.aircraft[i, a]
        gust, gnss, velocity = aircraft.gust_mps, aircraft.gnss_error_m, aircraft.velocity_error_mps
        for axis in range(2 if config.planar else 3):  # in the plane nothing has errors upwards
            first, second = state.decision_normals[i, at], state.decision_normals[i, at + 4]
            gust[axis] = gauss_markov(gust[axis], config.gust_decay, config.gust_drive_mps, first)
            velocity[axis] = gauss_markov(velocity[axis], velocity_a, velocity_drive, second)
            at += 8
            if mode == GNSS:
                third = state.decision_normals[i, at]
                gnss[axis] = gauss_markov(gnss[axis], config.gnss_decay, config.gnss_drive, third)
                at += 4
        if not config.planar:
            aircraft.barometer_error_m = gauss_markov(
                aircraft.barometer_error_m,
                config.barometer_decay,
                config.barometer_drive,
                state.decision_normals[i, at],
            )
            at += 4
