"""One tick of the radio on a road, with the world's own passes; a lane of the block is a vehicle.

A vehicle's number is that of its link, in the order of appearance. Its noise is a function of (episode key, number,
tick): it goes on while the vehicle is out of radio range, and is the same whatever the policy does.
"""

from math import sqrt

import numpy as np

from rss_gym.alerts import score_warning, update_warning
from rss_gym.highway.near_miss import NEAR_MISS_S, time_to_contact_s
from rss_gym.highway.zone import HALF_LANE_M, pair_radius_m
from rss_gym.jit import inner, kernel
from rss_gym.lanes import load_channel, load_link, load_message, path_loss_offset, store_link
from rss_gym.links import estimate, link_geometry_intruder, start_filter, transmit
from rss_gym.physics.elementary import cos, sin
from rss_gym.physics.noise import gauss_markov
from rss_gym.physics.path_loss import quantise
from rss_gym.physics.random import normal, uniform
from rss_gym.state import ORACLE, RANGES, ROWS
from rss_gym.streams import ROAD_STREAMS, STREAM_ROAD

f8, i8, b1 = np.float64, np.int64, np.bool_

ABSENT, FAR, NEW, HELD = range(4)  # not on the road, out of radio range, first heard now, heard before

VEHICLE = np.dtype(
    [
        ("here", b1),  # on the road
        ("born", b1),  # its processes have begun
        ("heard", b1),  # in radio range, with a filter
        ("state", i8),  # of ABSENT ... HELD
        ("position_m", f8, 2),
        ("velocity_mps", f8, 2),
        ("forward", f8, 2),  # unit vector of its heading
        ("gnss_error", f8, 2),  # of unit variance
        ("velocity_error_mps", f8, 2),
    ]
)

# Streams of a vehicle, after its first; the agent is vehicle -1.
TICK_COLOURED, TICK_WHITE, TICK_LOSS, SLOW, START = 0, 1, 2, 3, 8  # SLOW: wander, GNSS x, y, velocity x, y


@kernel(inline="always")
def stream(number):
    """First stream of a vehicle."""
    return STREAM_ROAD + ROAD_STREAMS * (number + 1)


@inner
def begin_vehicle(config, channel, key, number, vehicle, link, contact):
    """Stationary processes of a vehicle that appears; nothing has been heard of it."""
    at = stream(number) + START
    link.coloured_db = channel.coloured_std_db * normal(key, at, 0)
    link.wander = channel.wander_std * normal(key, at, 1)
    link.jump, link.jump_s = 0.0, np.inf
    for axis in range(2):
        vehicle.gnss_error[axis] = normal(key, at, 2 + axis)
        vehicle.velocity_error_mps[axis] = config.velocity_error_mps * normal(key, at, 4 + axis)
    vehicle.born = True
    forget(config, link, contact)


@inner
def forget(config, link, contact):
    """Make link and contact those of a vehicle that was never heard."""
    link.coloured_hat_db = link.rate_mps = 0.0
    contact.radius_m = config.radius_m
    contact.warning = contact.hovered = contact.valid = False
    contact.clear_s = contact.age_s = contact.std_m = 0.0
    contact.consecutive_warnings = contact.missed = 0


@kernel
def advance_slow_noise(config_, channel_, key, decision, vehicles, links):
    """Advance the slow processes by a decision: path loss factors, errors of positions and velocities.

    `vehicles` (1 + n) begin with the agent; `links` (n).
    """
    config, channel = config_[0], channel_[0]
    for i in range(len(vehicles)):
        vehicle, at = vehicles[i], stream(i - 1) + SLOW
        if not vehicle.born:
            continue
        if i > 0:
            link, n = links[i - 1], normal(key, at, decision)
            link.wander = gauss_markov(link.wander, channel.wander_decay, channel.wander_drive, n)
        for axis in range(2):
            n = normal(key, at + 1 + axis, decision)
            vehicle.gnss_error[axis] = gauss_markov(vehicle.gnss_error[axis], config.gnss_decay, config.gnss_drive, n)
            n = normal(key, at + 3 + axis, decision)
            vehicle.velocity_error_mps[axis] = gauss_markov(
                vehicle.velocity_error_mps[axis], config.velocity_decay, config.velocity_drive, n
            )


