"""The radio: one tick of a link in every row of a block, (2), (8) and the estimator of range.

Every loop runs over the lanes of the block; what it does to one lane are the scalar kernels of `physics` and `ranging`.
"""

from math import sqrt

import numpy as np

from rss_gym.jit import inner
from rss_gym.physics.noise import gauss_markov
from rss_gym.physics.path_loss import quantise, received_dbm
from rss_gym.physics.random import uniform
from rss_gym.ranging import COLOURED, LEAST_SQUARES, WHITE, WHITE_R, coloured, inverse, white
from rss_gym.streams import MAX_INTRUDERS, STREAM_LOSS

EKF_CEILING_M = 1e5  # a filter beyond it has diverged: the longest flight is shorter
LS_CEILING_M = 1000.0  # least squares inverts a deep fade to any distance; beyond this it says nothing

coloured_start, coloured_predict, coloured_update = coloured.start, coloured.predict, coloured.update
white_predict, white_update = white.predict, white.update
invert = inverse.invert


@inner(forceinline=True)
def control_input(config, x_m, y_m, z_m, vx_mps, vy_mps, vz_mps, bearing_std_m):
    """Control input psi of (12) and its Var(w) (m^2): from a relative position with its std and a relative velocity.

    psi (m) is the velocity (m/s) along the bearing times the tick. An error of the bearing by std / range turns some of
    the velocity across it into range; it persists, so its variance is inflated as a random walk must be to cover it.
    """
    d = sqrt(x_m * x_m + y_m * y_m + z_m * z_m) + 1e-9
    radial = (x_m * vx_mps + y_m * vy_mps + z_m * vz_mps) / d
    speed_squared = vx_mps * vx_mps + vy_mps * vy_mps + vz_mps * vz_mps
    angle = min(bearing_std_m / d, 1.0)
    across = max(speed_squared - radial * radial, 0.0) + speed_squared * angle * angle
    t = config.tick_s
    noise = config.process_noise_psi_m2 + config.bearing_inflation * across * angle * angle * t * t
    return radial * t, min(noise, config.process_noise_m2)


@inner
def link_geometry_intruder(config, block, agent, intruder, contact, link):
    """Squared true length (m^2) of the link agent-intruder; psi and Var(w) (m, m^2) while messages come."""
    u, v, p, stated = agent.position_m, intruder.position_m, agent.solution_m, contact.position_m
    own_v, stated_v = agent.solution_mps, contact.velocity_mps
    for r in range(block.rows):
        x, y, z = u[0, r] - v[0, r], u[1, r] - v[1, r], u[2, r] - v[2, r]
        link.distance_squared_m2[r] = x * x + y * y + z * z
        x, y, z = stated[0, r] - p[0, r], stated[1, r] - p[1, r], stated[2, r] - p[2, r]
        vx, vy, vz = stated_v[0, r] - own_v[0, r], stated_v[1, r] - own_v[1, r], stated_v[2, r] - own_v[2, r]
        variance = contact.std_m[r] * contact.std_m[r] + agent.solution_std_m[r] * agent.solution_std_m[r]
        psi, noise = control_input(config, x, y, z, vx, vy, vz, sqrt(variance))
        known = contact.known[r] > 0.0
        link.psi_m[r], link.process_noise_m2[r] = psi if known else 0.0, noise if known else config.process_noise_m2


@inner
def link_geometry_node(config, block, aircraft, node_m, link):
    """Squared true length (m^2) of an aircraft's link to a node (3,); psi and Var(w) (m, m^2) by its own solution."""
    nx, ny, nz = node_m[0], node_m[1], node_m[2]
    u, p, v = aircraft.position_m, aircraft.solution_m, aircraft.solution_mps
    for r in range(block.rows):
        x, y, z = u[0, r] - nx, u[1, r] - ny, u[2, r] - nz
        link.distance_squared_m2[r] = x * x + y * y + z * z
        x, y, z = p[0, r] - nx, p[1, r] - ny, p[2, r] - nz
        link.psi_m[r], link.process_noise_m2[r] = control_input(
            config, x, y, z, v[0, r], v[1, r], v[2, r], aircraft.solution_std_m[r]
        )


@inner
def transmit(block, link):
    """Coloured noise (8) in dB and the RSS (2) in dBm of a link, on every lane."""
    for r in range(block.rows):
        noise_db = gauss_markov(
            link.coloured_db[r], block.coloured_decay[r], block.coloured_drive_db[r], link.coloured_normal[r]
        )
        gamma = block.path_loss_factor[r] + link.wander[r]
        rss = received_dbm(block.offset_dbm[r], gamma, max(link.distance_squared_m2[r], 0.01))
        link.coloured_db[r] = noise_db
        link.rss_dbm[r] = rss + (noise_db + block.white_std_db[r] * link.white_normal[r])


