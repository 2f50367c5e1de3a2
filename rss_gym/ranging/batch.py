"""One loop runs every filter of range over a batch of records; a filter is the functions that it is given.

A state is the tuple (x, phi, p_xx, p_xp, p_pp): x is the range in m or its logarithm, phi the coloured noise in dB (0
in a filter without it), then their covariance. Samples may be irregular, missing, or absent at the start.
"""

from typing import NamedTuple

import numpy as np

from rss_gym.jit import kernel
from rss_gym.physics.noise import decay, driving_std

# Regular times differ by their rounding: intervals this much alike (relative) share e^{lambda Delta} and sigma_w2.
SAME_INTERVAL = 1e-9
# After a gap of hundreds of Tc nothing is left of phi; a decay of 0 would make the driving noise infinite.
DECAY_MIN = 1e-100


class Setting(NamedTuple):
    """What the loop and the filters read; `track.track` fills it from a channel and a tuning."""

    offset_dbm: float
    path_loss_factor: float
    white_variance_db2: float  # R of the filter: R + S for an estimator that takes all noise as white
    coloured_variance_db2: float
    coloured_tc_s: float
    process_noise_ps: float  # Var(w) per second, in the square of the state's unit
    process_noise_rate_ps: float  # the same where the range rate is known
    prior_range_m: float
    prior_std_m: float
    range_floor_m: float
    range_ceiling_m: float
    window_s: float
    literal: bool


class Output(NamedTuple):
    """Arrays to fill: (k, n), the covariance (k, n, 3) as p_xx, p_xp, p_pp; all NaN until a run writes them."""

    range_m: np.ndarray
    coloured_db: np.ndarray
    covariance: np.ndarray
    innovation_db: np.ndarray
    innovation_variance_db2: np.ndarray


@kernel(inline="always", cache=False)
def filter_records(prior, start, predict, update, innovation, range_of, time_s, rss_dbm, rate_mps, setting, out):
    """Run a filter over the rows of `rss_dbm` (k, n); `time_s` and `rate_mps` are (k, n), or (1, n) for all rows.

    Before the first sample of a row the state is `prior(setting)`. A NaN in `rss_dbm` is a sample that is missing: the
    filter only predicts. A NaN in `rate_mps` is a rate that is not known: psi is 0.
    """
    for i in range(rss_dbm.shape[0]):
        t, rate, rss = time_s[min(i, len(time_s) - 1)], rate_mps[min(i, len(rate_mps) - 1)], rss_dbm[i]
        state, heard = prior(setting), False
        held_s, a, sigma_w2 = 0.0, 1.0, 0.0
        for n in range(len(rss)):
            if heard:
                interval_s = t[n] - t[n - 1]
                if abs(interval_s - held_s) > SAME_INTERVAL * held_s:
                    held_s, a = interval_s, max(decay(interval_s, setting.coloured_tc_s), DECAY_MIN)
                    sigma_w2 = driving_std(setting.coloured_variance_db2, a)
                psi_m, noise_ps = 0.0, setting.process_noise_ps
                if not np.isnan(rate[n]):
                    psi_m, noise_ps = rate[n] * interval_s, setting.process_noise_rate_ps
                state = predict(state, psi_m, noise_ps * interval_s, a, sigma_w2, setting)
            if not np.isnan(rss[n]):
                out.innovation_db[i, n], out.innovation_variance_db2[i, n] = innovation(state, rss[n], setting)
                state = update(state, rss[n], setting) if heard else start(state, rss[n], setting)
                heard = True
            x, out.coloured_db[i, n], p_xx, p_xp, p_pp = state
            out.range_m[i, n] = range_of(x)
            out.covariance[i, n, 0], out.covariance[i, n, 1], out.covariance[i, n, 2] = p_xx, p_xp, p_pp
