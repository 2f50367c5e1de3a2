"""Least squares on one sample: the path loss inverted, the paper's LS baseline."""

from rss_gym.jit import kernel
from rss_gym.physics.path_loss import distance_m, slope_db_pm


@kernel(inline="always")
def invert(rss_dbm, offset_dbm, path_loss_factor, noise_variance_db2, floor_m, ceiling_m):
    """Range (m) that explains one RSS, held within [floor_m, ceiling_m], and its first-order variance (m^2)."""
    d = min(max(distance_m(offset_dbm, path_loss_factor, rss_dbm), floor_m), ceiling_m)
    slope = slope_db_pm(path_loss_factor, d)
    return d, noise_variance_db2 / (slope * slope)
