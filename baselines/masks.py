"""Fields that a policy is trained and flown without: what they are worth."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rss_gym.domain import domain_of
from rss_gym.params import Params

# What the filter of a link holds. The track that the range has been fused into stays; `tracker="latest"` is without.
RANGE = (
    "range_m",
    "range_std_m",
    "range_rate_mps",
    "coloured_db",
    "path_loss_factor",
    "white_std_db",
    "coloured_std_db",
    "coloured_tc_s",
    "margin_m",
    "consecutive_warnings",
)

APPROACH = ("flown_", "planned_")  # the closest approaches that the track predicts
OTHERS = ("intruder_", "vehicle_", "on_")  # what the names of their fields begin with

# What is taken away -> whether it holds this field.
MASKS: dict[str, Callable[[str], bool]] = {
    "nothing": lambda name: False,
    "range": lambda name: name.startswith(OTHERS) and name.partition(".")[2] in RANGE,
    "approach": lambda name: name.startswith(OTHERS) and name.partition(".")[2].startswith(APPROACH),
    "radio": lambda name: name.startswith(OTHERS),
}


def kept(zeroed: str, params: Params, stack: int = 1) -> np.ndarray:
    """One for each column that stays and zero for the others, of `stack` observations; float32.

    Parameters
    ----------
    zeroed : str
        One of `MASKS`: `range` is what the filter of the link holds, `approach` the closest approaches that the track
        predicts, `radio` all that is known of the others.
    params : Params
    stack : int
    """
    row = [not MASKS[zeroed](field.name) for field in domain_of(params).fields(params)]
    return np.tile(np.array(row, np.float32), stack)
