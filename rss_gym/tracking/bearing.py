"""Where the other is, from ranges and two velocities: a bank of the filter (12)-(21) taken to the plane, by bearing.

Each hypothesis is a Gaussian over [x, y, phi]: the relative position and the coloured noise, with which goes what the
path loss factor's wander does to the RSS. It is moved by the known relative velocity, in place of psi of (12), and
weighted by its likelihood. A straight relative flight leaves its mirror image as likely; only a change of the relative
velocity separates the two.

The measurement is what the link's filter holds of the RSS, z = phi_hat - 10 gamma log10 d_hat. The errors of d_hat are
correlated over seconds; those of z are the coloured noise, which the state carries with its variance and time, and a
rest that the filter all but forgets between two decisions.
"""

from math import sqrt

from rss_gym.jit import kernel
from rss_gym.physics.elementary import log, log10
from rss_gym.physics.path_loss import LN10, slope_db_pm


@kernel(inline="always")
def held_dbm(range_m, coloured_db, path_loss_factor):
    """RSS at no offset that the filter of the link holds after its update: phi_hat - 10 gamma log10 d_hat."""
    return coloured_db - 10.0 * path_loss_factor * log10(range_m)


@kernel(inline="always")
def held_variance_db2(range_m, path_loss_factor, process_noise_m2, drive_db2, white_variance_db2):
    """Variance of `held_dbm` about the RSS without white noise: the steady state of (16)-(21) in h itself.

    `drive_db2` is what the coloured noise adds to the variance in a tick.
    """
    slope = slope_db_pm(path_loss_factor, range_m)
    q = slope * slope * process_noise_m2 + drive_db2
    prior = 0.5 * (q + sqrt(q * q + 4.0 * q * white_variance_db2))
    return prior * white_variance_db2 / (prior + white_variance_db2)


@kernel(inline="always")
def open_covariance(range_m, range_variance_m2, path_loss_factor, coloured_variance_db2, variance_db2):
    """The link's filter says Var(d) only: the covariances p_dp and p_pp that go with it, (18)-(21) run backwards.

    Of all priors of the range, that is sought which one sample of z turns into the stated variance, the coloured noise
    being of variance S before; p_dp and p_pp are what the same sample makes of it.
    """
    slope = slope_db_pm(path_loss_factor, range_m)
    noise = coloured_variance_db2 + variance_db2
    prior = slope * slope * range_variance_m2 / max(1.0 - slope * slope * range_variance_m2 / noise, 1e-3)  # dB^2
    gain = coloured_variance_db2 / (prior + noise)
    return -gain * prior / slope, coloured_variance_db2 * (1.0 - gain)


@kernel(forceinline=True)
def predict(c, p, dx, dy, spread_m2, a, coloured_variance_db2):
    """(16)-(17) over a decision.

    Parameters
    ----------
    c : (x, y, phi)
        Relative position (m) and coloured noise (dB).
    p : tuple of 6 floats
        Upper triangle of their covariance, row by row.
    dx, dy : float
        Relative way flown, m.
    spread_m2 : float
        What its error adds to the variance of each axis.
    a : float
        Decay of the coloured noise over the decision.
    coloured_variance_db2 : float
        Its stationary variance.
    """
    x, y, phi = c
    xx, xy, xp, yy, yp, pp = p
    pp = a * a * pp + coloured_variance_db2 * (1.0 - a * a)
    return (x + dx, y + dy, a * phi), (xx + spread_m2, xy, a * xp, yy + spread_m2, a * yp, pp)


@kernel(forceinline=True)
def update(c, p, z_db, path_loss_factor, variance_db2, floor_m):
    """(18)-(21) to second order, which near the other keeps a wide Gaussian from being taken at its tangent.

    Returns
    -------
    c, p, innovation, s
        The innovation and its variance, of which the likelihood is exp(-innovation^2 / 2 s) / sqrt(s) but for a
        constant.
    """
    x, y, phi = c
    xx, xy, xp, yy, yp, pp = p
    square = max(x * x + y * y, floor_m * floor_m)
    h_d = -10.0 * path_loss_factor / LN10  # slope of (3) in ln d
    h_x, h_y = h_d * x / square, h_d * y / square
    # The Hessian is h_d / d^2 times diag(-1, 1) along and across the line of sight.
    radial = (x * x * xx + 2.0 * x * y * xy + y * y * yy) / square
    across = xx + yy - radial
    curve = h_d / square
    bend = 0.5 * curve * (across - radial)
    bend2 = 0.5 * curve * curve * ((across - radial) * (across - radial) + 2.0 * (xx * yy - xy * xy))
    g_x = xx * h_x + xy * h_y + xp
    g_y = xy * h_x + yy * h_y + yp
    g_p = xp * h_x + yp * h_y + pp
    s = h_x * g_x + h_y * g_y + g_p + bend2 + variance_db2
    innovation = z_db - (0.5 * h_d * log(square) + phi + bend)
    w = 1.0 / s
    step = innovation * w
    c = x + g_x * step, y + g_y * step, phi + g_p * step
    p = (
        xx - g_x * g_x * w, xy - g_x * g_y * w, xp - g_x * g_p * w,
        yy - g_y * g_y * w, yp - g_y * g_p * w,
        pp - g_p * g_p * w,
    )  # fmt: skip
    return c, p, innovation, s
