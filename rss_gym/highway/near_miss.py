"""The sNMAC of a road, a near miss: a vehicle that would touch the agent within 1.5 s if both went straight on.

A time to collision below 1.5 s is the usual mark of a serious conflict in traffic (Hyden's technique takes it). In the
air a near miss is a small separation; on lanes 4 m apart that would hold for whoever drives beside the agent.
"""

from math import inf

from rss_gym.jit import kernel

NEAR_MISS_S = 1.5
HALF_LENGTH_M, HALF_WIDTH_M = 2.5, 1.0  # of highway-env's vehicles


@kernel
def entry_of_slab_s(offset_m, speed_mps, half_m):
    """First and last time at which |offset + speed t| <= half; the first is infinite if there is none."""
    if speed_mps == 0.0:
        return (-inf, inf) if abs(offset_m) <= half_m else (inf, -inf)
    one, two = (-half_m - offset_m) / speed_mps, (half_m - offset_m) / speed_mps
    return min(one, two), max(one, two)


@kernel
def time_to_contact_s(x_m, y_m, v_mps, w_mps, forward, right):
    """Time (s) to the first contact of two vehicles that keep their velocities: 0 if they touch, inf if they never do.

    Along the agent's heading and to the right of it, the other is at (x, y) with the relative velocity (v, w); its own
    heading has the components `forward` and `right`. Its body counts as the least rectangle that is not turned against
    the agent's and holds it: exact where the headings are parallel or at right angles, else a little too large.
    """
    half_x_m = HALF_LENGTH_M + HALF_LENGTH_M * abs(forward) + HALF_WIDTH_M * abs(right)
    half_y_m = HALF_WIDTH_M + HALF_LENGTH_M * abs(right) + HALF_WIDTH_M * abs(forward)
    first_x, last_x = entry_of_slab_s(x_m, v_mps, half_x_m)
    first_y, last_y = entry_of_slab_s(y_m, w_mps, half_y_m)
    first, last = max(first_x, first_y, 0.0), min(last_x, last_y)
    return first if first <= last else inf
