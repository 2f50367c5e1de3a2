"""What is sensed on the road -> observation: a flat float32 vector of named, scaled, clipped fields.

`along` is the direction of the agent's lane and `right` is to the right of it, where lanes have higher numbers.
"""

from __future__ import annotations

import numpy as np

from rss_gym.observation import LIMIT, Field
from rss_gym.params import Params

RANGE_M, STD_M, SPEED_MPS, RELATIVE_MPS, AGE_S = 100.0, 30.0, 30.0, 10.0, 2.0
LANES, LANE_M, BESIDE_M = 3.0, 4.0, 10.0

_OWN = [
    Field("speed_mps", "m/s", SPEED_MPS, -LIMIT, LIMIT, "own speed"),
    Field("speed_error_mps", "m/s", RELATIVE_MPS, -LIMIT, LIMIT, "own speed minus planned speed"),
    Field("commanded_error_mps", "m/s", RELATIVE_MPS, -LIMIT, LIMIT, "speed last commanded minus planned speed"),
    Field("plan_error_m", "m", LANE_M, -LIMIT, LIMIT, "own position to the right of the planned lane's centre"),
    Field("lane_offset_m", "m", LANE_M, -LIMIT, LIMIT, "own position to the right of the own lane's centre"),
    Field("lanes_left", "1", LANES, 0.0, LIMIT, "lanes of the own road to the left of the own one"),
    Field("lanes_right", "1", LANES, 0.0, LIMIT, "the same to the right"),
    Field("changing", "1", 1.0, -LIMIT, LIMIT, "lane last commanded minus own lane: negative to the left"),
]
_RADIO = [
    Field("present", "1", 1.0, 0.0, 1.0, "1 if a vehicle is heard; the row is zero otherwise"),
    Field("range_m", "m", RANGE_M, 0.0, LIMIT, "estimated range"),
    Field("range_std_m", "m", STD_M, 0.0, LIMIT, "its standard deviation according to the filter"),
    Field("range_rate_mps", "m/s", RELATIVE_MPS, -LIMIT, LIMIT, "smoothed rate of the estimated range"),
    Field("warning", "1", 1.0, 0.0, 1.0, "1 while the warning is open"),
    Field("margin_m", "m", RANGE_M, -LIMIT, LIMIT, "estimated range minus zone radius"),
    Field("message_valid", "1", 1.0, 0.0, 1.0, "1 while the warning is open and a message has come"),
    Field("message_age_s", "s", AGE_S, 0.0, LIMIT, "age of the message held"),
    Field("relative_along_mps", "m/s", RELATIVE_MPS, -LIMIT, LIMIT, "announced velocity minus own solution"),
    Field("relative_right_mps", "m/s", RELATIVE_MPS, -LIMIT, LIMIT, "announced velocity minus own solution"),
]
_POSITION = [
    Field("relative_along_m", "m", RANGE_M, -LIMIT, LIMIT, "announced position minus own solution"),
    Field("relative_right_m", "m", BESIDE_M, -LIMIT, LIMIT, "announced position minus own solution"),
]


def fields(params: Params) -> list[Field]:
    """The columns of the observation in order; those of the k-th nearest vehicle are prefixed `vehicle_k.`."""
    radio = _RADIO if params.interface.track == "range" else _RADIO + _POSITION
    columns = list(_OWN)
    for k in range(params.encounter.intruders):
        columns += [Field(f"vehicle_{k}.{f.name}", f.unit, f.scale, f.low, f.high, f.meaning) for f in radio]
    return columns


def split(observation: np.ndarray, params: Params) -> dict[str, np.ndarray]:
    """Undo the scaling: name -> values in SI units, own fields (...), those of the vehicles (..., K).

    Raises
    ------
    ValueError
        If the last axis has not the length that the parameters imply.
    """
    table = fields(params)
    values = np.asarray(observation, dtype=np.float64)
    if values.ndim == 0 or values.shape[-1] != len(table):
        raise ValueError(f"observation has shape {values.shape}; the last axis must be {len(table)} here")
    values = values * np.array([f.scale for f in table])
    own, per = len(_OWN), (len(table) - len(_OWN)) // params.encounter.intruders
    seen = {f.name: values[..., i] for i, f in enumerate(table[:own])}
    return seen | {f.name.partition(".")[2]: values[..., own + i :: per] for i, f in enumerate(table[own : own + per])}


class Writer:
    """Writes observations of one set of parameters; without `radio` the vehicles' fields stay zero."""

    def __init__(self, params: Params, radio: bool) -> None:
        table = fields(params)
        self.low = np.array([f.low for f in table], np.float32)
        self.high = np.array([f.high for f in table], np.float32)
        self._scale = np.array([f.scale for f in table])
        self._count = params.encounter.intruders if radio else 0
        self._width = (len(table) - len(_OWN)) // params.encounter.intruders
        self._positions = params.interface.track != "range"

    def write(
        self, known: dict[str, float], along: tuple[float, float], own: np.ndarray, others: np.ndarray
    ) -> np.ndarray:
        """The observation.

        Parameters
        ----------
        known : dict
            The own fields by name.
        along : tuple of float
            Unit vector along the agent's lane.
        own, others : arrays of OWN (1,) and OTHER (n,)
            As sensed, nearest first.

        Returns
        -------
        (d,) float32 array
        """
        values = np.zeros(len(self._scale))
        values[: len(_OWN)] = [known[f.name] for f in _OWN]
        seen = others[: self._count]
        if len(seen):
            rows = values[len(_OWN) :].reshape(-1, self._width)[: len(seen)]
            rows[:, 0] = 1.0
            rows[:, 1], rows[:, 2], rows[:, 3] = seen["range_m"], seen["range_std_m"], seen["range_rate_mps"]
            rows[:, 4], rows[:, 5] = seen["warning"], seen["range_m"] - seen["radius_m"]
            held = seen["valid"]
            rows[:, 6], rows[:, 7] = held, np.where(held, seen["age_s"], 0.0)
            vectors = [(8, seen["velocity_mps"] - own["velocity_mps"])]
            if self._positions:
                vectors.append((10, seen["position_m"] - own["position_m"]))
            for at, vector in vectors:
                x, y = np.where(held, vector[:, 0], 0.0), np.where(held, vector[:, 1], 0.0)
                rows[:, at], rows[:, at + 1] = x * along[0] + y * along[1], y * along[0] - x * along[1]
        return np.clip((values / self._scale).astype(np.float32), self.low, self.high)
