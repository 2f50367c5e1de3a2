"""What is sensed on the road -> observation: a flat float32 vector of named fields, by the air's table and transform.

`fields(params)` is the table of them. `Writer` writes their raw SI values in the order of the table, and
`rss_gym.observation.transform` scales, clips or stretches them as the table says; `split` goes back to SI. `along` is
the direction of the agent's lane and `right` is to the right of it, where lanes have higher numbers.
"""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np

from rss_gym.highway import lane_fields
from rss_gym.observation import LIMIT, Field, restored, transform, transforms
from rss_gym.params import Params

RANGE_M, STD_M, SPEED_MPS, RELATIVE_MPS, AGE_S = 100.0, 30.0, 30.0, 10.0, 2.0
LANES, LANE_M, ACCURACY_M = 3.0, 4.0, 15.0
NOISE_DB, FACTOR, TC_S = 10.0, 4.0, 10.0
NEAR_M = 20.0  # half of what a stretched distance along the road can say is said within this, and across within a lane

_OWN = [
    Field("speed_mps", "m/s", SPEED_MPS, -LIMIT, LIMIT, "own speed"),
    Field("speed_error_mps", "m/s", RELATIVE_MPS, -LIMIT, LIMIT, "own speed minus planned speed"),
    Field("commanded_error_mps", "m/s", RELATIVE_MPS, -LIMIT, LIMIT, "speed last commanded minus planned speed"),
    Field("plan_error_m", "m", LANE_M, -LIMIT, LIMIT, "own position to the right of the planned lane's centre"),
    Field("plan_ahead_m", "m", 1.0, -1.0, 1.0, "own position ahead of where the planned speed would have led", NEAR_M),
    Field("lane_offset_m", "m", LANE_M, -LIMIT, LIMIT, "own position to the right of the own lane's centre"),
    Field("lanes_left", "1", LANES, 0.0, LIMIT, "lanes of the own road to the left of the own one"),
    Field("lanes_right", "1", LANES, 0.0, LIMIT, "the same to the right"),
    Field("changing", "1", 1.0, -LIMIT, LIMIT, "lane last commanded minus own lane: negative to the left"),
    Field("solution_std_m", "m", ACCURACY_M, 0.0, LIMIT, "standard deviation of the own solution, per axis"),
]
_RADIO = [
    Field("present", "1", 1.0, 0.0, 1.0, "1 if a vehicle is heard; the row is zero otherwise"),
    Field("range_m", "m", RANGE_M, 0.0, LIMIT, "estimated range"),
    Field("range_std_m", "m", STD_M, 0.0, LIMIT, "its standard deviation according to the filter"),
    Field("range_rate_mps", "m/s", RELATIVE_MPS, -LIMIT, LIMIT, "smoothed rate of the estimated range"),
    Field("coloured_db", "dB", NOISE_DB, -LIMIT, LIMIT, "estimated coloured noise of the link"),
    Field("path_loss_factor", "1", FACTOR, 0.0, LIMIT, "path loss factor that the filter holds"),
    Field("white_std_db", "dB", NOISE_DB, 0.0, LIMIT, "standard deviation of the white noise that it holds"),
    Field("coloured_std_db", "dB", NOISE_DB, 0.0, LIMIT, "that of the coloured noise"),
    Field("coloured_tc_s", "s", TC_S, 0.0, LIMIT, "correlation time of the coloured noise"),
    Field("zone_radius_m", "m", RANGE_M, 0.0, LIMIT, "radius S of the safety zone"),
    Field("margin_m", "m", RANGE_M, -LIMIT, LIMIT, "estimated range minus zone radius"),
    Field("warning", "1", 1.0, 0.0, 1.0, "1 while the warning is open"),
    Field("consecutive_warnings", "1", 1.0, 0.0, 1.0, "consecutive ticks inside the zone over n_d"),
]
_MESSAGE = [
    Field("message_valid", "1", 1.0, 0.0, 1.0, "1 while the warning is open and a message has come; else zeros"),
    Field("message_age_s", "s", AGE_S, 0.0, LIMIT, "age of the message held"),
    Field("relative_along_mps", "m/s", RELATIVE_MPS, -LIMIT, LIMIT, "announced velocity minus own solution"),
    Field("relative_right_mps", "m/s", RELATIVE_MPS, -LIMIT, LIMIT, "announced velocity minus own solution"),
]
_POSITION = [
    Field("relative_along_m", "m", 1.0, -1.0, 1.0, "announced position minus own solution", NEAR_M),
    Field("relative_right_m", "m", 1.0, -1.0, 1.0, "announced position minus own solution", LANE_M),
    Field("message_std_m", "m", ACCURACY_M, 0.0, LIMIT, "accuracy of its position that the vehicle states, per axis"),
]


