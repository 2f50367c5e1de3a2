"""What a tracker publishes of one intruder, and the layout of what it remembers.

Axes are the world's, units SI. A memory is one row of 64-bit floats for each intruder; all zeros mean "nothing heard".
"""

from typing import Final

import numpy as np

f8, b1 = np.float64, np.bool_

# Codes of the trackers in the records.
LATEST: Final = 0
FUSED: Final = 1
BEARINGS: Final = 2

TRACK = np.dtype(
    [
        ("valid", b1),  # a message was received in this episode
        ("position_m", f8, 3),  # of the intruder, relative to the own solution
        ("velocity_mps", f8, 3),  # of the intruder, relative to the own velocity
        # Covariance of the position's error against the true relative position, m^2
        ("xx", f8),
        ("xy", f8),
        ("yy", f8),
        ("zz", f8),
        # Of a tracker with two sides (`bearings`): that of the side above, and the mean of the other side
        ("side_probability", f8),
        ("other_m", f8, 2),
    ]
)

# Memory of `fused`: columns of a row.
OPEN: Final = 0  # 1 once a message was received
AGE: Final = 1  # of the message held at the last decision, s
VELOCITY: Final = 2  # measured relative velocity at the last decision (3)
HEIGHT: Final = 5  # relative height and its variance (2)
STATED: Final = 7  # variance of the message's error at the last decision, m^2
STATE: Final = 8  # position (2), error of the relative velocity (2), error of the message (2)
COVARIANCE: Final = 14  # of the state, 6 x 6, row by row
FUSED_COLUMNS: Final = 50

# Memory of `bearings`: open as above, measured relative velocity (2), side chosen, then the bank.
WAY: Final = 1
SIDE: Final = 3
BANK: Final = 4
