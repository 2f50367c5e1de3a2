"""The safety zone on the road, (40) scaled to its speeds.

The radius S opens the warning, as in the air: before it nothing is known of the other but its range, so |v| is the
largest relative speed of the road. Among lanes 4 m apart whoever drives beside the agent is within S for good; what
counts then is (40) at the speed with which the pair closes, `pair_radius_m`, and only on the agent's own lane.
"""

from math import sqrt

from rss_gym.jit import kernel
from rss_gym.safety.zone import zone_radius_m

HALF_LANE_M = 2.0  # half the width of highway-env's lanes


@kernel(inline="always")
def pair_radius_m(x_m, y_m, vx_mps, vy_mps, range_error_m, range_error_probability, reaction_s, trials):
    """(40) at the closing speed of a pair, from relative position and relative velocity; opening pairs close at 0."""
    closing_mps = max(-(x_m * vx_mps + y_m * vy_mps) / (sqrt(x_m * x_m + y_m * y_m) + 1e-9), 0.0)
    return zone_radius_m(range_error_m, range_error_probability, closing_mps, reaction_s, trials)
