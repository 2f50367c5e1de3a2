"""Motion of an aircraft: limits on vectors, and the autopilot, the regulator of (42) in closed form."""

from math import sqrt

from rss_gym.jit import kernel


@kernel(inline="always")
def clip(x, low, high):
    """`x` held within [low, high]."""
    return low if x < low else high if x > high else x


@kernel(forceinline=True)
def limit(x, y, z, largest, largest_z):
    """The vector (x, y, z), its z held within +-`largest_z`, then shortened to the length `largest` if longer."""
    z = clip(z, -largest_z, largest_z)
    square = x * x + y * y + z * z
    if square <= largest * largest:
        return x, y, z
    scale = largest / sqrt(square)
    return x * scale, y * scale, z * scale


@kernel(inline="always")
def regulate(position_error_m, velocity_error_mps, position_gain_ps2, velocity_gain_ps):
    """Acceleration that minimises the integral of q e^2 + qv e'^2 + r a^2 for a double integrator: k1 e + k2 e'.

    The squared form of (42); k1 = sqrt(q / r), k2 = sqrt(2 k1 + qv / r) solve its Riccati equation.
    """
    return position_gain_ps2 * position_error_m + velocity_gain_ps * velocity_error_mps
