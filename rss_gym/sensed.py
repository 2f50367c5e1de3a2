"""What an agent may know: the only source of its tracks and its observation. World axes, SI."""

import numpy as np

f8, b1 = np.float64, np.bool_

OWN = np.dtype(
    [
        ("position_m", f8, 3),  # own navigation solution
        ("velocity_mps", f8, 3),
        ("std_m", f8),  # of the solution's position, per horizontal axis
        ("planned_m", f8, 3),  # predefined trajectory now
        ("planned_mps", f8, 3),
        ("along", f8, 3),  # unit vector of the current leg
        ("way_point_m", f8, 3),  # commanded
        ("ahead_m", f8, 3),  # where the predefined trajectory is `announce_s` later, minus where it is now
    ]
)

OTHER = np.dtype(
    [
        ("present", b1),
        ("range_m", f8),
        ("range_std_m", f8),
        ("coloured_db", f8),
        ("range_rate_mps", f8),
        ("radius_m", f8),
        ("warning", b1),
        ("consecutive_warnings", f8),  # consecutive warnings over n_d, at most 1
        # The message held
        ("valid", b1),
        ("age_s", f8),
        ("position_m", f8, 3),
        ("velocity_mps", f8, 3),
        ("way_point_m", f8, 3),
        ("std_m", f8),  # accuracy that the sender states, per horizontal axis
        # What the filters hold of the radio
        ("path_loss_factor", f8),
        ("white_std_db", f8),
        ("coloured_std_db", f8),
        ("coloured_tc_s", f8),
    ]
)
