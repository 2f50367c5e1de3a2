"""Rows in and out of the block: a row's records are copied to a lane (`state.BLOCK`), flown, and copied back."""

import numpy as np

from rss_gym.jit import inner
from rss_gym.state import RANGES, ROWS
from rss_gym.streams import NODES

FRESH_S = 2.0


@inner
def gather_rows(block, mask, i):
    """Fill the block with the next rows of `mask` (n,), from row `i` on. Returns the row to go on from."""
    block.rows = 0
    while i < len(mask) and block.rows < ROWS:
        if mask[i]:
            block.row[block.rows] = i
            block.rows += 1
        i += 1
    return i


@inner(forceinline=True)
def link_aircraft(config, link):
    """Number of the aircraft that a link ranges: its intruder, or the aircraft whose node it is to."""
    return 1 + link if link < config.intruders else (link - config.intruders) // NODES


@inner(forceinline=True)
def load(state, r):
    """Copy a row to lane r."""
    config, block = state.config[0], state.block[0]
    i = block.row[r]
    e = state.episode[i]
    block.tick[r] = e.tick
    block.deviation_m[r], block.deviation_max_m[r], block.flown_m[r] = e.deviation_m, e.deviation_max_m, e.flown_m
    now_s = e.tick * config.tick_s
    load_channel(block, r, state.channels[e.channel])
    for a in range(1 + e.intruders):
        load_aircraft(state.aircraft_lanes[a], r, state.aircraft[i, a])
        state.aircraft_lanes[a].clock_s[r] = now_s - state.aircraft[i, a].held_s
    for k in range(e.intruders):
        load_message(state.contact_lanes[k], r, state.contacts[i, k], config.information != RANGES)
    for n in range(len(state.used)):
        load_link(state.link_lanes[state.used[n]], r, state.links[i, state.used[n]], now_s)


@inner(forceinline=True)
def load_channel(block, r, channel):
    """Copy the channel of a row to lane r."""
    block.path_loss_factor[r], block.offset_dbm[r] = channel.path_loss_factor, channel.offset_dbm
    block.white_std_db[r], block.white_variance_db2[r] = channel.white_std_db, channel.white_variance_db2
    block.coloured_variance_db2[r], block.coloured_decay[r] = channel.coloured_variance_db2, channel.coloured_decay
    block.coloured_drive_db[r], block.sensitivity_dbm[r] = channel.coloured_drive_db, channel.sensitivity_dbm


@inner(forceinline=True)
def load_aircraft(lanes, r, aircraft):
    """Copy an aircraft to lane r."""
    lanes.held_s[r], lanes.hover_until_s[r] = aircraft.held_s, aircraft.hover_until_s
    lanes.barometer_error_m[r], lanes.datum_error_m[r] = aircraft.barometer_error_m, aircraft.datum_error_m
    lanes.solution_std_m[r] = aircraft.solution_std_m
    for axis in range(3):
        lanes.position_m[axis, r] = aircraft.position_m[axis]
        lanes.velocity_mps[axis, r] = aircraft.velocity_mps[axis]
        lanes.gust_mps[axis, r] = aircraft.gust_mps[axis]
        lanes.way_point_m[axis, r] = aircraft.way_point_m[axis]
        lanes.planned_m[axis, r] = aircraft.planned_m[axis]
        lanes.gnss_error_m[axis, r] = aircraft.gnss_error_m[axis]
        lanes.velocity_error_mps[axis, r] = aircraft.velocity_error_mps[axis]
        lanes.drift_m[axis, r] = aircraft.drift_m[axis]
        lanes.solution_m[axis, r] = aircraft.solution_m[axis]
        lanes.solution_mps[axis, r] = aircraft.solution_mps[axis]
    load_leg(lanes, r, aircraft)


@inner(forceinline=True)
def load_leg(lanes, r, aircraft):
    """Copy the leg that an aircraft flies to lane r."""
    leg = aircraft.leg
    lanes.leg_s[r] = aircraft.path_s[leg]
    lanes.turn_s[r] = aircraft.path_s[leg + 1] if leg + 2 < aircraft.path_points else np.inf
    for axis in range(3):
        lanes.leg_m[axis, r] = aircraft.path_m[leg, axis]
        lanes.planned_mps[axis, r] = aircraft.planned_mps[axis]
        lanes.along[axis, r] = aircraft.along[axis]


@inner(forceinline=True)
def is_fresh(contact):
    """Whether the warning is open and the message held is young enough to say how the range changes."""
    return contact.valid and contact.warning and contact.age_s <= FRESH_S


@inner(forceinline=True)
def load_message(lanes, r, contact, positions):
    """Copy the message held to lane r, where messages carry `positions`."""
    lanes.known[r] = 1.0 if positions and is_fresh(contact) else 0.0
    lanes.std_m[r] = contact.std_m
    for axis in range(3):
        lanes.position_m[axis, r] = contact.position_m[axis]
        lanes.velocity_mps[axis, r] = contact.velocity_mps[axis]


@inner(forceinline=True)
def path_loss_offset(link, time_s):
    """True path loss factor of a link at `time_s` minus the channel's; no unit."""
    return link.wander + (link.jump if time_s >= link.jump_s else 0.0)


@inner(forceinline=True)
def load_link(lanes, r, link, time_s):
    """Copy a link to lane r."""
    lanes.coloured_db[r], lanes.wander[r] = link.coloured_db, path_loss_offset(link, time_s)
    lanes.range_m[r], lanes.coloured_hat_db[r] = link.range_m, link.coloured_hat_db
    lanes.p_dd[r], lanes.p_dp[r], lanes.p_pp[r] = link.p_dd, link.p_dp, link.p_pp
    lanes.rate_mps[r] = link.rate_mps


@inner(forceinline=True)
def store(state, r):
    """Copy lane r to its row. Contacts and events are written where they happen."""
    config, block = state.config[0], state.block[0]
    i = block.row[r]
    e = state.episode[i]
    e.deviation_m, e.deviation_max_m, e.flown_m = block.deviation_m[r], block.deviation_max_m[r], block.flown_m[r]
    for a in range(1 + e.intruders):
        store_aircraft(state.aircraft[i, a], state.aircraft_lanes[a], r)
    for n in range(len(state.used)):
        if link_aircraft(config, state.used[n]) <= e.intruders:
            store_link(state.links[i, state.used[n]], state.link_lanes[state.used[n]], r)


@inner(forceinline=True)
def store_aircraft(aircraft, lanes, r):
    """Copy lane r to an aircraft."""
    aircraft.held_s, aircraft.solution_std_m = lanes.held_s[r], lanes.solution_std_m[r]
    for axis in range(3):
        aircraft.position_m[axis] = lanes.position_m[axis, r]
        aircraft.velocity_mps[axis] = lanes.velocity_mps[axis, r]
        aircraft.way_point_m[axis] = lanes.way_point_m[axis, r]
        aircraft.planned_m[axis] = lanes.planned_m[axis, r]
        aircraft.drift_m[axis] = lanes.drift_m[axis, r]
        aircraft.solution_m[axis] = lanes.solution_m[axis, r]
        aircraft.solution_mps[axis] = lanes.solution_mps[axis, r]


@inner(forceinline=True)
def store_link(link, lanes, r):
    """Copy lane r to a link."""
    link.coloured_db = lanes.coloured_db[r]
    link.range_m, link.coloured_hat_db = lanes.range_m[r], lanes.coloured_hat_db[r]
    link.p_dd, link.p_dp, link.p_pp = lanes.p_dd[r], lanes.p_dp[r], lanes.p_pp[r]
    link.rate_mps = lanes.rate_mps[r]
