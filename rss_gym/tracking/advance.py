"""(provisional)"""
from rss_gym.jit import inner


@inner
def start(config, own, other, memory, track, model):
    track.valid = False
    advance(config, own, other, memory, track, model)


@inner
def advance(config, own, other, memory, track, model):
    track.valid = other.valid
    if other.valid:
        for axis in range(3):
            track.position_m[axis] = other.position_m[axis] + other.velocity_mps[axis] * other.age_s - own.position_m[axis]
            track.velocity_mps[axis] = other.velocity_mps[axis] - own.velocity_mps[axis]
        v = other.std_m * other.std_m + own.std_m * own.std_m
        track.xx, track.xy, track.yy, track.zz = v, 0.0, v, v
        track.side_probability = 1.0
