"""First-order Gauss-Markov noise, (7)-(11), in the discretisation (8) that the paper uses."""

from math import sqrt

from rss_gym.jit import kernel
from rss_gym.physics.elementary import exp


@kernel(inline="always")
def decay(period_s, correlation_time_s):
    """Decay a = e^{lambda Delta} with lambda = -1 / Tc."""
    return exp(-period_s / correlation_time_s)


@kernel(inline="always")
def driving_std(variance, a):
    """sigma_w2 such that (8) has the stationary `variance`: sigma_w2^2 = S (1 - a^2) / a^2, from (11) at lag 0."""
    return sqrt(variance * (1.0 - a * a)) / a


@kernel(inline="always")
def gauss_markov(x, a, sigma_w2, normal):
    """(8): x(n) = a x(n-1) + a w2(n), with w2 = sigma_w2 times a standard normal."""
    return a * x + a * (sigma_w2 * normal)
