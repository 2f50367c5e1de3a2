"""World -> Sensed: own solution, the filters' ranges, the zone's state and the held messages.

True states enter only on track `oracle`, in the one function that says so.
"""

from math import sqrt

import numpy as np

from rss_gym.jit import inner, kernel
from rss_gym.lanes import departure
from rss_gym.physics.geometry import assign
from rss_gym.records import ORACLE


@kernel
def sense_row(world, i, own, others):
    """Fill `own` (one record) and `others` (K records) with what the agent of row i knows."""
    config, e = world.config[0], world.episode[i]
    agent = world.aircraft[i, 0]
    own.time_s = e.tick * config.tick_s
    assign(own.position_m, agent.solution_m)
    assign(own.velocity_mps, agent.solution_mps)
    assign(own.planned_m, agent.planned_m)
    assign(own.planned_mps, agent.planned_mps)
    assign(own.along, agent.along)
    assign(own.way_point_m, agent.way_point_m)
    own.turn_in_s = np.inf
    assign(own.turn_along, agent.along)
    if agent.leg + 2 < agent.path_points:
        own.turn_in_s = agent.path_s[agent.leg + 1] - own.time_s
        x = agent.path_m[agent.leg + 2, 0] - agent.path_m[agent.leg + 1, 0]
        y = agent.path_m[agent.leg + 2, 1] - agent.path_m[agent.leg + 1, 1]
        length = sqrt(x * x + y * y)
        own.turn_along[0], own.turn_along[1], own.turn_along[2] = x / length, y / length, 0.0
    gamma = world.channels[e.channel].path_loss_factor
    for k in range(len(others)):
        other = others[k]
        other.present = k < e.intruders
        if not other.present:
            continue
        contact, link = world.contacts[i, k], world.links[i, k]
        other.range_m, other.range_std_m = link.range_m, sqrt(link.p_dd)
        other.coloured_db, other.path_loss_factor = link.coloured_hat_db, gamma
        other.range_rate_mps = link.rate_mps
        other.radius_m, other.warning = contact.radius_m, contact.warning
        other.streak = min(contact.streak / config.trials, 1.0)
        other.valid, other.age_s = contact.valid, contact.age_s
        assign(other.position_m, contact.position_m)
        assign(other.velocity_mps, contact.velocity_mps)
        assign(other.way_point_m, contact.way_point_m)
        if config.track == ORACLE:
            reveal(own, other, agent, world.aircraft[i, 1 + k], link, gamma)


@inner(forceinline=True)
def reveal(own, other, agent, craft, link, gamma):
    """Track `oracle`: replace every estimate by the truth."""
    square = rate = 0.0
    for axis in range(3):
        own.position_m[axis] = agent.position_m[axis]
        own.velocity_mps[axis] = agent.velocity_mps[axis] + agent.gust_mps[axis]
        other.position_m[axis] = craft.position_m[axis]
        other.velocity_mps[axis] = craft.velocity_mps[axis] + craft.gust_mps[axis]
        other.way_point_m[axis] = craft.path_m[craft.leg + 1, axis]
        step_m = craft.position_m[axis] - agent.position_m[axis]
        square += step_m * step_m
        rate += step_m * (other.velocity_mps[axis] - own.velocity_mps[axis])
    other.range_m, other.range_std_m = sqrt(square), 0.0
    other.range_rate_mps = rate / max(other.range_m, 1e-9)
    other.coloured_db, other.path_loss_factor = link.coloured_db, gamma + departure(link, own.time_s)
    other.warning = other.range_m <= other.radius_m
    other.streak = 1.0 if other.warning else 0.0
    other.valid, other.age_s = True, 0.0
