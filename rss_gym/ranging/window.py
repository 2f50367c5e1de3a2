"""Least squares on a window: the RSS of the last seconds averaged, then inverted. The paper's "historical data"."""

import numpy as np

from rss_gym.jit import kernel
from rss_gym.physics.noise import decay
from rss_gym.ranging import inverse

invert = inverse.invert


@kernel
def run(time_s, rss_dbm, rate_mps, setting, out):
    """At each sample the mean of the received RSS of the last `window_s`; without any, the last range is held.

    The variance of the mean is exact for white and Gauss-Markov noise: R / m + S / m^2 sum_ij e^{-|t_i - t_j| / Tc}.
    It leaves out that the range changes within the window.
    """
    length = rss_dbm.shape[1]
    heard = np.empty(length, np.int64)  # numbers of the received samples
    fade = np.empty(length)  # e^{-(t_i - t_(i-1)) / Tc} between received samples
    for i in range(rss_dbm.shape[0]):
        t, rss = time_s[min(i, len(time_s) - 1)], rss_dbm[i]
        d, p_dd, first, end = np.nan, np.nan, 0, 0
        for n in range(length):
            if not np.isnan(rss[n]):
                heard[end] = n
                fade[end] = decay(t[n] - t[heard[end - 1]], setting.coloured_tc_s) if end > 0 else 0.0
                end += 1
            while first < end and t[heard[first]] <= t[n] - setting.window_s:
                first += 1
            count = end - first
            if count > 0:
                total, pairs, reach = 0.0, 0.0, 0.0
                for k in range(first, end):
                    reach = fade[k] * (reach + 1.0) if k > first else 0.0  # correlations with the samples before
                    total, pairs = total + rss[heard[k]], pairs + 1.0 + 2.0 * reach
                variance = setting.white_variance_db2 / count + setting.coloured_variance_db2 * pairs / (count * count)
                d, p_dd = invert(
                    total / count, setting.offset_dbm, setting.path_loss_factor, variance,
                    setting.range_floor_m, setting.range_ceiling_m,
                )  # fmt: skip
            out.range_m[i, n], out.covariance[i, n, 0] = d, p_dd
