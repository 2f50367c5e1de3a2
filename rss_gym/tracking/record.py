"""What a tracker publishes: one relative state of an intruder with its covariance. World axes, SI."""

import numpy as np

f8, b1 = np.float64, np.bool_

TRACK = np.dtype(
    [
        ("valid", b1),
        ("position_m", f8, 3),  # of the intruder, relative to the true own position; the estimate
        ("velocity_mps", f8, 3),  # intruder minus own
        ("xx", f8),  # covariance of the position
        ("xy", f8),
        ("yy", f8),
        ("zz", f8),
        ("side_probability", f8),  # of the side of the relative velocity that the track is on; 1 where it is known
        ("other_m", f8, 2),  # where the intruder is if it is on the other side
    ]
)
