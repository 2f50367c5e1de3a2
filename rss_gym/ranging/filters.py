"""The world's estimators over records: the coloured filter, the white one and least squares on each sample."""

import numpy as np

from rss_gym.jit import inner, kernel
from rss_gym.physics.path_loss import received_dbm, slope_db_pm
from rss_gym.ranging import coloured, inverse, white
from rss_gym.ranging.batch import filter_records

# Numba inlines a kernel that a variable of this module names, not an attribute of another module.
coloured_start, coloured_predict, coloured_update = coloured.start, coloured.predict, coloured.update
white_predict, white_update = white.predict, white.update
invert = inverse.invert


@inner
def bounded(d, setting):
    """The range within its floor, as in the world, and its ceiling, beyond which no filter can find back."""
    return min(max(d, setting.range_floor_m), setting.range_ceiling_m)


@inner
def range_prior(setting):
    """diag(range prior, S), or nothing known where the literal start reads the first sample."""
    if setting.literal:
        return np.nan, np.nan, np.nan, np.nan, np.nan
    return setting.prior_range_m, 0.0, setting.prior_std_m * setting.prior_std_m, 0.0, setting.coloured_variance_db2


@inner
def white_prior(setting):
    """The range prior alone."""
    d, _, p_dd, _, _ = range_prior(setting)
    return d, 0.0, p_dd, 0.0, 0.0


@inner
def literal(rss_dbm, setting):
    """d(0): the first sample inverted. The paper writes d(0) = d_0, which elsewhere is 1 m: a start at the antenna."""
    d, _ = invert(
        rss_dbm, setting.offset_dbm, setting.path_loss_factor, 0.0, setting.range_floor_m, setting.range_ceiling_m
    )
    return d


@inner
def start_coloured(state, rss_dbm, setting):
    """`coloured.start`, the range bounded; literally d(0) of the first sample, phi(0) = 0 and P(0) = I."""
    if setting.literal:
        return literal(rss_dbm, setting), 0.0, 1.0, 0.0, 1.0
    d, phi, p_dd, p_dp, p_pp = coloured_start(
        setting.prior_range_m, setting.prior_std_m, state[4], rss_dbm,
        setting.offset_dbm, setting.path_loss_factor, setting.white_variance_db2,
    )  # fmt: skip
    return bounded(d, setting), phi, p_dd, p_dp, p_pp


@inner
def start_white(state, rss_dbm, setting):
    """The same without coloured noise, as in the world; literally P(0) = 1."""
    d, phi, p_dd, p_dp, _ = start_coloured(state, rss_dbm, setting)
    return d, phi, p_dd, p_dp, 0.0


@inner
def predict_coloured(state, psi_m, process_noise_m2, a, sigma_w2, setting):
    """`coloured.predict`, the range bounded."""
    d, phi, p_dd, p_dp, p_pp = state
    d, phi, p_dd, p_dp, p_pp = coloured_predict(d, phi, p_dd, p_dp, p_pp, psi_m, process_noise_m2, a, sigma_w2)
    return bounded(d, setting), phi, p_dd, p_dp, p_pp


@inner
def predict_white(state, psi_m, process_noise_m2, a, sigma_w2, setting):
    """`white.predict`, the range bounded."""
    d, p_dd = white_predict(state[0], state[2], psi_m, process_noise_m2)
    return bounded(d, setting), 0.0, p_dd, 0.0, 0.0


@inner
def update_coloured(state, rss_dbm, setting):
    """`coloured.update` of `state` (d, phi, p_dd, p_dp, p_pp) by one sample (dBm)."""
    d, phi, p_dd, p_dp, p_pp = state
    d, phi, p_dd, p_dp, p_pp = coloured_update(
        d, phi, p_dd, p_dp, p_pp, rss_dbm,
        setting.offset_dbm, setting.path_loss_factor, setting.white_variance_db2, setting.range_floor_m,
    )  # fmt: skip
    return bounded(d, setting), phi, p_dd, p_dp, p_pp


@inner
def update_white(state, rss_dbm, setting):
    """`white.update` of `state` (d, p_dd) by one sample (dBm)."""
    d, p_dd = white_update(
        state[0], state[2], rss_dbm,
        setting.offset_dbm, setting.path_loss_factor, setting.white_variance_db2, setting.range_floor_m,
    )  # fmt: skip
    return bounded(d, setting), 0.0, p_dd, 0.0, 0.0


@inner
def innovation(state, rss_dbm, setting):
    """The innovation of (20) and its variance, the bracket of (19)."""
    d, phi, p_dd, p_dp, p_pp = state
    h = slope_db_pm(setting.path_loss_factor, d)
    variance = h * (p_dd * h + p_dp) + (p_dp * h + p_pp) + setting.white_variance_db2
    return rss_dbm - (received_dbm(setting.offset_dbm, setting.path_loss_factor, d * d) + phi), variance


@inner
def itself(d):
    """The state is the range."""
    return d


@kernel
def run_coloured(time_s, rss_dbm, rate_mps, setting, out):
    """The augmented filter (12)-(21) over the rows of `rss_dbm` (k, n); arguments as in `batch.filter_records`."""
    filter_records(
        range_prior, start_coloured, predict_coloured, update_coloured, innovation, itself,
        time_s, rss_dbm, rate_mps, setting, out,
    )  # fmt: skip


@kernel
def run_white(time_s, rss_dbm, rate_mps, setting, out):
    """The filter that takes all noise as white, over the rows of `rss_dbm` (k, n)."""
    filter_records(
        white_prior, start_white, predict_white, update_white, innovation, itself,
        time_s, rss_dbm, rate_mps, setting, out,
    )  # fmt: skip


@kernel
def run_inverse(time_s, rss_dbm, rate_mps, setting, out):
    """Least squares on each sample alone; where one is missing, the last range is held."""
    for i in range(rss_dbm.shape[0]):
        d, p_dd = np.nan, np.nan
        for n in range(rss_dbm.shape[1]):
            if not np.isnan(rss_dbm[i, n]):
                d, p_dd = invert(
                    rss_dbm[i, n], setting.offset_dbm, setting.path_loss_factor, setting.white_variance_db2,
                    setting.range_floor_m, setting.range_ceiling_m,
                )  # fmt: skip
            out.range_m[i, n], out.covariance[i, n, 0] = d, p_dd
