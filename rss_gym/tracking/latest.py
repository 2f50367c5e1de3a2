"""The message held, moved on by its age: no filter, and no use of the range.

p = u_j + age v_j - u_i, with the variance of both positions, and the distance an error of the velocity flies meanwhile.
"""

from rss_gym.jit import kernel


@kernel(forceinline=True)
def vertical_m2(own, other, model):
    """Variance of the relative height, m^2."""
    mine = model.own_vertical_m2 if model.own_vertical_m2 >= 0.0 else own.std_m * own.std_m
    theirs = model.other_vertical_m2 if model.other_vertical_m2 >= 0.0 else other.std_m * other.std_m
    return 0.0 if model.planar else mine + theirs


@kernel
def advance(own, other, memory, track, model):
    """Write the track of one intruder. Arguments as for every tracker, `tracking.Advance`."""
    track.valid = other.valid
    if not other.valid:
        return
    age = other.age_s
    for axis in range(3):
        track.position_m[axis] = other.position_m[axis] + age * other.velocity_mps[axis] - own.position_m[axis]
        track.velocity_mps[axis] = other.velocity_mps[axis] - own.velocity_mps[axis]
    flown = (model.velocity_variance_m2ps2 + model.unheard_mps * model.unheard_mps) * age * age
    track.xx = track.yy = own.std_m * own.std_m + other.std_m * other.std_m + flown
    track.xy = 0.0
    track.zz = vertical_m2(own, other, model) + (0.0 if model.planar else flown)
    track.side_probability = 1.0
    track.other_m[0], track.other_m[1] = track.position_m[0], track.position_m[1]
