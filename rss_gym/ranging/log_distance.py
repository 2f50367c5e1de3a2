"""The augmented filter (12)-(21) with the state [x, phi], x = ln d: the RSS (2) is linear in it, without a Jacobian.

    x(n) = x(n-1) + ln(1 + psi(n-1) / d(n-1)) + w(n-1),    RSS(n) = offset - (10 gamma / ln 10) x(n) + phi(n) + v(n).

psi enters as psi / d to first order; the logarithm is what the range d + psi gives, and stays finite near d = 0. With
psi = 0 this is a linear Kalman filter. The process noise w is relative: its variance has no unit.
"""

from math import sqrt

from rss_gym.jit import inner, kernel
from rss_gym.physics.elementary import exp, log
from rss_gym.physics.path_loss import LN10
from rss_gym.ranging import coloured
from rss_gym.ranging.batch import filter_records

positive = coloured.positive
VARIANCE_MAX = 1e4  # of ln d: a factor of e^100 either way, which is nothing known


@kernel(inline="always")
def predict(x, phi, p_xx, p_xp, p_pp, psi_m, process_noise, a, sigma_w2, floor_m):
    """(16)-(17) with A = diag(d / (d + psi), a), W = diag(1, a); d + psi is held above `floor_m`.

    Parameters
    ----------
    x, phi : float
        Logarithm of the range in m, coloured noise (dB).
    p_xx, p_xp, p_pp : float
        Their covariance (1, dB, dB^2).
    psi_m : float
        Change of the range over the interval, m; 0 when unknown.
    process_noise, a, sigma_w2, floor_m : float
        Var(w), e^{lambda Delta}, the standard deviation of w2 of (13), the smallest range.

    Returns
    -------
    tuple of float
        x, phi, p_xx, p_xp, p_pp a priori.
    """
    b = 1.0
    if psi_m != 0.0:
        before_m = exp(x)
        after_m = max(before_m + psi_m, floor_m)
        x, b = log(after_m), before_m / after_m
    return x, a * phi, b * b * p_xx + process_noise, a * b * p_xp, a * a * (p_pp + sigma_w2 * sigma_w2)


@kernel(inline="always")
def innovate(x, phi, p_xx, p_xp, p_pp, rss_dbm, offset_dbm, path_loss_factor, white_variance_db2):
    """Innovation (dB) of (20) and its variance (dB^2), the bracket of (19)."""
    h = -10.0 * path_loss_factor / LN10
    variance = h * (p_xx * h + p_xp) + (p_xp * h + p_pp) + white_variance_db2
    return rss_dbm - (offset_dbm + h * x + phi), variance


@kernel(inline="always")
def update(x, phi, p_xx, p_xp, p_pp, rss_dbm, offset_dbm, path_loss_factor, white_variance_db2, floor_m):
    """(18)-(21) with the constant row h = (-10 gamma / ln 10, 1), Joseph form; the range stays above `floor_m`."""
    h = -10.0 * path_loss_factor / LN10
    error, variance = innovate(x, phi, p_xx, p_xp, p_pp, rss_dbm, offset_dbm, path_loss_factor, white_variance_db2)
    k_x, k_p = (p_xx * h + p_xp) / variance, (p_xp * h + p_pp) / variance
    i_xx, i_xp, i_px, i_pp = 1.0 - k_x * h, -k_x, -k_p * h, 1.0 - k_p
    m_xx, m_xp = i_xx * p_xx + i_xp * p_xp, i_xx * p_xp + i_xp * p_pp
    m_px, m_pp = i_px * p_xx + i_pp * p_xp, i_px * p_xp + i_pp * p_pp
    r = white_variance_db2
    p_xx = m_xx * i_xx + m_xp * i_xp + k_x * r * k_x
    p_xp = m_xx * i_px + m_xp * i_pp + k_x * r * k_p
    p_pp = m_px * i_px + m_pp * i_pp + k_p * r * k_p
    return max(x + k_x * error, log(floor_m)), phi + k_p * error, p_xx, p_xp, p_pp


@inner
def bounded(x, phi, p_xx, p_xp, p_pp, setting):
    """The range within its floor and ceiling, the covariance positive definite and not larger than says anything."""
    x = min(max(x, log(setting.range_floor_m)), log(setting.range_ceiling_m))
    if p_xx > VARIANCE_MAX:
        p_xx, p_xp = VARIANCE_MAX, p_xp * sqrt(VARIANCE_MAX / p_xx)
    p_xx, p_xp, p_pp = positive(p_xx, p_xp, p_pp)
    return x, phi, p_xx, p_xp, p_pp


@inner
def prior(setting):
    """State (ln d, phi) and covariance before the first sample, as `filter_records` takes them."""
    relative = min(setting.prior_std_m / setting.prior_range_m, sqrt(VARIANCE_MAX))
    return log(setting.prior_range_m), 0.0, relative * relative, 0.0, setting.coloured_variance_db2


@inner
def predict_state(state, psi_m, process_noise, a, sigma_w2, setting):
    """`predict` of `state` (ln d, phi, p_xx, p_xp, p_pp)."""
    x, phi, p_xx, p_xp, p_pp = state
    x, phi, p_xx, p_xp, p_pp = predict(
        x, phi, p_xx, p_xp, p_pp, psi_m, process_noise, a, sigma_w2, setting.range_floor_m
    )
    return bounded(x, phi, p_xx, p_xp, p_pp, setting)


@inner
def update_state(state, rss_dbm, setting):
    """`update` of `state` by one sample (dBm)."""
    x, phi, p_xx, p_xp, p_pp = state
    x, phi, p_xx, p_xp, p_pp = update(
        x, phi, p_xx, p_xp, p_pp, rss_dbm,
        setting.offset_dbm, setting.path_loss_factor, setting.white_variance_db2, setting.range_floor_m,
    )  # fmt: skip
    return bounded(x, phi, p_xx, p_xp, p_pp, setting)


@inner
def innovation(state, rss_dbm, setting):
    """Innovation (dB) of one sample (dBm) and its variance (dB^2)."""
    x, phi, p_xx, p_xp, p_pp = state
    return innovate(
        x, phi, p_xx, p_xp, p_pp, rss_dbm,
        setting.offset_dbm, setting.path_loss_factor, setting.white_variance_db2,
    )  # fmt: skip


@kernel
def run(time_s, rss_dbm, rate_mps, setting, out):
    """The filter over a batch of records; the first sample is an update like any other, as it is exact."""
    filter_records(
        prior, update_state, predict_state, update_state, innovation, exp, time_s, rss_dbm, rate_mps, setting, out
    )
