"""What an agent may know: the only source of its observation. Positions and velocities in the world's axes, SI."""

import numpy as np

f8, b1 = np.float64, np.bool_

OWN = np.dtype(
    [
        ("time_s", f8),
        ("position_m", f8, 3),  # own navigation solution
        ("velocity_mps", f8, 3),
        ("std_m", f8),  # of the own solution, per axis
        ("planned_m", f8, 3),  # predefined trajectory now
        ("planned_mps", f8, 3),
        ("along", f8, 3),  # unit vector of the current leg
        ("way_point_m", f8, 3),  # commanded
        ("ahead_m", f8, 3),  # planned position `announce_s` ahead minus planned now
        ("turn_in_s", f8),  # time to the next turn of the predefined trajectory, inf without one
        ("turn_along", f8, 3),  # unit vector of the leg after it
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
        ("streak", f8),  # consecutive warnings over n_d, at most 1
        ("valid", b1),  # a message is held
        ("age_s", f8),
        ("position_m", f8, 3),
        ("velocity_mps", f8, 3),
        ("way_point_m", f8, 3),
        ("std_m", f8),  # of the position told, per axis, as the sender states it
        # The radio as the filters hold it
        ("path_loss_factor", f8),
        ("white_std_db", f8),
        ("coloured_std_db", f8),
        ("coloured_tc_s", f8),
    ]
)
