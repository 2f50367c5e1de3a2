"""Modified voltage potential (MVP): the velocity change that moves the closest approach to the edge of the zone.

Hoekstra, van Gent and Ruigrok, "Designing for safety: the free flight air traffic management concept" (Reliability
Engineering and System Safety 75, 2002), as in BlueSky's `traffic/asas/mvp.py`. Several intruders' changes add up.
"""

from math import sqrt

from rss_gym.avoidance.approach import side_of
from rss_gym.jit import kernel
from rss_gym.tracking.approach import closest

# BlueSky takes 10 m of a zone of 5 nautical miles for a head-on, where the offset has no direction.
HEAD_ON_SHARE = 10.0 / 9260.0
# To the other side than the offset's the turn may be a right angle or more, which no finite change makes.
LEAST_ETA = 0.1


@kernel
def velocity_change(x, y, vx, vy, radius_m, lookahead_s, side):
    """Velocity change because of one other.

    Parameters
    ----------
    x, y : float
        Position of the other relative to the own aircraft, m.
    vx, vy : float
        Own velocity relative to the other, m/s.
    radius_m, lookahead_s : float
        A conflict is an approach closer than this within this time.
    side : float
        Sign of the side to keep, as `approach.side_of` has it, or 0 for the one on which the offset is.

    Returns
    -------
    tuple of float
        The change (m/s); 0 without a conflict. The offset c at the closest approach becomes (R / eta) c / |c|, where
        eta = cos(asin(R / d) - asin(|c| / d)) accounts for the turn of the relative velocity.
    """
    t, cx, cy, _ = closest(x, y, 0.0, -vx, -vy, 0.0)
    distance, miss = sqrt(x * x + y * y), sqrt(cx * cx + cy * cy)
    if t <= 0.0 or t > lookahead_s or miss >= radius_m:
        return 0.0, 0.0
    # The direction of the offset: at right angles to the relative velocity, in an exact head-on to the bearing.
    here = side_of(x, y, vx, vy)
    if side != 0.0 and here != side:
        miss, here = -miss, side
    speed = sqrt(vx * vx + vy * vy)
    nx, ny = here * vy / speed, -here * vx / speed
    if abs(miss) <= HEAD_ON_SHARE * radius_m:
        nx, ny = here * y / distance, -here * x / distance
    wanted = radius_m
    if distance > radius_m:
        sine_r, sine_c = radius_m / distance, miss / distance
        eta = sqrt((1.0 - sine_r * sine_r) * (1.0 - sine_c * sine_c)) + sine_r * sine_c
        wanted = radius_m / max(eta, LEAST_ETA)
    change = (wanted - miss) / t
    return -change * nx, -change * ny