@kernel
def update_radio(
    config_, channel_, key, radio_range_m, range_error_m, states, roads, first, e_, vehicles, links, contacts, block_,
    agent_, other_, message_, link_,
):  # fmt: skip
    """Some ticks: every vehicle on the road is ranged if in radio range, warnings open or close, messages arrive.

    Parameters
    ----------
    config_, channel_ : (1,) CONFIG, CHANNEL
    key : uint64
        The key of the episode.
    radio_range_m : float
        Beyond it a vehicle is not heard, and its filter ends.
    range_error_m : float
        delta of (40).
    states : (m, 5) array
        Row in `vehicles`, x (m), y (m), heading (rad) and speed (m/s) of all that is on the road, tick after tick.
    roads : (t, 4) array
        Of each tick: end of its rows in `states`, direction of the agent's lane (cosine, sine), and how far (m) the
        agent is to the right of its centre.
    first : int
        Number of the first of these ticks.
    e_ : (1,) EPISODE
        Its events, on true states, are written.
    vehicles : (1 + n,) VEHICLE
        The agent first.
    links, contacts : (n,) LINK, CONTACT
    block_, agent_, other_, message_, link_ : (1,) BLOCK, AIRCRAFT_LANES twice, CONTACT_LANES, LINK_LANES
        Working memory.
    """
    config, channel, e, block = config_[0], channel_[0], e_[0], block_[0]
    agent, other, message, link = agent_[0], other_[0], message_[0], link_[0]
    begin_agent(config, key, vehicles[0])
    row = 0
    for t in range(len(roads)):
        e.tick = first + t
        for i in range(len(vehicles)):
            vehicles[i].here = False
        while row < roads[t, 0]:
            place(vehicles[int(states[row, 0])], states[row])
            row += 1
        for i in range(len(links)):
            classify(config, channel, key, radio_range_m, i, vehicles[0], vehicles[i + 1], links[i], contacts[i])
        for state in range(FAR, HELD + 1):
            i = 0
            while i < len(links):
                i = gather_vehicles(
                    config, channel, key, e, state, i, vehicles, links, contacts, block, agent, other, message, link
                )
                link_geometry_intruder(config, block, agent, other, message, link)
                transmit(block, link)
                for r in range(block.rows):
                    lose_packet(channel, key, e.tick, block.row[r], link, r)
                if state == NEW:
                    start_filter(config, block, link, False)
                elif state == HELD:
                    estimate(config, block, link)
                for r in range(block.rows):
                    n = block.row[r]
                    store_link(links[n], link, r)
                    if state != FAR:
                        update_contact(config, channel, e, vehicles[n + 1], contacts[n], link, r)
                    detect_events(config, e, range_error_m, roads[t], vehicles[0], vehicles[n + 1])


@inner
def begin_agent(config, key, agent):
    """Draw the stationary errors of the agent's own solution, once."""
    if not agent.born:
        at = stream(-1) + START
        for axis in range(2):
            agent.gnss_error[axis] = normal(key, at, 2 + axis)
            agent.velocity_error_mps[axis] = config.velocity_error_mps * normal(key, at, 4 + axis)
        agent.born = True