@inner
def receive(config, channels, episode, contacts, block, links, used):
    """Quantise the RSS and lose packets, where a channel does that, and all in an outage; lost is minus infinity."""
    for n in range(len(used)):
        s = used[n]
        g = s if s < config.intruders else MAX_INTRUDERS + s - config.intruders
        for r in range(block.rows):
            e, rss = episode[block.row[r]], links[s].rss_dbm
            channel = channels[e.channel]
            rss[r] = quantise(rss[r], channel.quantisation_db)
            if channel.packet_loss > 0.0 and uniform(e.key, STREAM_LOSS + g, e.tick) < channel.packet_loss:
                rss[r] = -np.inf
            if s < config.intruders and in_outage(contacts[block.row[r], s], e.tick * config.tick_s):
                rss[r] = -np.inf


@inner(forceinline=True)
def in_outage(contact, time_s):
    """Whether the link to an intruder is in an outage."""
    return contact.silent_s <= time_s < contact.silent_until_s


@inner
def start_filter(config, block, link, to_node):
    """The estimator after the first sample: the prior of the range, updated where the measurement is linear."""
    prior_m, prior_std_m = config.prior_range_m, config.prior_std_m
    if to_node:
        prior_m, prior_std_m = config.node_prior_range_m, config.node_prior_std_m
    for r in range(block.rows):
        s = block.coloured_variance_db2[r] if config.estimator == COLOURED else 0.0
        rss, variance = link.rss_dbm[r], block.white_variance_db2[r] + block.coloured_variance_db2[r] - s
        if config.estimator == WHITE_R:
            variance = block.white_variance_db2[r]
        if rss < block.sensitivity_dbm[r]:
            rss, variance = 0.0, np.inf  # a sample that was not received has no weight: the prior stays
        link.range_m[r], link.coloured_hat_db[r], link.p_dd[r], link.p_dp[r], link.p_pp[r] = coloured_start(
            prior_m, prior_std_m, s, rss, block.offset_dbm[r], block.path_loss_factor[r], variance
        )


@inner
def estimate(config, block, link):
    """One tick of the estimator of range, and the smoothed rate of its range."""
    if config.estimator == COLOURED:
        estimate_coloured(config, block, link)
    elif config.estimator != LEAST_SQUARES:
        estimate_white(config, block, link)
    else:
        estimate_least_squares(config, block, link)


@inner
def estimate_coloured(config, block, link):
    """The augmented filter (12)-(21)."""
    floor_m, gain, t = config.range_floor_m, config.rate_gain, config.tick_s
    for r in range(block.rows):
        before_m, rss = link.range_m[r], link.rss_dbm[r]
        d, phi, p_dd, p_dp, p_pp = coloured_predict(
            before_m, link.coloured_hat_db[r], link.p_dd[r], link.p_dp[r], link.p_pp[r],
            link.psi_m[r], link.process_noise_m2[r], block.coloured_decay[r], block.coloured_drive_db[r],
        )  # fmt: skip
        d = max(d, floor_m)
        if rss >= block.sensitivity_dbm[r]:
            d, phi, p_dd, p_dp, p_pp = coloured_update(
                d, phi, p_dd, p_dp, p_pp, rss,
                block.offset_dbm[r], block.path_loss_factor[r], block.white_variance_db2[r], floor_m,
            )  # fmt: skip
        d = min(d, EKF_CEILING_M)
        link.range_m[r], link.coloured_hat_db[r] = d, phi
        link.p_dd[r], link.p_dp[r], link.p_pp[r] = p_dd, p_dp, p_pp
        link.rate_mps[r] += gain * ((d - before_m) / t - link.rate_mps[r])


@inner
def estimate_white(config, block, link):
    """The filter that takes all noise as white, or with R alone holds that there is no other."""
    share = 1.0 if config.estimator == WHITE else 0.0  # of the coloured noise's variance
    floor_m, gain, t = config.range_floor_m, config.rate_gain, config.tick_s
    for r in range(block.rows):
        before_m, rss = link.range_m[r], link.rss_dbm[r]
        d, p_dd = white_predict(before_m, link.p_dd[r], link.psi_m[r], link.process_noise_m2[r])
        d = max(d, floor_m)
        if rss >= block.sensitivity_dbm[r]:
            total = block.white_variance_db2[r] + share * block.coloured_variance_db2[r]
            d, p_dd = white_update(d, p_dd, rss, block.offset_dbm[r], block.path_loss_factor[r], total, floor_m)
        d = min(d, EKF_CEILING_M)
        link.range_m[r], link.p_dd[r] = d, p_dd
        link.rate_mps[r] += gain * ((d - before_m) / t - link.rate_mps[r])


@inner
def estimate_least_squares(config, block, link):
    """Least squares on each sample alone."""
    floor_m, gain, t = config.range_floor_m, config.rate_gain, config.tick_s
    for r in range(block.rows):
        before_m, rss = link.range_m[r], link.rss_dbm[r]
        if rss >= block.sensitivity_dbm[r]:
            total = block.white_variance_db2[r] + block.coloured_variance_db2[r]
            link.range_m[r], link.p_dd[r] = invert(
                rss, block.offset_dbm[r], block.path_loss_factor[r], total, floor_m, LS_CEILING_M
            )
        link.rate_mps[r] += gain * ((link.range_m[r] - before_m) / t - link.rate_mps[r])
