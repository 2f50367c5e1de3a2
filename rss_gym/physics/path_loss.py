"""The log-distance path loss, (2)-(3), with one sign throughout: RSS falls with distance."""

from math import floor

from rss_gym.jit import kernel
from rss_gym.physics.elementary import exp, log10

LN10 = 2.302585092994046


@kernel(inline="always")
def received_dbm(offset_dbm, path_loss_factor, distance_squared_m2):
    """(2) without noise, at d_0 = 1 m: offset - 10 gamma log10 d. Takes d^2, which saves the root."""
    return offset_dbm - 5.0 * path_loss_factor * log10(distance_squared_m2)


@kernel(inline="always")
def slope_db_pm(path_loss_factor, distance_m):
    """Derivative of (3) with respect to d: -10 gamma / (d ln 10), in dB per metre."""
    return -10.0 * path_loss_factor / (distance_m * LN10)


@kernel(inline="always")
def distance_m(offset_dbm, path_loss_factor, rss_dbm):
    """(2) solved for the distance: 10^((offset - RSS) / (10 gamma))."""
    return exp(LN10 * (offset_dbm - rss_dbm) / (10.0 * path_loss_factor))


@kernel(inline="always")
def quantise(rss_dbm, step_db):
    """RSS as a receiver reports it, rounded to a multiple of `step_db`; 0 leaves it as it is."""
    if step_db == 0.0:
        return rss_dbm
    return floor(rss_dbm / step_db + 0.5) * step_db
