"""Lanes and vehicles as the kernels have them."""

import numpy as np

f8, i8, b1 = np.float64, np.int64, np.bool_

CONNECTED_MAX = 8  # lanes before and after a lane
LANE = np.dtype(
    [
        ("start_m", f8, 2), ("direction", f8, 2), ("heading", f8), ("length_m", f8), ("width_m", f8),
        ("speed_limit_mps", f8), ("forbidden", b1),
        ("amplitude_m", f8), ("pulsation", f8), ("phase", f8),  # of a sine lane, else zero
        ("left", i8), ("right", i8),  # the lanes beside it on its road; -1: none
        ("next", i8, CONNECTED_MAX), ("next_count", i8),  # that a vehicle may go on to: the nearest is taken
        ("connected", i8, CONNECTED_MAX), ("offset_m", f8, CONNECTED_MAX), ("connected_count", i8),  # itself first
    ]
)  # fmt: skip
CONTROLLED, IDM, OBSTACLE = range(3)
VEHICLE = np.dtype(
    [
        ("position_m", f8, 2), ("heading", f8), ("speed_mps", f8), ("length_m", f8), ("width_m", f8),
        ("kind", i8), ("lane", i8), ("target_lane", i8), ("target_mps", f8), ("exponent", f8), ("timer_s", f8),
        ("steering", f8), ("acceleration", f8), ("crashed", b1), ("checks", b1), ("hit", b1), ("impact_m", f8, 2),
    ]
)  # fmt: skip

VEHICLE_LENGTH = 5.0  # highway-env's, m, whatever the length of a vehicle
