"""A Kalman filter over what messages tell, both velocities, and the filter's range.

State, in the horizontal plane: relative position p, error b of the measured relative velocity v, and error e of the
message's position, which both sides' fixes give it and which lasts for seconds:

    p(n+1) = p(n) + T (v - b(n)),    b(n+1) = a_b b(n) + w_b,    e(n+1) = a_e e(n) + w_e.

A new message measures u_j + age v_j - u_i = p + e. The range measures |p|. Its own error also lasts, so its variance is
multiplied by how often the same error comes back, 1 + 2 k T_d / T, and a bearing that is hardly known makes it a poor
measure of the way along the bearing: given the range, the bearing is von Mises distributed about that of p with
concentration 1 / q, q = P_across / (d |p|), so the way along has the mean d exp(-q / 2) and the variance
d^2 (1 - exp(-q))^2 / 2. The update of the state takes the variance alone, what is published takes both.

What is published is the state given the range of now once more, with its variance as it is; the state does not keep it.

The height is that of the messages: its error hardly changes in a flight, so there is nothing to filter.
"""

from math import sqrt

from rss_gym.jit import kernel
from rss_gym.physics.elementary import exp, log
from rss_gym.physics.path_loss import slope_db_pm
from rss_gym.tracking.latest import vertical_m2
from rss_gym.tracking.record import AGE, COVARIANCE, HEIGHT, OPEN, STATE, STATED, VELOCITY

SIZE = 6
PX, PY, BX, BY, EX, EY = range(SIZE)
WHITE_SHARE = 0.05  # of the message's variance: the part of its error that is new at every decision
FLIGHT_M2 = 0.01  # gusts and turns within a decision, per axis
TURN_MPS = 0.3  # by which a velocity has changed since a message of some age was sent
NEAREST_M = 0.5  # a range or a position below this has no bearing
LONGEST_S = 1e4


@kernel(forceinline=True)
def filter_time_s(variance_m2, distance_m, other, tick_s):
    """Correlation time of the error of a filter that states a variance of a distance.

    Noise of the low-frequency density N = 2 S Tc + R Delta (dB^2 s) on a signal of slope h (dB/m) is averaged over the
    time T = N / (h^2 P) until the variance is P.
    """
    s, r = other.coloured_std_db, other.white_std_db
    density = 2.0 * s * s * other.coloured_tc_s + r * r * tick_s
    h = slope_db_pm(other.path_loss_factor, distance_m)
    return min(density / (h * h * variance_m2 + 1e-12), LONGEST_S)


@kernel(forceinline=True)
def error_of(stated_m2, distance_m, log_distance, share, other, model):
    """Variance of a distance that a filter states to be `stated_m2`, and the correlation time of its error.

    Two things are added to what the filter says: the wander of the path loss factor, which it takes as fixed and which
    moves ln d by ln d sigma_gamma / gamma, and what its linearisation leaves out, which grows with the relative error.
    """
    moved = distance_m * log_distance * model.wander / other.path_loss_factor
    wander_m2 = moved * moved
    variance = stated_m2 + wander_m2 + 1e-6
    lasts_s = filter_time_s(stated_m2, distance_m, other, model.tick_s) + 2.0 * other.coloured_tc_s
    lasts_s = (stated_m2 * lasts_s + wander_m2 * model.wander_tc_s) / variance
    return variance * (1.0 + share * variance / (distance_m * distance_m)), lasts_s


@kernel(forceinline=True)
def message_error(own, other, model):
    """Variance of the message's position relative to the own solution, per axis, and its correlation time."""
    mine, theirs = own.std_m * own.std_m, other.std_m * other.std_m
    own_s, other_s = model.own_tc_s, model.other_tc_s
    if own_s == 0.0:
        mine, own_s = error_of(mine, model.node_m, model.node_log, model.message_share, other, model)
    if other_s == 0.0:
        theirs, other_s = error_of(theirs, model.node_m, model.node_log, model.message_share, other, model)
    variance = mine + theirs + 1e-6
    return variance, (mine * own_s + theirs * other_s) / variance + 1e-3


@kernel(forceinline=True)
def at(i, j):
    """Column of element (i, j) of the covariance P in the memory."""
    return COVARIANCE + SIZE * i + j


@kernel(forceinline=True)
def open_filter(m, x, y, variance_m2, model):
    """Open the memory `m` with the first message: the position (x, y), m, has the message's error."""
    for i in range(SIZE):
        m[STATE + i] = 0.0
        for j in range(SIZE):
            m[at(i, j)] = 0.0
    m[STATE + PX], m[STATE + PY] = x, y
    for axis in range(2):
        p, b, e = PX + axis, BX + axis, EX + axis
        m[at(p, p)], m[at(e, e)] = variance_m2 * (1.0 + WHITE_SHARE) + FLIGHT_M2, variance_m2
        m[at(p, e)] = m[at(e, p)] = -variance_m2
        m[at(b, b)] = model.velocity_variance_m2ps2