@inner
def gather_vehicles(config, channel, key, e, state, i, vehicles, links, contacts, block, agent, other, message, link):
    """Load the next vehicles in this state, from link `i` on, into the block. Returns where to go on."""
    block.rows = 0
    while i < len(links) and block.rows < ROWS:
        if vehicles[i + 1].state == state:
            r = block.rows
            block.row[r], block.rows = i, r + 1
            load_channel(block, r, channel)
            load_vehicle(config, agent, vehicles[0], r)
            load_vehicle(config, other, vehicles[i + 1], r)
            load_message(message, r, contacts[i], config.information != RANGES)
            load_link(link, r, links[i], e.tick * config.tick_s)
            link.coloured_normal[r] = normal(key, stream(i) + TICK_COLOURED, e.tick)
            link.white_normal[r] = normal(key, stream(i) + TICK_WHITE, e.tick)
        i += 1
    return i


@inner(forceinline=True)
def place(vehicle, state):
    """Put a vehicle on the road, with position and velocity as vectors."""
    vehicle.here = True
    vehicle.position_m[0], vehicle.position_m[1] = state[1], state[2]
    vehicle.forward[0], vehicle.forward[1] = cos(state[3]), sin(state[3])
    for axis in range(2):
        vehicle.velocity_mps[axis] = state[4] * vehicle.forward[axis]


@inner
def classify(config, channel, key, radio_range_m, number, agent, vehicle, link, contact):
    """What this tick means for a vehicle: `state`."""
    if not vehicle.here:
        vehicle.state, vehicle.heard = ABSENT, False
        return
    if not vehicle.born:
        begin_vehicle(config, channel, key, number, vehicle, link, contact)
    x, y = vehicle.position_m[0] - agent.position_m[0], vehicle.position_m[1] - agent.position_m[1]
    if x * x + y * y > radio_range_m * radio_range_m:
        vehicle.state, vehicle.heard = FAR, False
    elif vehicle.heard:
        vehicle.state = HELD
    else:
        forget(config, link, contact)
        vehicle.state, vehicle.heard = NEW, True


@inner(forceinline=True)
def load_vehicle(config, lanes, vehicle, r):
    """Copy a vehicle to lane r, with its own solution; roads are flat."""
    lanes.solution_std_m[r] = config.gnss_m
    lanes.position_m[2, r] = lanes.solution_m[2, r] = lanes.solution_mps[2, r] = 0.0
    for axis in range(2):
        lanes.position_m[axis, r] = vehicle.position_m[axis]
        lanes.solution_m[axis, r] = vehicle.position_m[axis] + config.gnss_m * vehicle.gnss_error[axis]
        lanes.solution_mps[axis, r] = vehicle.velocity_mps[axis] + vehicle.velocity_error_mps[axis]


@inner(forceinline=True)
def lose_packet(channel, key, tick, number, link, r):
    """Quantise the RSS and lose packets as `rss_gym.links.receive` does; a lost one is minus infinity."""
    link.rss_dbm[r] = quantise(link.rss_dbm[r], channel.quantisation_db)
    if channel.packet_loss > 0.0 and uniform(key, stream(number) + TICK_LOSS, tick) < channel.packet_loss:
        link.rss_dbm[r] = -np.inf


@inner
def update_contact(config, channel, e, vehicle, contact, link, r):
    """Warning and message of a vehicle in radio range; the message rides on the packet that is ranged."""
    warned = contact.warning
    update_warning(config, contact, link.range_m[r])
    if not contact.warning:
        contact.valid = False
    elif link.rss_dbm[r] >= channel.sensitivity_dbm:
        contact.valid, contact.age_s, contact.std_m = True, 0.0, config.gnss_m
        for axis in range(2):
            contact.velocity_mps[axis] = vehicle.velocity_mps[axis] + vehicle.velocity_error_mps[axis]
            if config.information != RANGES:
                contact.position_m[axis] = vehicle.position_m[axis] + config.gnss_m * vehicle.gnss_error[axis]
    score_warning(config, e, contact, link.distance_squared_m2[r], link.range_m[r], warned)


