"""Motion of a block of rows through one tick; every loop runs over the lanes of the block."""

from math import sqrt

from rss_gym.encounters.sampler import leg_at, planned
from rss_gym.jit import inner
from rss_gym.physics.geometry import least_square_separation
from rss_gym.physics.motion import clip, limit, regulate


@inner(forceinline=True)
def update_plan(aircraft, time_s):
    """Write u^d, its velocity and the direction of the current leg at `time_s` of the aircraft's own clock."""
    aircraft.leg = leg_at(aircraft, aircraft.leg, time_s)
    x, y, z, vx, vy, vz = planned(aircraft, aircraft.leg, time_s)
    p, v, along = aircraft.planned_m, aircraft.planned_mps, aircraft.along
    p[0], p[1], p[2] = x, y, z
    v[0], v[1], v[2] = vx, vy, vz
    speed = sqrt(vx * vx + vy * vy)
    if speed > 0.0:  # a hovering aircraft keeps its axes
        along[0], along[1], along[2] = vx / speed, vy / speed, 0.0


@inner
def follow_plan(config, block, aircraft):
    """u^d on the leg being flown; an intruder's way point is just that, and stands still in a hover."""
    leg, p, v = aircraft.leg_m, aircraft.planned_m, aircraft.planned_mps
    w, wv = aircraft.way_point_m, aircraft.way_point_mps
    for axis in range(3):
        for r in range(block.rows):
            p[axis, r] = leg[axis, r] + v[axis, r] * (aircraft.clock_s[r] - aircraft.leg_s[r])
            hover = (block.tick[r] - 1.0) * config.tick_s < aircraft.hover_until_s[r]
            w[axis, r], wv[axis, r] = p[axis, r], (0.0 if hover else 1.0) * v[axis, r]


@inner
def command(config, block, agent):
    """u^d on the leg being flown; the way point moves at its velocity plus the commanded change of it."""
    t, band = config.tick_s, config.altitude_band_m
    speed_max, vertical_max = config.speed_max_mps, config.vertical_speed_max_mps
    leg, p, v, w, wv = agent.leg_m, agent.planned_m, agent.planned_mps, agent.way_point_m, agent.way_point_mps
    for r in range(block.rows):
        flown_s = agent.clock_s[r] - agent.leg_s[r]
        px, py, pz = leg[0, r] + v[0, r] * flown_s, leg[1, r] + v[1, r] * flown_s, leg[2, r] + v[2, r] * flown_s
        p[0, r], p[1, r], p[2, r] = px, py, pz
        # The axes of the leg: along = (ax, ay, 0), right = (ay, -ax, 0), up.
        ax, ay, forth, right = agent.along[0, r], agent.along[1, r], block.action[0, r], block.action[1, r]
        x, y, z = forth * ax + right * ay, forth * ay - right * ax, block.action[2, r]
        x, y, z = limit(
            v[0, r] + speed_max * x, v[1, r] + speed_max * y, v[2, r] + vertical_max * z, speed_max, vertical_max
        )
        w[0, r], w[1, r] = w[0, r] + x * t, w[1, r] + y * t
        w[2, r] = clip(w[2, r] + z * t, pz - band, pz + band)
        wv[0, r], wv[1, r], wv[2, r] = x, y, z


@inner
def steer(config, block, aircraft):
    """One tick of the autopilot towards the way point, which moves at `way_point_mps`: velocities."""
    t, k1, k2 = config.tick_s, config.position_gain_ps2, config.velocity_gain_ps
    most, speed_max, vertical_max = config.acceleration_max_mps2, config.speed_max_mps, config.vertical_speed_max_mps
    u, v, w, wv = aircraft.position_m, aircraft.velocity_mps, aircraft.way_point_m, aircraft.way_point_mps
    gust, ground = aircraft.gust_mps, aircraft.ground_mps
    for r in range(block.rows):
        ax, ay, az = limit(
            regulate(w[0, r] - u[0, r], wv[0, r] - v[0, r], k1, k2),
            regulate(w[1, r] - u[1, r], wv[1, r] - v[1, r], k1, k2),
            regulate(w[2, r] - u[2, r], wv[2, r] - v[2, r], k1, k2),
            most,
            most,
        )
        vx, vy, vz = limit(v[0, r] + ax * t, v[1, r] + ay * t, v[2, r] + az * t, speed_max, vertical_max)
        v[0, r], v[1, r], v[2, r] = vx, vy, vz
        ground[0, r], ground[1, r], ground[2, r] = vx + gust[0, r], vy + gust[1, r], vz + gust[2, r]


@inner
def relative_motion(config, block, agent, intruder, contact):
    """True motion (m, m/s) of an intruder relative to the agent in the tick, and their least separation (m) in it."""
    t, u, v, own, own_v = config.tick_s, intruder.position_m, intruder.ground_mps, agent.position_m, agent.ground_mps
    for r in range(block.rows):
        x, y, z = u[0, r] - own[0, r], u[1, r] - own[1, r], u[2, r] - own[2, r]
        vx, vy, vz = v[0, r] - own_v[0, r], v[1, r] - own_v[1, r], v[2, r] - own_v[2, r]
        contact.relative_m[0, r], contact.relative_m[1, r], contact.relative_m[2, r] = x, y, z
        contact.relative_mps[0, r], contact.relative_mps[1, r], contact.relative_mps[2, r] = vx, vy, vz
        square = least_square_separation(x, y, z, vx, vy, vz, t)
        contact.least_squared_m2[r], contact.least_m[r] = square, sqrt(square)


@inner
def move(config, block, aircraft):
    """Fly for one tick at the velocity over ground."""
    for axis in range(3):
        for r in range(block.rows):
            aircraft.position_m[axis, r] += aircraft.ground_mps[axis, r] * config.tick_s


@inner
def measure_path(config, block, agent):
    """Add the tick to the length of the agents' paths and to their deviation |u - u^d|, m."""
    u, p, v = agent.position_m, agent.planned_m, agent.ground_mps
    for r in range(block.rows):
        speed = sqrt(v[0, r] * v[0, r] + v[1, r] * v[1, r] + v[2, r] * v[2, r])
        block.flown_m[r] += config.tick_s * speed
        x, y, z = u[0, r] - p[0, r], u[1, r] - p[1, r], u[2, r] - p[2, r]
        here_m = sqrt(x * x + y * y + z * z)
        block.deviation_m[r] += here_m
        block.deviation_max_m[r] = max(block.deviation_max_m[r], here_m)
