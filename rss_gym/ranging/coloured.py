"""The augmented extended Kalman filter, (12)-(21): state c = [d, phi], range and coloured noise.

Both (12) and (15) misprint the sign: here h(c) = offset - 10 gamma log10 d + phi throughout.
"""

from math import sqrt

from rss_gym.jit import kernel
from rss_gym.physics.elementary import exp
from rss_gym.physics.path_loss import LN10, received_dbm, slope_db_pm

CANCELLED = 1e-6  # share of a variance below which the difference that gives it has lost its digits
VARIANCE_MIN, CORRELATION_MAX = 1e-12, 1.0 - 1e-9


@kernel(inline="always")
def positive(p_dd, p_dp, p_pp):
    """A covariance that rounding has made indefinite as the nearest that is not; any other as it is.

    The Joseph form keeps it positive definite up to rounding, which wins where the variances of the two states, or of
    the state and the measurement, differ by sixteen digits. A `p_pp` of 0 is that of a filter without coloured noise.
    """
    if p_dd < VARIANCE_MIN or (p_pp != 0.0 and (p_pp < VARIANCE_MIN or p_dd * p_pp <= p_dp * p_dp)):
        p_dd = max(p_dd, VARIANCE_MIN)
        p_pp = max(p_pp, VARIANCE_MIN) if p_pp != 0.0 else 0.0
        bound = CORRELATION_MAX * (sqrt(p_dd) * sqrt(p_pp))
        p_dp = min(max(p_dp, -bound), bound)
    return p_dd, p_dp, p_pp


@kernel(inline="always")
def start(prior_m, prior_std_m, coloured_variance_db2, rss_dbm, offset_dbm, path_loss_factor, white_variance_db2):
    """The filter after its first sample: P(0) = diag(range prior, S), updated in ln d, where h is exactly linear.

    A range prior as wide as tens of percent is far outside the region in which (18)-(21) may be linearised.

    Returns
    -------
    tuple of float
        d, phi, p_dd, p_dp, p_pp as in `predict`.
    """
    h = -10.0 * path_loss_factor / LN10  # slope of (3) in ln d
    p_xx, p_pp = (prior_std_m / prior_m) * (prior_std_m / prior_m), coloured_variance_db2
    innovation_variance = h * p_xx * h + p_pp + white_variance_db2
    k_x, k_p = h * p_xx / innovation_variance, p_pp / innovation_variance
    innovation = rss_dbm - received_dbm(offset_dbm, path_loss_factor, prior_m * prior_m)
    d = prior_m * exp(k_x * innovation)
    x_xx, x_xp, x_pp = p_xx - k_x * h * p_xx, -k_x * p_pp, p_pp - k_p * p_pp
    if x_xx <= CANCELLED * p_xx or (p_pp > 0.0 and x_pp <= CANCELLED * p_pp):
        # The same without a difference of large numbers.
        x_xx = p_xx * ((p_pp + white_variance_db2) / innovation_variance)
        x_pp = p_pp * ((h * p_xx * h + white_variance_db2) / innovation_variance)
        x_xx, x_xp, x_pp = positive(x_xx, x_xp, x_pp)
    return d, k_p * innovation, d * d * x_xx, d * x_xp, x_pp


@kernel(inline="always")
def predict(d, phi, p_dd, p_dp, p_pp, psi_m, process_noise_m2, a, sigma_w2):
    """(16)-(17) with A = diag(1, a), W = diag(1, a), Q = diag(process noise, sigma_w2^2).

    Parameters
    ----------
    d, phi : float
        Range (m) and coloured noise (dB), a posteriori of the tick before.
    p_dd, p_dp, p_pp : float
        Their covariance (m^2, m dB, dB^2).
    psi_m : float
        Control input psi of (12): the range's change over the tick, m; 0 when unknown.
    process_noise_m2, a, sigma_w2 : float
        Var(w), e^{lambda Delta} and the standard deviation of w2 of (13).

    Returns
    -------
    tuple of float
        d, phi, p_dd, p_dp, p_pp a priori.
    """
    return d + psi_m, a * phi, p_dd + process_noise_m2, a * p_dp, a * a * (p_pp + sigma_w2 * sigma_w2)


@kernel(inline="always")
def update(d, phi, p_dd, p_dp, p_pp, rss_dbm, offset_dbm, path_loss_factor, white_variance_db2, floor_m):
    """(18)-(21), the covariance in Joseph form; the range is held above `floor_m`, where log d is defined."""
    h = slope_db_pm(path_loss_factor, d)  # the Jacobian is (h, 1)
    hat_d, hat_p = p_dd * h + p_dp, p_dp * h + p_pp  # (18)
    innovation_variance = h * hat_d + hat_p + white_variance_db2
    k_d, k_p = hat_d / innovation_variance, hat_p / innovation_variance  # (19)
    innovation = rss_dbm - (received_dbm(offset_dbm, path_loss_factor, d * d) + phi)
    d, phi = d + k_d * innovation, phi + k_p * innovation  # (20)
    # (21) as (I - K h) P (I - K h)^T + K R K^T, which stays positive definite.
    i_dd, i_dp, i_pd, i_pp = 1.0 - k_d * h, -k_d, -k_p * h, 1.0 - k_p
    m_dd, m_dp = i_dd * p_dd + i_dp * p_dp, i_dd * p_dp + i_dp * p_pp
    m_pd, m_pp = i_pd * p_dd + i_pp * p_dp, i_pd * p_dp + i_pp * p_pp
    r = white_variance_db2
    p_dd = m_dd * i_dd + m_dp * i_dp + k_d * r * k_d
    p_dp = m_dd * i_pd + m_dp * i_pp + k_d * r * k_p
    p_pp = m_pd * i_pd + m_pp * i_pp + k_p * r * k_p
    p_dd, p_dp, p_pp = positive(p_dd, p_dp, p_pp)
    return max(d, floor_m), phi, p_dd, p_dp, p_pp
