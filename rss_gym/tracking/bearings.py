"""Ranges and two velocities only: a bank of bearings, opened by the first message of an episode.

The track is the more probable of two sides, to the left and to the right of the relative velocity, which a straight
relative flight leaves alike; what the agent flies tells them apart. Of two sides that are about alike the one chosen
before is kept.

An outage is not told apart from reception: the range that the link's filter holds in silence counts as measured.
"""

from rss_gym.jit import kernel
from rss_gym.tracking import bank
from rss_gym.tracking.record import BANK, OPEN, SIDE, WAY

KEEP = 0.05  # the other side must be this much more probable than one half
bank_start, bank_advance, sides, summed = bank.start, bank.advance, bank.sides, bank.summed


@kernel
def advance(own, other, memory, track, model):
    """Advance the bank of one intruder by a decision and write its track. Arguments: see `tracking.Advance`."""
    m = memory
    track.valid = other.valid
    if not other.valid:
        m[OPEN] = 0.0
        return
    u, v = own.velocity_mps, other.velocity_mps
    vx, vy, vz = v[0] - u[0], v[1] - u[1], v[2] - u[2]
    if m[OPEN] == 0.0:
        m[OPEN], m[SIDE] = 1.0, 1.0  # left until one is more probable
        bank_start(m, BANK, other, vx, vy, model)
    else:
        half = 0.5 * model.decision_s
        spread_m2 = model.spread_m2 if other.warning else model.spread_unheard_m2
        bank_advance(m, BANK, half * (m[WAY] + vx), half * (m[WAY + 1] + vy), spread_m2, other, model)
    m[WAY], m[WAY + 1] = vx, vy
    left, right = sides(m, BANK, vx, vy)
    probability = (left[0] if m[SIDE] > 0.0 else right[0]) / (left[0] + right[0])
    if probability < 0.5 - KEEP:
        m[SIDE], probability = -m[SIDE], 1.0 - probability
    x, y, xx, xy, yy = summed(left if m[SIDE] > 0.0 else right)
    tx, ty, _, _, _ = summed(right if m[SIDE] > 0.0 else left)
    track.position_m[0], track.position_m[1], track.position_m[2] = x, y, 0.0
    track.velocity_mps[0], track.velocity_mps[1], track.velocity_mps[2] = vx, vy, vz
    track.xx, track.xy, track.yy, track.zz = xx, xy, yy, model.vertical_variance_m2
    track.side_probability = probability
    track.other_m[0], track.other_m[1] = tx, ty