@kernel(forceinline=True)
def predict(m, dx, dy, period_s, a_b, a_e, noise_p, noise_b, noise_e):
    """One step: F P F^T + Q; `dx`, `dy` (m) by the measured velocities, noises in m^2 and m^2/s^2."""
    m[STATE + PX] += dx - period_s * m[STATE + BX]
    m[STATE + PY] += dy - period_s * m[STATE + BY]
    for axis in range(2):
        m[STATE + BX + axis] *= a_b
        m[STATE + EX + axis] *= a_e
    for j in range(SIZE):
        m[at(PX, j)] -= period_s * m[at(BX, j)]
        m[at(PY, j)] -= period_s * m[at(BY, j)]
    for i in range(SIZE):
        m[at(i, PX)] -= period_s * m[at(i, BX)]
        m[at(i, PY)] -= period_s * m[at(i, BY)]
    for i in range(SIZE):
        left = 1.0 if i < BX else (a_b if i < EX else a_e)
        for j in range(SIZE):
            right = 1.0 if j < BX else (a_b if j < EX else a_e)
            m[at(i, j)] *= left * right
    for axis in range(2):
        m[at(PX + axis, PX + axis)] += noise_p
        m[at(BX + axis, BX + axis)] += noise_b
        m[at(EX + axis, EX + axis)] += noise_e


@kernel(forceinline=True)
def correct(m, g0, g1, g2, g3, g4, g5, innovation, variance):
    """Add g nu / s to the state and take g g^T / s from P, with g = P h and s = h^T P h + r."""
    g, w = (g0, g1, g2, g3, g4, g5), 1.0 / variance
    for i in range(SIZE):
        m[STATE + i] += g[i] * w * innovation
        for j in range(SIZE):
            m[at(i, j)] -= g[i] * g[j] * w


@kernel(forceinline=True)
def update_by_message(m, axis, z, r):
    """Update by coordinate `axis` of a message, z = p + e (m), with variance r (m^2)."""
    p, e = PX + axis, EX + axis
    variance = m[at(p, p)] + 2.0 * m[at(p, e)] + m[at(e, e)] + r
    innovation = z - (m[STATE + p] + m[STATE + e])
    correct(
        m,
        m[at(0, p)] + m[at(0, e)], m[at(1, p)] + m[at(1, e)], m[at(2, p)] + m[at(2, e)],
        m[at(3, p)] + m[at(3, e)], m[at(4, p)] + m[at(4, e)], m[at(5, p)] + m[at(5, e)],
        innovation, variance,
    )  # fmt: skip


@kernel(forceinline=True)
def bearing_of(x, y):
    """Distance of (x, y), m, not below its floor, and unit vector."""
    d = sqrt(x * x + y * y)
    if d == 0.0:
        return NEAREST_M, 1.0, 0.0
    return max(d, NEAREST_M), x / d, y / d


@kernel(forceinline=True)
def along(range_m, distance_m, across_m2):
    """What a range says of the way along the bearing: its mean and the variance that the bearing's error gives it."""
    spread = exp(-0.5 * across_m2 / (range_m * distance_m))
    lost = 1.0 - spread * spread
    return range_m * spread, 0.5 * range_m * range_m * lost * lost, spread


@kernel(forceinline=True)
def update_by_range(m, range_m, variance_m2, repeat):
    """Update by the range (m), a measure of the way along the bearing, with `repeat` times its variance (m^2)."""
    d, nx, ny = bearing_of(m[STATE + PX], m[STATE + PY])
    xx, xy, yy = m[at(PX, PX)], m[at(PX, PY)], m[at(PY, PY)]
    _, bent, _ = along(range_m, d, xx * ny * ny - 2.0 * xy * nx * ny + yy * nx * nx)
    variance = xx * nx * nx + 2.0 * xy * nx * ny + yy * ny * ny + repeat * (variance_m2 + bent)
    correct(
        m,
        nx * m[at(0, 0)] + ny * m[at(0, 1)], nx * m[at(1, 0)] + ny * m[at(1, 1)],
        nx * m[at(2, 0)] + ny * m[at(2, 1)], nx * m[at(3, 0)] + ny * m[at(3, 1)],
        nx * m[at(4, 0)] + ny * m[at(4, 1)], nx * m[at(5, 0)] + ny * m[at(5, 1)],
        range_m - (nx * m[STATE + PX] + ny * m[STATE + PY]), variance,
    )  # fmt: skip


