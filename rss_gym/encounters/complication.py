"""What befalls the messages and the link of an intruder, drawn at the start of an episode (`family.Complication`)."""

from rss_gym.encounters.sampler import between, planned, signed
from rss_gym.jit import inner
from rss_gym.physics.elementary import cos, sin
from rss_gym.physics.geometry import entry_s
from rss_gym.physics.random import uniform
from rss_gym.streams import STREAM_COMPLICATION


@inner
def complicate(family, radius_m, key, k, agent, intruder, contact, link):
    """Draw what intruder `k`, of family `family`, announces, and when its link jumps or is silent."""
    stream = STREAM_COMPLICATION + k
    onset_s = zone_entry_s(agent, intruder, radius_m) + between(
        uniform(key, stream, 0), family.onset_min_s, family.onset_max_s
    )
    announced_rad = signed(uniform(key, stream, 1), family.announced_min_rad, family.announced_max_rad)
    contact.false_turn[0], contact.false_turn[1] = cos(announced_rad), sin(announced_rad)
    link.jump_s, link.jump = onset_s, signed(uniform(key, stream, 2), family.jump_min, family.jump_max)
    contact.silent_s = onset_s
    contact.silent_until_s = onset_s + between(uniform(key, stream, 3), family.outage_min_s, family.outage_max_s)


@inner
def zone_entry_s(one, two, radius_m):
    """Time (s) at which two predefined trajectories first are within `radius_m`, were their first legs to go on."""
    ax, ay, az, avx, avy, avz = planned(one, 0, 0.0)
    bx, by, bz, bvx, bvy, bvz = planned(two, 0, 0.0)
    return entry_s(bx - ax, by - ay, bz - az, bvx - avx, bvy - avy, bvz - avz, radius_m)