@inner
def detect_events(config, e, range_error_m, road, agent, vehicle):
    """Events of the tick on true states: least separation, near miss, entry into a pair's zone on the agent's lane."""
    x, y = vehicle.position_m[0] - agent.position_m[0], vehicle.position_m[1] - agent.position_m[1]
    separation_m = sqrt(x * x + y * y)
    if separation_m < e.min_separation_m:
        e.min_separation_m, e.closest_s = separation_m, e.tick * config.tick_s
    v, w = vehicle.velocity_mps[0] - agent.velocity_mps[0], vehicle.velocity_mps[1] - agent.velocity_mps[1]
    c, s = agent.forward[0], agent.forward[1]
    forward, right = vehicle.forward[0] * c + vehicle.forward[1] * s, vehicle.forward[1] * c - vehicle.forward[0] * s
    contact_s = time_to_contact_s(x * c + y * s, y * c - x * s, v * c + w * s, w * c - v * s, forward, right)
    if contact_s < NEAR_MISS_S:
        e.snmac = True
    right_m = y * road[1] - x * road[2] + road[3]
    if abs(right_m) < HALF_LANE_M:
        radius_m = pair_radius_m(
            x, y, v, w, range_error_m, config.range_error_probability, config.reaction_s, config.trials
        )
        if separation_m < radius_m:
            e.zone = True


@kernel
def sense(config_, channel_, e_, vehicles, links, contacts, own, others):
    """Fill `own` (1,) OWN and `others` (n,) OTHER with what the agent knows; the truth with `oracle` only."""
    config, channel, e, agent = config_[0], channel_[0], e_[0], vehicles[0]
    exact = config.information == ORACLE
    own[0].std_m = 0.0 if exact else config.gnss_m
    for axis in range(2):
        error_m, error_mps = config.gnss_m * agent.gnss_error[axis], agent.velocity_error_mps[axis]
        own[0].position_m[axis] = agent.position_m[axis] + (0.0 if exact else error_m)
        own[0].velocity_mps[axis] = agent.velocity_mps[axis] + (0.0 if exact else error_mps)
    for i in range(len(links)):
        vehicle, link, contact, other = vehicles[i + 1], links[i], contacts[i], others[i]
        other.present = vehicle.heard
        if not vehicle.heard:
            continue
        other.range_m, other.range_std_m = link.range_m, sqrt(link.p_dd)
        other.range_rate_mps, other.coloured_db = link.rate_mps, link.coloured_hat_db
        other.path_loss_factor, other.coloured_tc_s = channel.path_loss_factor, channel.coloured_tc_s
        other.white_std_db, other.coloured_std_db = channel.white_std_db, channel.coloured_std_db
        other.radius_m, other.warning = contact.radius_m, contact.warning
        other.consecutive_warnings = min(contact.consecutive_warnings / config.trials, 1.0)
        other.valid, other.age_s, other.std_m = contact.valid, contact.age_s, contact.std_m
        for axis in range(2):
            other.position_m[axis] = contact.position_m[axis]
            other.velocity_mps[axis] = contact.velocity_mps[axis]
        if exact:
            reveal(config, e, agent, vehicle, link, channel, other)


@inner
def reveal(config, e, agent, vehicle, link, channel, other):
    """Information `oracle`: replace every estimate by the truth."""
    square = rate = 0.0
    for axis in range(2):
        other.position_m[axis], other.velocity_mps[axis] = vehicle.position_m[axis], vehicle.velocity_mps[axis]
        step_m = vehicle.position_m[axis] - agent.position_m[axis]
        square += step_m * step_m
        rate += step_m * (vehicle.velocity_mps[axis] - agent.velocity_mps[axis])
    other.range_m, other.range_std_m = sqrt(square), 0.0
    other.range_rate_mps = rate / max(other.range_m, 1e-9)
    other.coloured_db = link.coloured_db
    other.path_loss_factor = channel.path_loss_factor + path_loss_offset(link, e.tick * config.tick_s)
    other.warning = other.range_m <= other.radius_m
    other.consecutive_warnings = 1.0 if other.warning else 0.0
    other.valid, other.age_s, other.std_m = True, 0.0, 0.0
