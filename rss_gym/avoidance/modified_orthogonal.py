"""The modified orthogonal rule of Sec. IX-A, for fewer than three reference nodes: ranges and a velocity, no position.

The lower ID hovers for one segment. Two ranges and the way flown between them make a triangle with the other's
position; the velocity then chosen is at right angles to the other's previous one, as large, with the sign that
increases the range.
"""

from math import sqrt

from rss_gym.jit import kernel
from rss_gym.physics.motion import clip


@kernel
def bearing_cosine(range_before_m, range_after_m, flown_m):
    """Cosine of the angle between the way flown and the direction to the hovering other, from the triangle's sides.

    Held within [-1, 1], as noisy ranges need not make a triangle; 0 if nothing was flown.
    """
    if flown_m <= 0.0 or range_after_m <= 0.0:
        return 0.0
    square = range_before_m * range_before_m - range_after_m * range_after_m - flown_m * flown_m
    return clip(square / (2.0 * range_after_m * flown_m), -1.0, 1.0)


@kernel
def velocity(other_x, other_y, flown_x, flown_y, cosine):
    """Velocity orthogonal to (other_x, other_y), as large, with the sign that increases the range.

    The triangle leaves the other on either side of the way flown, (flown_x, flown_y); if the two mirror images ask
    for different signs, their mean decides, which is the direction flown.

    Returns
    -------
    tuple of float
        x and y of the velocity, in axes whose y is to the right of x.
    """
    length = sqrt(flown_x * flown_x + flown_y * flown_y)
    ox, oy = -other_y, other_x  # to the right of the other's velocity
    if length == 0.0:
        return ox, oy
    toward = ox * flown_x / length + oy * flown_y / length  # part of it along the way flown
    across = ox * -flown_y / length + oy * flown_x / length
    sine = sqrt(1.0 - cosine * cosine)
    one, two = toward * cosine + across * sine, toward * cosine - across * sine
    closing = one + two if one * two < 0.0 else one
    return (-ox, -oy) if closing > 0.0 else (ox, oy)