@kernel(forceinline=True)
def given_range(x, y, xx, xy, yy, range_m, variance_m2):
    """Position (m) and covariance (m^2) given the present range; its ring also bounds the way across."""
    d, nx, ny = bearing_of(x, y)
    # Covariance along and across the bearing.
    aa = xx * nx * nx + 2.0 * xy * nx * ny + yy * ny * ny
    ac = (yy - xx) * nx * ny + xy * (nx * nx - ny * ny)
    cc = xx * ny * ny - 2.0 * xy * nx * ny + yy * nx * nx
    z, bent, spread = along(range_m, d, cc)
    s = aa + variance_m2 + bent
    step = (z - (nx * x + ny * y)) / s
    x, y = x + (aa * nx - ac * ny) * step, y + (aa * ny + ac * nx) * step
    left = 1.0 - aa / s
    aa, ac, cc = aa * left, ac * left, cc - ac * ac / s
    most = 0.5 * range_m * range_m * (1.0 - spread * spread * spread * spread) + variance_m2
    if cc > most:
        ac, cc = ac * sqrt(most / cc), most
    xx = aa * nx * nx - 2.0 * ac * nx * ny + cc * ny * ny
    yy = aa * ny * ny + 2.0 * ac * nx * ny + cc * nx * nx
    return x, y, xx, (aa - cc) * nx * ny + ac * (nx * nx - ny * ny), yy


@kernel(forceinline=True)
def use_range(m, other, track, model):
    """Correct the state by the horizontal part of the range, whose error lasts, and write the position given it."""
    t = model.decision_s
    d, h = other.range_m, m[HEIGHT]
    variance, lasts_s = error_of(
        other.range_std_m * other.range_std_m, d, log(max(d, 1.0)), model.range_share, other, model
    )
    level = sqrt(max(d * d - h * h, NEAREST_M * NEAREST_M))
    variance = (d * d * variance + h * h * m[HEIGHT + 1]) / (level * level)
    update_by_range(m, level, variance, 1.0 + 2.0 * model.range_repeat * lasts_s / t)
    track.position_m[0], track.position_m[1], track.xx, track.xy, track.yy = given_range(
        m[STATE + PX], m[STATE + PY], m[at(PX, PX)], m[at(PX, PY)], m[at(PY, PY)], level, variance
    )


@kernel
def advance(own, other, memory, track, model):
    """Advance the filter of one intruder by a decision and write its track. Arguments: see `tracking.Advance`."""
    m, t = memory, model.decision_s
    track.valid = other.valid
    if not other.valid:
        m[OPEN] = 0.0
        return
    age, v = other.age_s, other.velocity_mps
    vx, vy, vz = v[0] - own.velocity_mps[0], v[1] - own.velocity_mps[1], v[2] - own.velocity_mps[2]
    stated, mine = other.position_m, own.position_m
    x, y, z = stated[0] + age * v[0] - mine[0], stated[1] + age * v[1] - mine[1], stated[2] + age * v[2] - mine[2]
    stated_m2, message_s = message_error(own, other, model)
    vertical = vertical_m2(own, other, model)
    turned_m2 = (TURN_MPS * age) * (TURN_MPS * age)
    if m[OPEN] == 0.0:
        open_filter(m, x, y, stated_m2, model)
        m[at(PX, PX)] += turned_m2
        m[at(PY, PY)] += turned_m2
        m[OPEN], m[HEIGHT], m[HEIGHT + 1] = 1.0, z, vertical
    else:
        is_new = age < m[AGE] + t - 1e-6  # a message that is only held grows older by a decision
        unheard_m2 = 0.0 if is_new else model.unheard_m2ps * t
        a_b, a_e = model.velocity_decay, exp(-t / message_s)
        predict(
            m, 0.5 * t * (m[VELOCITY] + vx), 0.5 * t * (m[VELOCITY + 1] + vy), t, a_b, a_e,
            FLIGHT_M2 + unheard_m2,
            model.velocity_variance_m2ps2 * (1.0 - a_b * a_b),
            stated_m2 * (1.0 - a_e * a_e) + a_e * a_e * max(stated_m2 - m[STATED], 0.0),
        )  # fmt: skip
        if is_new:
            r = WHITE_SHARE * stated_m2 + FLIGHT_M2 + turned_m2
            update_by_message(m, 0, x, r)
            update_by_message(m, 1, y, r)
            m[HEIGHT], m[HEIGHT + 1] = z, vertical
        else:
            m[HEIGHT] += 0.5 * t * (m[VELOCITY + 2] + vz)
            m[HEIGHT + 1] += 0.0 if model.planar else unheard_m2
    m[AGE], m[STATED] = age, stated_m2
    m[VELOCITY], m[VELOCITY + 1], m[VELOCITY + 2] = vx, vy, vz
    if model.uses_range:
        use_range(m, other, track, model)
    else:
        track.position_m[0], track.position_m[1] = m[STATE + PX], m[STATE + PY]
        track.xx, track.xy, track.yy = m[at(PX, PX)], m[at(PX, PY)], m[at(PY, PY)]
    track.position_m[2], track.zz = m[HEIGHT], m[HEIGHT + 1]
    track.velocity_mps[0], track.velocity_mps[1] = vx - m[STATE + BX], vy - m[STATE + BY]
    track.velocity_mps[2] = vz
    track.side_probability = 1.0
    track.other_m[0], track.other_m[1] = track.position_m[0], track.position_m[1]
