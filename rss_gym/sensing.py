"""State -> Sensed: own solution, the filters' ranges, the zone's state and the held messages.

True states enter only with information `oracle`, in the functions that say so.
"""

from math import sqrt

from rss_gym.encounters.sampler import leg_at, planned
from rss_gym.jit import inner
from rss_gym.lanes import path_loss_offset
from rss_gym.physics.geometry import assign
from rss_gym.state import ORACLE


@inner(forceinline=True)
def sense_own(config, e, agent, own):
    """Fill `own` with what the agent knows of itself: its solution and its plan."""
    assign(own.position_m, agent.solution_m)
    assign(own.velocity_mps, agent.solution_mps)
    own.std_m = agent.solution_std_m
    assign(own.planned_m, agent.planned_m)
    assign(own.planned_mps, agent.planned_mps)
    assign(own.along, agent.along)
    assign(own.way_point_m, agent.way_point_m)
    # The agent never hovers, so its own clock is that of the flight.
    later_s = e.tick * config.tick_s + config.announce_s
    x, y, z, _, _, _ = planned(agent, leg_at(agent, agent.leg, later_s), later_s)
    ahead, now = own.ahead_m, agent.planned_m
    ahead[0], ahead[1], ahead[2] = x - now[0], y - now[1], z - now[2]
    if config.information == ORACLE:
        reveal_own(own, agent)


@inner(forceinline=True)
def sense_other(config, e, channel, contact, link, intruder, own, other):
    """Fill `other` with what the agent knows of an intruder: the filter, the radio, the zone and the message held.

    `intruder`, an AIRCRAFT record, is read on information `oracle` only.
    """
    other.present = True
    other.range_m, other.range_std_m = link.range_m, sqrt(link.p_dd)
    other.coloured_db, other.path_loss_factor = link.coloured_hat_db, channel.path_loss_factor
    other.white_std_db, other.coloured_std_db = channel.white_std_db, channel.coloured_std_db
    other.coloured_tc_s = channel.coloured_tc_s
    other.range_rate_mps = link.rate_mps
    other.radius_m, other.warning = contact.radius_m, contact.warning
    other.consecutive_warnings = min(contact.consecutive_warnings / config.trials, 1.0)
    other.valid, other.age_s, other.std_m = contact.valid, contact.age_s, contact.std_m
    assign(other.position_m, contact.position_m)
    assign(other.velocity_mps, contact.velocity_mps)
    assign(other.way_point_m, contact.way_point_m)
    if config.information == ORACLE:
        reveal(config, own, other, intruder, link, e.tick * config.tick_s)


@inner(forceinline=True)
def reveal_own(own, agent):
    """Information `oracle`: the own true state."""
    for axis in range(3):
        own.position_m[axis] = agent.position_m[axis]
        own.velocity_mps[axis] = agent.velocity_mps[axis] + agent.gust_mps[axis]
    own.std_m = 0.0


@inner(forceinline=True)
def reveal(config, own, other, intruder, link, time_s):
    """Information `oracle`: replace every estimate of an intruder by the truth, as if it were heard everywhere."""
    square = rate = 0.0
    later_s = time_s - intruder.held_s + config.announce_s
    x, y, z, _, _, _ = planned(intruder, leg_at(intruder, intruder.leg, later_s), later_s)
    other.way_point_m[0], other.way_point_m[1], other.way_point_m[2] = x, y, z
    for axis in range(3):
        other.position_m[axis] = intruder.position_m[axis]
        other.velocity_mps[axis] = intruder.velocity_mps[axis] + intruder.gust_mps[axis]
        step_m = intruder.position_m[axis] - own.position_m[axis]
        square += step_m * step_m
        rate += step_m * (other.velocity_mps[axis] - own.velocity_mps[axis])
    other.range_m, other.range_std_m = sqrt(square), 0.0
    other.range_rate_mps = rate / max(other.range_m, 1e-9)
    other.coloured_db = link.coloured_db
    other.path_loss_factor += path_loss_offset(link, time_s)
    other.warning = other.range_m <= other.radius_m
    other.consecutive_warnings = 1.0 if other.warning else 0.0
    other.valid, other.age_s, other.std_m = True, 0.0, 0.0


@inner(forceinline=True)
def reveal_track(own, other, track):
    """Information `oracle`: the track is the truth."""
    for axis in range(3):
        track.position_m[axis] = other.position_m[axis] - own.position_m[axis]
        track.velocity_mps[axis] = other.velocity_mps[axis] - own.velocity_mps[axis]
    track.xx = track.xy = track.yy = track.zz = 0.0
    track.valid, track.side_probability = True, 1.0
