"""The extended Kalman filter that takes all noise as white: (12)-(21) without the state phi."""

from rss_gym.jit import kernel
from rss_gym.physics.path_loss import received_dbm, slope_db_pm


@kernel(inline="always")
def predict(d, p_dd, psi_m, process_noise_m2):
    """(16)-(17) of the range alone; arguments as in `coloured.predict`."""
    return d + psi_m, p_dd + process_noise_m2


@kernel(inline="always")
def update(d, p_dd, rss_dbm, offset_dbm, path_loss_factor, noise_variance_db2, floor_m):
    """(18)-(21) of the range alone, Joseph form; `noise_variance_db2` is the whole variance (R + S)."""
    h = slope_db_pm(path_loss_factor, d)
    gain = p_dd * h / (h * p_dd * h + noise_variance_db2)
    d = d + gain * (rss_dbm - received_dbm(offset_dbm, path_loss_factor, d * d))
    keep = 1.0 - gain * h
    return max(d, floor_m), keep * p_dd * keep + gain * noise_variance_db2 * gain
