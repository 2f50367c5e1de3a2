"""What a tracker knows of the world beside what it senses: one record made of the parameters."""

from typing import Final

import numpy as np

from rss_gym.params import Params
from rss_gym.physics.elementary import log
from rss_gym.physics.noise import decay

f8, b1 = np.float64, np.bool_

MODEL = np.dtype(
    [
        ("decision_s", f8),
        ("tick_s", f8),
        ("planar", b1),
        ("uses_range", b1),
        ("velocity_variance_m2ps2", f8),  # of the relative velocity, per axis: both sides' solutions
        ("velocity_decay", f8),  # of its error over a decision
        ("own_tc_s", f8),  # correlation time of the position's error; 0: a fix by radio, whose time follows from it
        ("other_tc_s", f8),
        ("own_vertical_m2", f8),  # variance of the height; negative: as the position
        ("other_vertical_m2", f8),
        ("node_m", f8),  # typical distance of a reference node, and its natural logarithm
        ("node_log", f8),
        ("wander", f8),  # standard deviation of the path loss factor, and its correlation time
        ("wander_tc_s", f8),
        ("unheard_mps", f8),
        ("unheard_m2ps", f8),  # what a velocity that is not told adds to the variance of each axis
        ("message_share", f8),
        ("range_share", f8),
        ("range_repeat", f8),
        # Of the bank of bearings
        ("process_noise_m2", f8),  # of the link's filter, in a tick
        ("rest_inflation", f8),
        ("vertical_variance_m2", f8),  # of the height between the two, which the bank leaves out
        ("spread_m2", f8),  # variance of the relative way flown in a decision, per axis, and without messages
        ("spread_unheard_m2", f8),
        ("closing_std_mps", f8),
        ("miss_std_m", f8),
        ("floor_m", f8),
    ]
)

NODE_SHARE: Final = 0.7  # of the square's side: from inside it to its corners
MANOEUVRE_MPS: Final = 0.35  # error of a relative velocity that is read twice a second in gusts and turns, per axis
FOREVER_S: Final = 1e6
FLOOR_M: Final = 1.0  # nearer, the slope of the path loss would say more about the bearing than the motion can
CLOSING_STD_MPS: Final = 0.5  # the message may already tell the first half second of braking
DRIFT_S: Final = 40.0  # a velocity's error persists: over this time it drifts as far as the random walk for it


def model(params: Params) -> np.ndarray:
    """The record of these parameters. Shape (1,); kernels take `model(params)[0]`."""
    out = np.zeros(1, MODEL)
    clock, nav, encounter = params.clock, params.navigation, params.encounter
    out["decision_s"], out["tick_s"], out["planar"] = clock.decision_s, clock.tick_s, encounter.planar
    out["uses_range"] = params.tracking.track_range
    speed = {"gnss": nav.velocity_mps, "rss": nav.velocity_mps, "dead-reckoning": nav.dead_reckoning_mps}
    variance = speed[nav.agent] ** 2 + speed[nav.intruder] ** 2
    out["velocity_variance_m2ps2"] = variance + MANOEUVRE_MPS**2
    out["velocity_decay"] = decay(clock.decision_s, nav.velocity_tc_s)
    time_s = {"gnss": nav.gnss_tc_s, "rss": 0.0, "dead-reckoning": FOREVER_S}
    out["own_tc_s"], out["other_tc_s"] = time_s[nav.agent], time_s[nav.intruder]
    barometer = nav.barometer_m**2 + nav.barometer_datum_m**2
    vertical = {"gnss": nav.gnss_vertical_m**2, "rss": barometer, "dead-reckoning": -1.0}
    out["own_vertical_m2"], out["other_vertical_m2"] = vertical[nav.agent], vertical[nav.intruder]
    out["node_m"] = NODE_SHARE * nav.node_square_m
    out["node_log"] = log(NODE_SHARE * nav.node_square_m)
    unheard = params.tracking.unheard_mps
    out["unheard_mps"], out["unheard_m2ps"] = unheard, 2.0 * unheard**2 * params.tracking.unheard_tc_s
    for name in ("message_share", "range_share", "range_repeat", "rest_inflation", "miss_std_m"):
        out[name] = getattr(params.tracking, name)
    out["process_noise_m2"] = params.ranging.process_noise_m2
    out["wander"] = np.sqrt(np.mean([channel.path_loss_wander**2 for channel in params.channels]))
    out["wander_tc_s"] = max(channel.path_loss_wander_tc_s for channel in params.channels)
    out["vertical_variance_m2"] = 0.0 if encounter.planar else encounter.vertical_offset_m**2
    out["spread_m2"] = variance * DRIFT_S * clock.decision_s
    out["spread_unheard_m2"] = (variance + unheard**2) * DRIFT_S * clock.decision_s
    out["closing_std_mps"], out["floor_m"] = CLOSING_STD_MPS, FLOOR_M
    return out
