"""A bank of hypotheses of the bearing over one link: opened, advanced by a decision, summed up by side.

A bank is a stretch of a tracker's memory, one column of `bearing` after the other, each of all hypotheses: so the loops
over hypotheses become vector instructions, which is why their number is fixed.
"""

from math import sqrt
from typing import Final

from rss_gym.jit import kernel
from rss_gym.physics.elementary import cos, exp, log10, sin
from rss_gym.physics.path_loss import slope_db_pm
from rss_gym.tracking import bearing

HYPOTHESES: Final = 24
W: Final = 0  # weight, at most 1
X, Y, PHI, XX, XY, XP, YY, YP, PP = (HYPOTHESES * column for column in range(1, 10))
SIZE: Final = 10 * HYPOTHESES
LEAST_WEIGHT: Final = 1e-17  # of the best: no hypothesis is given up for good
APART: Final = 2.0 * 3.141592653589793 / HYPOTHESES
# Standard deviation of a hypothesis across its bearing when it opens, in spacings: wider ones cannot follow the ring.
WIDTH: Final = 0.3

predict, update, open_covariance = bearing.predict, bearing.update, bearing.open_covariance
held_dbm, held_variance_db2 = bearing.held_dbm, bearing.held_variance_db2


@kernel(forceinline=True)
def radio(other, model):
    """Of the link at its present range: variance of phi (dB^2), its decay over a decision, and the variance of z.

    phi is the coloured noise and the wander of the path loss factor; the variance of z is what the link's filter has
    left of the white noise, and the height left out.
    """
    d, gamma, s = other.range_m, other.path_loss_factor, other.coloured_std_db * other.coloured_std_db
    wander = 10.0 * model.wander * log10(max(d, 1.0))
    a = exp(-model.tick_s / other.coloured_tc_s)
    rest = held_variance_db2(
        d, gamma, model.process_noise_m2, s * (1.0 - a * a), max(other.white_std_db * other.white_std_db, 1e-6)
    )
    vertical = slope_db_pm(gamma, d) * model.vertical_variance_m2 / (2.0 * d)
    decay = exp(-model.decision_s / other.coloured_tc_s)
    return s + wander * wander, decay, model.rest_inflation * rest + vertical * vertical


@kernel(forceinline=True)
def start(m, at, other, vx, vy, model):
    """Spread the link's filter over the bearings, weighted by the flux and the prior of the miss distance.

    In traffic of even density the share that enters the zone at a bearing is in proportion to its closing speed; `vx`,
    `vy` is the relative velocity (m/s) at the warning. The bank begins at column `at` of `m`.
    """
    d, variance = other.range_m, other.range_std_m * other.range_std_m
    s, _, rest = radio(other, model)
    p_dp, p_pp = open_covariance(d, variance, other.path_loss_factor, s, rest)
    speed = sqrt(vx * vx + vy * vy)
    ax, ay = (vx / speed, vy / speed) if speed > 0.0 else (1.0, 0.0)
    across = (WIDTH * d * APART) * (WIDTH * d * APART)
    more, best = variance - across, 0.0
    for k in range(HYPOTHESES):
        # Mirror images of each other in the relative velocity, and none on it.
        forth, right = cos((k + 0.5) * APART), sin((k + 0.5) * APART)
        nx, ny = forth * ax - right * ay, forth * ay + right * ax
        m[at + X + k], m[at + Y + k], m[at + PHI + k] = d * nx, d * ny, other.coloured_db
        m[at + XX + k], m[at + XY + k], m[at + YY + k] = (
            across + more * nx * nx,
            more * nx * ny,
            across + more * ny * ny,
        )
        m[at + XP + k], m[at + YP + k], m[at + PP + k] = p_dp * nx, p_dp * ny, p_pp
        closing, blur = -speed * forth, model.closing_std_mps
        miss = d * right * speed / (speed + blur) / model.miss_std_m
        m[at + k] = (closing + sqrt(closing * closing + blur * blur)) * exp(-0.5 * miss * miss)
        best = max(best, m[at + k])
    for k in range(HYPOTHESES):
        m[at + k] /= best


@kernel(forceinline=True)
def advance(m, at, dx, dy, spread_m2, other, model):
    """One decision: every hypothesis moved by the relative way flown (dx, dy), updated and weighted by z."""
    gamma, floor_m = other.path_loss_factor, model.floor_m
    s_db2, decay, rest_db2 = radio(other, model)
    z_db = held_dbm(other.range_m, other.coloured_db, gamma)
    for k in range(HYPOTHESES):
        c = m[at + X + k], m[at + Y + k], m[at + PHI + k]
        p = m[at + XX + k], m[at + XY + k], m[at + XP + k], m[at + YY + k], m[at + YP + k], m[at + PP + k]
        c, p = predict(c, p, dx, dy, spread_m2, decay, s_db2)
        c, p, innovation, s = update(c, p, z_db, gamma, rest_db2, floor_m)
        m[at + X + k], m[at + Y + k], m[at + PHI + k] = c
        m[at + XX + k], m[at + XY + k], m[at + XP + k], m[at + YY + k], m[at + YP + k], m[at + PP + k] = p
        m[at + k] *= exp(max(-0.5 * innovation * innovation / s, -80.0)) / sqrt(s)
    best = 0.0
    for k in range(HYPOTHESES):
        best = max(best, m[at + k])
    for k in range(HYPOTHESES):
        m[at + k] = max(m[at + k] / best, LEAST_WEIGHT)


@kernel(forceinline=True)
def sides(m, at, vx, vy):
    """Moments of the hypotheses to the left and to the right of the relative velocity, for `summed`.

    Left is where y is positive if the velocity is along x. Each is the weight, not normalised, and the weighted sums of
    (x, y) and of its second moments (xx, xy, yy).
    """
    lw = lx = ly = lxx = lxy = lyy = 0.0
    rw = rx = ry = rxx = rxy = ryy = 0.0
    for k in range(HYPOTHESES):
        x, y, w = m[at + X + k], m[at + Y + k], m[at + k]
        left = w if vx * y - vy * x >= 0.0 else 0.0
        right = w - left
        xx, xy, yy = m[at + XX + k] + x * x, m[at + XY + k] + x * y, m[at + YY + k] + y * y
        lw, lx, ly, lxx, lxy, lyy = (
            lw + left, lx + left * x, ly + left * y, lxx + left * xx, lxy + left * xy, lyy + left * yy,
        )  # fmt: skip
        rw, rx, ry, rxx, rxy, ryy = (
            rw + right, rx + right * x, ry + right * y, rxx + right * xx, rxy + right * xy, ryy + right * yy,
        )  # fmt: skip
    return (lw, lx, ly, lxx, lxy, lyy), (rw, rx, ry, rxx, rxy, ryy)


@kernel(forceinline=True)
def summed(moments):
    """Mean (x, y) and covariance (xx, xy, yy) of one side; zero without weight."""
    w, x, y, xx, xy, yy = moments
    if w == 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    x, y = x / w, y / w
    return x, y, xx / w - x * x, xy / w - x * y, yy / w - y * y
