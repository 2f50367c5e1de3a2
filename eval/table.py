"""The episode table: one row an encounter, everything a metric may need, nothing that a policy may see."""

import numpy as np

f8, i8, u8, b1 = np.float64, np.int64, np.uint64, np.bool_

TABLE = np.dtype(
    [
        ("episode", u8),  # number within split and seed
        ("family", i8),  # index into the suite's families
        ("channel", i8),
        ("duration_s", f8),  # the encounter's fixed length
        ("flown_s", f8),  # shorter only after a collision
        ("approach_s", f8),  # planned closest approach
        # Events on true states
        ("collision", b1),
        ("snmac", b1),
        ("zone", b1),
        ("zone_severity", f8),  # mean over the ticks flown of max(0, 1 - separation / S)
        ("min_separation_m", f8),
        ("closest_s", f8),  # time of the least separation
        # Path
        ("deviation_mean_m", f8),  # mean of |u - u^d| while flown
        ("deviation_max_m", f8),
        ("manoeuvre_m", f8),  # max |u - u_none|, sampled once a decision; the flight of `none` on the same encounter
        ("flown_m", f8),
        ("planned_m", f8),  # length of the predefined trajectory over the time flown
        ("deviation_end_m", f8),  # mean over the last decision
        ("cost_m", f8),  # of the encounter, see `rss_gym.eval.costs`
        # Warnings
        ("warned_s", f8),  # time of the first warning, -1 without one
        ("false_alerts", i8),  # warnings that opened at a true separation above S
        ("missed_ticks", i8),  # longest run of ticks with d <= S and an estimate above S
        # One decision before the planned closest approach, drawn from the encounter's key, so that samples are
        # independent between encounters; zero where the flight ended before it
        ("sample_separation_m", f8),  # true, of the first intruder
        ("sample_range_m", f8),  # estimated
        ("fault", b1),  # the policy raised, or gave an action of wrong shape or not finite
    ]
)

# A road's: beside these, means over the decisions driven.
ROAD_TABLE = np.dtype([*TABLE.descr, ("lane_deviation_m", "<f8"), ("speed_deviation_mps", "<f8")])
TABLES = {"air": TABLE, "road": ROAD_TABLE}  # of each domain