def fields(params: Params) -> list[Field]:
    """The columns of the observation in order; those of the k-th nearest vehicle are prefixed `vehicle_k.`."""
    return list(_fields(params))


@cache
def _fields(params: Params) -> tuple[Field, ...]:
    vehicle = _vehicle(params)
    others = range(params.encounter.intruders)
    each = [dataclasses.replace(f, name=f"vehicle_{k}.{f.name}") for k in others for f in vehicle]
    return (*_OWN, *each, *_lanes(params))


def _vehicle(params: Params) -> list[Field]:
    """Those of one vehicle."""
    return _RADIO + _MESSAGE + ([] if params.interface.information == "ranges" else _POSITION)


def _lanes(params: Params) -> list[Field]:
    """Those of the lanes, which need positions."""
    return [] if params.interface.information == "ranges" else lane_fields.table()


def split(observation: np.ndarray, params: Params) -> dict[str, np.ndarray]:
    """Undo the scaling: name -> values in SI units, own fields and lanes' (...), those of the vehicles (..., K).

    Raises
    ------
    ValueError
        If the last axis has not the length that the parameters imply.
    """
    table = fields(params)
    values = np.asarray(observation, dtype=np.float64)
    if values.ndim == 0 or values.shape[-1] != len(table):
        raise ValueError(f"observation has shape {values.shape}; the last axis must be {len(table)} here")
    values = restored(values, table)
    own, vehicle = len(_OWN), _vehicle(params)
    end = own + len(vehicle) * params.encounter.intruders
    seen = {f.name: values[..., i] for i, f in enumerate(table) if not own <= i < end}
    return seen | {f.name: values[..., own + i : end : len(vehicle)] for i, f in enumerate(vehicle)}


class Writer:
    """Writes observations of one set of parameters; without `radio` the vehicles' fields stay zero."""

    def __init__(self, params: Params, radio: bool) -> None:
        table = fields(params)
        self.low = np.array([f.low for f in table], np.float32)
        self.high = np.array([f.high for f in table], np.float32)
        self._transforms = transforms(table)
        self._names, self._lanes = [f.name for f in _vehicle(params)], len(_lanes(params))
        self._count = params.encounter.intruders if radio else 0

    def write(
        self, known: dict[str, float], along: tuple[float, float], own: np.ndarray, others: np.ndarray
    ) -> np.ndarray:
        """The observation.

        Parameters
        ----------
        known : dict
            The own fields by name, but for `solution_std_m`.
        along : tuple of float
            Unit vector along the agent's lane.
        own, others : arrays of OWN (1,) and OTHER (n,)
            As sensed, nearest first.

        Returns
        -------
        (d,) float32 array
        """
        raw, out = np.zeros(len(self._transforms)), np.empty(len(self._transforms), np.float32)
        known = {**known, "solution_std_m": own["std_m"][0]}
        raw[: len(_OWN)] = [known[f.name] for f in _OWN]
        seen = others[: self._count]
        if len(seen):
            values = heard(along, own, seen)
            end = len(_OWN) + len(self._names) * len(seen)
            raw[len(_OWN) : end].reshape(len(seen), -1).T[:] = [values[name] for name in self._names]
            if self._lanes:
                raw[-self._lanes :] = lane_fields.values(values, known["lane_offset_m"])
        transform(raw, self._transforms, out)
        return out


def heard(along: tuple[float, float], own: np.ndarray, seen: np.ndarray) -> dict[str, np.ndarray]:
    """Raw values (n,) of the fields of vehicles that are heard, by name."""
    held = seen["valid"]
    values = {f.name: seen[f.name] for f in _RADIO if f.name in (seen.dtype.names or ())}
    values |= {"zone_radius_m": seen["radius_m"], "margin_m": seen["range_m"] - seen["radius_m"]}
    values |= {"message_valid": held, "message_age_s": seen["age_s"] * held, "message_std_m": seen["std_m"] * held}
    for name, unit in (("position_m", "m"), ("velocity_mps", "mps")):
        x, y = ((seen[name] - own[name]) * held[:, None])[:, :2].T
        values[f"relative_along_{unit}"] = x * along[0] + y * along[1]
        values[f"relative_right_{unit}"] = y * along[0] - x * along[1]
    return values
