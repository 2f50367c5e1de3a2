"""A bank of hypotheses of the bearing over one link: opened, advanced by a decision, summed up by side.

A bank is an array (hypotheses, COLUMNS): log weight, [x, y, phi, beta] and the upper triangle of its covariance.
"""

from math import pi, sqrt

import numpy as np

from rss_gym.jit import kernel
from rss_gym.physics.elementary import cos, exp, log, sin
from rss_gym.physics.path_loss import slope_db_pm
from rss_gym.tracking import bearing

WEIGHT, X, Y, XX, XY, YY = 0, 1, 2, 5, 6, 9
COLUMNS = 15
LEAST_LOG_WEIGHT = -40.0  # below the best: no hypothesis is given up for good

predict, update, open_covariance = bearing.predict, bearing.update, bearing.open_covariance
held_dbm, held_variance_db2 = bearing.held_dbm, bearing.held_variance_db2

MODEL = np.dtype(
    [
        (name, np.float64)
        for name in (
            "path_loss_factor",
            "factor_decay",  # of its deviation, over a decision
            "factor_variance",
            "coloured_decay",  # over a decision
            "coloured_variance_db2",
            "drive_db2",  # what the coloured noise gains in a tick
            "white_variance_db2",
            "process_noise_m2",  # of the link's filter, in a tick
            "rest_inflation",  # of the variance of z that is not coloured noise
            "vertical_variance_m2",  # of the height between the two, which the plane leaves out
            "spread_m2",  # variance of the relative way flown in a decision, per axis, and without messages
            "spread_unheard_m2",
            "closing_std_mps",  # blurs from which bearings the other may have come
            "miss_std_m",  # prior of the distance at which the other passes
            "floor_m",
        )
    ]
)


@kernel
def variance_db2(range_m, model):
    """Variance of z but for the coloured noise: what is left of the white noise, and the height left out."""
    rest = held_variance_db2(
        range_m, model.path_loss_factor, model.process_noise_m2, model.drive_db2, model.white_variance_db2
    )
    vertical = slope_db_pm(model.path_loss_factor, range_m) * model.vertical_variance_m2 / (2.0 * range_m)
    return model.rest_inflation * rest + vertical * vertical


@kernel
def load(h):
    """State and covariance of one hypothesis."""
    return (h[1], h[2], h[3], h[4]), (h[5], h[6], h[7], h[8], h[9], h[10], h[11], h[12], h[13], h[14])


@kernel
def store(h, c, p):
    """Write state and covariance of one hypothesis."""
    h[1], h[2], h[3], h[4] = c
    h[5], h[6], h[7], h[8], h[9], h[10], h[11], h[12], h[13], h[14] = p


@kernel
def start(bank, range_m, range_std_m, coloured_db, vx, vy, model):
    """Spread the link's filter over the bearings, weighted by the flux and the prior of the miss distance.

    In traffic of even density the share that enters the zone at a bearing is in proportion to its closing speed; `vx`,
    `vy` is the relative velocity (m/s) at the warning.
    """
    d, variance = range_m, range_std_m * range_std_m
    s = model.coloured_variance_db2
    p_dp, p_pp = open_covariance(d, variance, model.path_loss_factor, s, variance_db2(d, model))
    speed = sqrt(vx * vx + vy * vy)
    ax, ay = (vx / speed, vy / speed) if speed > 0.0 else (1.0, 0.0)
    apart = 2.0 * pi / len(bank)
    across = (0.6 * d * apart) ** 2
    for k in range(len(bank)):
        # Mirror images of each other in the relative velocity, and none on it.
        forth, right = cos((k + 0.5) * apart), sin((k + 0.5) * apart)
        nx, ny = forth * ax - right * ay, forth * ay + right * ax
        c = d * nx, d * ny, coloured_db, 0.0
        more = variance - across
        xx, xy, yy = across + more * nx * nx, more * nx * ny, across + more * ny * ny
        p = xx, xy, p_dp * nx, 0.0, yy, p_dp * ny, 0.0, p_pp, 0.0, model.factor_variance
        store(bank[k], c, p)
        closing, blur = -speed * forth, model.closing_std_mps
        miss_m = d * right * speed / (speed + blur)
        bank[k, WEIGHT] = log(closing + sqrt(closing * closing + blur * blur)) - 0.5 * (miss_m / model.miss_std_m) ** 2


@kernel
def advance(bank, dx, dy, spread_m2, range_m, coloured_db, model):
    """One decision: every hypothesis moved by the relative way flown (dx, dy), updated and weighted by z."""
    best, gamma = -np.inf, model.path_loss_factor
    z_db, rest_db2 = held_dbm(range_m, coloured_db, gamma), variance_db2(range_m, model)
    for k in range(len(bank)):
        c, p = load(bank[k])
        c, p = predict(
            c, p, dx, dy, spread_m2,
            model.coloured_decay, model.coloured_variance_db2, model.factor_decay, model.factor_variance,
        )  # fmt: skip
        c, p, likelihood = update(c, p, z_db, gamma, rest_db2, model.floor_m)
        store(bank[k], c, p)
        bank[k, WEIGHT] += likelihood
        best = max(best, bank[k, WEIGHT])
    for k in range(len(bank)):
        bank[k, WEIGHT] = max(bank[k, WEIGHT] - best, LEAST_LOG_WEIGHT)


@kernel
def side(bank, vx, vy, sign):
    """Weight, mean (x, y) and covariance (xx, xy, yy) of the hypotheses on one side of the relative velocity.

    `sign` +1 takes those to the right of it (in axes whose y is to the right of x), -1 those to the left of it. The
    weight is not normalised; without weight the mean is zero.
    """
    w = x = y = xx = xy = yy = 0.0
    for k in range(len(bank)):
        h = bank[k]
        if sign * (vx * h[Y] - vy * h[X]) >= 0.0:  # on the line itself: to either side
            share = exp(h[WEIGHT])
            w += share
            x, y = x + share * h[X], y + share * h[Y]
            xx += share * (h[XX] + h[X] * h[X])
            xy += share * (h[XY] + h[X] * h[Y])
            yy += share * (h[YY] + h[Y] * h[Y])
    if w == 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    x, y = x / w, y / w
    return w, x, y, xx / w - x * x, xy / w - x * y, yy / w - y * y
