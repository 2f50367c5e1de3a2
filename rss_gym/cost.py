"""The cost of an encounter, in metres, and the reward, which is minus the cost.

    cost = deviation_price * mean deviation over the flight + snmac_price_m if there was an sNMAC
           + collision_price_m if there was a collision (+ proximity_price_m * mean squared closeness, in training)

A step's reward is the cost before it minus the cost after it, so the undiscounted return is minus the cost however
the episode ends. While the flight lasts the means are over its whole length; a collision ends it, and from then on they
are over the part that was flown.
"""

from math import isfinite, sqrt

import numpy as np

from rss_gym.jit import inner
from rss_gym.physics.geometry import least_square_separation


@inner(forceinline=True)
def finish_step(state, i, flown_ticks):
    """End the step of row i, of which `flown_ticks` were flown: its costs (m) and flags. Returns the reward (m)."""
    config, e = state.config[0], state.episode[i]
    e.deviation_sum_m += e.deviation_m
    e.deviation_m /= flown_ticks
    e.terminated, e.truncated = e.collision, e.tick >= e.ticks and not e.collision
    e.deviation_mean_m, e.zone_severity = e.deviation_sum_m / e.tick, e.severity_sum / e.tick
    ticks = e.tick if e.collision else e.ticks
    deviation_m = config.deviation_price * e.deviation_sum_m / ticks
    proximity_m = config.proximity_price_m * e.proximity_sum / ticks
    snmac_m = config.snmac_price_m if e.snmac else 0.0
    collision_m = config.collision_price_m if e.collision else 0.0
    e.reward_deviation, e.cost_deviation_m = e.cost_deviation_m - deviation_m, deviation_m
    e.reward_proximity, e.cost_proximity_m = e.cost_proximity_m - proximity_m, proximity_m
    e.reward_snmac, e.cost_snmac_m = e.cost_snmac_m - snmac_m, snmac_m
    e.reward_collision = -collision_m  # a flight ends with it
    e.cost_m = deviation_m + proximity_m + snmac_m + collision_m
    before_m, e.potential_m = e.potential_m, 0.0 if e.terminated else potential_m(state, i)
    e.reward_shaping = config.shaping_discount * e.potential_m - before_m
    return e.reward_deviation + e.reward_snmac + e.reward_collision + e.reward_proximity + e.reward_shaping


@inner(forceinline=True)
def potential_m(state, i):
    """-`shaping_m` max(0, 1 - d / `comfort_m`)^2, d the least separation that straight flight leads to."""
    config, e = state.config[0], state.episode[i]
    if config.shaping_m == 0.0:
        return 0.0
    agent, square = state.aircraft[i, 0], np.inf
    for k in range(e.intruders):
        intruder = state.aircraft[i, 1 + k]
        u, v, own_u, own_v = intruder.position_m, intruder.velocity_mps, agent.position_m, agent.velocity_mps
        least = least_square_separation(
            u[0] - own_u[0], u[1] - own_u[1], u[2] - own_u[2], v[0] - own_v[0], v[1] - own_v[1], v[2] - own_v[2], 60.0
        )
        square = min(square, least)
    closeness = max(0.0, 1.0 - sqrt(square) / config.comfort_m)
    return -config.shaping_m * closeness * closeness


@inner(forceinline=True)
def is_finite(state, i):
    """Whether the state of row i is finite: where everybody is, thinks to be, and thinks the others are."""
    e, total = state.episode[i], 0.0
    for a in range(1 + e.intruders):
        aircraft = state.aircraft[i, a]
        for axis in range(3):
            total += aircraft.position_m[axis] + aircraft.velocity_mps[axis] + aircraft.solution_m[axis]
        total += aircraft.solution_std_m
    for k in range(e.intruders):
        track = state.tracks[i, k]
        total += state.links[i, k].range_m + state.links[i, k].p_dd
        if track.valid:
            for axis in range(3):
                total += track.position_m[axis] + track.velocity_mps[axis]
            total += track.xx + track.xy + track.yy + track.zz
    return isfinite(total + e.cost_m)
