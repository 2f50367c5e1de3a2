"""The safety zone, (29)-(40)."""

from rss_gym.jit import kernel

# 80 % of a normal error lies within this many standard deviations; turns a filter's std into delta of (31).
STD_TO_80_PERCENT = 1.2815515655446004


@kernel(inline="always")
def zone_radius_m(range_error_m, range_error_probability, speed_relative_mps, reaction_s, trials):
    """S of (40): (delta / P(delta) + |v| t_r) n_d."""
    return (range_error_m / range_error_probability + speed_relative_mps * reaction_s) * trials


@kernel(inline="always")
def violates(range_m, radius_m):
    """(29): a warning is due."""
    return range_m <= radius_m
