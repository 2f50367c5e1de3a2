"""Sensed -> observation: a flat float32 vector of named, scaled, clipped fields, in the axes of the current leg.

`fields(params)` is the table of them; `write` fills a row in the same order; `split` undoes it. The axes are along
the leg, to the right of it, and up; planar worlds have no `up` fields, track `range` no positions.
"""

from dataclasses import dataclass

import numpy as np

from rss_gym.jit import inner, kernel
from rss_gym.params import Params
from rss_gym.physics.motion import clip

LIMIT = 3.0  # scaled values are clipped to this
OFFSET_M, FAR_M, SPEED_MPS, CLOSING_MPS, STD_M = 30.0, 120.0, 5.0, 10.0, 60.0
NOISE_DB, FACTOR, FLIGHT_S, TURN_S, AGE_S = 10.0, 4.0, 60.0, 20.0, 10.0


@dataclass(frozen=True, slots=True)
class Field:
    """One column of the observation.

    Parameters
    ----------
    name : str
        With the unit; the fields of intruder k are prefixed `intruder_k.`.
    unit : str
        SI unit; 1 for ratios and flags.
    scale : float
        The column is the value divided by this, clipped to [low, high].
    low, high : float
        Bounds of the scaled column.
    meaning : str
        What it is and where it comes from.
    """

    name: str
    unit: str
    scale: float
    low: float
    high: float
    meaning: str


def _vector(name: tuple[str, str], unit: str, scale: float, meaning: str) -> list[Field]:
    stem, suffix = name
    return [Field(f"{stem}_{axis}_{suffix}", unit, scale, -LIMIT, LIMIT, meaning) for axis in ("along", "right", "up")]


_OWN = [
    *_vector(("track_error", "m"), "m", OFFSET_M, "own solution minus predefined trajectory"),
    *_vector(("way_point", "m"), "m", OFFSET_M, "commanded way point minus predefined trajectory"),
    *_vector(("velocity", "mps"), "m/s", SPEED_MPS, "own velocity, own solution"),
    Field("cruise_mps", "m/s", SPEED_MPS, 0.0, LIMIT, "speed of the predefined trajectory"),
    # Not a share of the flight's length, which would tell the time of the closest approach without the radio.
    Field("time_s", "s", FLIGHT_S, 0.0, LIMIT, "time flown"),
    Field("turn_in_s", "s", TURN_S, 0.0, LIMIT, "time to the next turn of the predefined trajectory, or the limit"),
    Field("turn_cos", "1", 1.0, -1.0, 1.0, "cosine of that turn, 1 without one"),
    Field("turn_sin", "1", 1.0, -1.0, 1.0, "sine of that turn, positive to the right"),
]
_RADIO = [
    Field("present", "1", 1.0, 0.0, 1.0, "1 if this intruder exists; the row is zero otherwise"),
    Field("range_m", "m", FAR_M, 0.0, LIMIT, "estimated range"),
    Field("range_std_m", "m", STD_M, 0.0, LIMIT, "its standard deviation according to the filter"),
    Field("coloured_db", "dB", NOISE_DB, -LIMIT, LIMIT, "estimated coloured noise of the link"),
    Field("path_loss_factor", "1", FACTOR, 0.0, LIMIT, "path loss factor that the filter holds"),
    Field("range_rate_mps", "m/s", CLOSING_MPS, -LIMIT, LIMIT, "smoothed rate of the estimated range"),
    Field("zone_radius_m", "m", FAR_M, 0.0, LIMIT, "radius S of the safety zone in force"),
    Field("margin_m", "m", FAR_M, -LIMIT, LIMIT, "estimated range minus zone radius"),
    Field("warning", "1", 1.0, 0.0, 1.0, "1 while the warning is open"),
    Field("streak", "1", 1.0, 0.0, 1.0, "consecutive ticks inside the zone over n_d"),
    Field("message_valid", "1", 1.0, 0.0, 1.0, "1 once a message is held"),
    Field("message_age_s", "s", AGE_S, 0.0, LIMIT, "age of the held message"),
]
_VELOCITY = _vector(("message_velocity", "mps"), "m/s", SPEED_MPS, "intruder's velocity, its own solution")
_POSITION = [
    *_vector(("message_position", "m"), "m", FAR_M, "intruder's announced position minus own solution"),
    *_vector(("message_way_point", "m"), "m", FAR_M, "intruder's announced next way point minus own solution"),
]


def fields(params: Params) -> list[Field]:
    """The columns of the observation in a world of these parameters, in order."""
    own, radio, planar = _OWN, _RADIO + _VELOCITY, params.encounter.planar
    if params.interface.track != "range":
        radio = radio + _POSITION
    columns = list(own)
    for k in range(params.encounter.intruders):
        columns += [Field(f"intruder_{k}.{f.name}", f.unit, f.scale, f.low, f.high, f.meaning) for f in radio]
    return [f for f in columns if not (planar and "_up_" in f.name)]


def split(observation: np.ndarray, params: Params) -> dict[str, np.ndarray]:
    """Undo the scaling: name -> values in SI units.

    Parameters
    ----------
    observation : (..., d) array
        One observation or a batch.
    params : Params
        The world it comes from.

    Returns
    -------
    dict
        Own fields by name, shape (...); intruder fields by their bare name, shape (..., K).

    Raises
    ------
    ValueError
        If the last axis has not the length that the parameters imply.
    """
    table = fields(params)
    values = np.asarray(observation, dtype=np.float64)
    if values.ndim == 0 or values.shape[-1] != len(table):
        raise ValueError(
            f"observation has shape {values.shape}; the last axis must be {len(table)} for these parameters"
        )
    values = values * np.array([f.scale for f in table])
    columns: dict[str, list[int]] = {}
    for index, f in enumerate(table):
        columns.setdefault(f.name.partition(".")[2] or f.name, []).append(index)
    return {name: values[..., at] if "." in table[at[0]].name else values[..., at[0]] for name, at in columns.items()}


def bounds(params: Params) -> tuple[np.ndarray, np.ndarray]:
    """Low and high of the Box, float32, shape (d,)."""
    table = fields(params)
    return np.array([f.low for f in table], np.float32), np.array([f.high for f in table], np.float32)


@inner
def put(out, at, value, scale, low):
    """Write one scaled, clipped value; returns the next column."""
    out[at] = np.float32(clip(value / scale, low, LIMIT))
    return at + 1


@inner
def skip(out, at, columns):
    """Write zeros."""
    for column in range(at, at + columns):
        out[column] = np.float32(0.0)
    return at + columns


@inner
def put_vector(out, at, x, y, z, along, scale, planar):
    """Write a vector in the axes of the leg."""
    at = put(out, at, x * along[0] + y * along[1], scale, -LIMIT)
    at = put(out, at, x * along[1] - y * along[0], scale, -LIMIT)
    return at if planar else put(out, at, z, scale, -LIMIT)


@inner
def put_difference(out, at, to, start, along, scale, planar):
    """Write the vector from `start` to `to` in the axes of the leg."""
    return put_vector(out, at, to[0] - start[0], to[1] - start[1], to[2] - start[2], along, scale, planar)


@kernel
def write(own, others, planar, positions, out):
    """Write the observation of one row into `out` (d,), in the order of `fields`."""
    along, at = own.along, np.int64(0)  # a literal would compile the writers twice
    at = put_difference(out, at, own.position_m, own.planned_m, along, OFFSET_M, planar)
    at = put_difference(out, at, own.way_point_m, own.planned_m, along, OFFSET_M, planar)
    v, turn = own.velocity_mps, own.turn_along
    at = put_vector(out, at, v[0], v[1], v[2], along, SPEED_MPS, planar)
    v = own.planned_mps
    at = put(out, at, v[0] * along[0] + v[1] * along[1], SPEED_MPS, 0.0)
    at = put(out, at, own.time_s, FLIGHT_S, 0.0)
    at = put(out, at, own.turn_in_s, TURN_S, 0.0)
    at = put(out, at, clip(along[0] * turn[0] + along[1] * turn[1], -1.0, 1.0), 1.0, -1.0)
    at = put(out, at, clip(along[1] * turn[0] - along[0] * turn[1], -1.0, 1.0), 1.0, -1.0)
    width = (len(out) - at) // len(others)
    for k in range(len(others)):
        other = others[k]
        if not other.present:
            at = skip(out, at, width)
            continue
        at = put(out, at, 1.0, 1.0, 0.0)
        at = put(out, at, other.range_m, FAR_M, 0.0)
        at = put(out, at, other.range_std_m, STD_M, 0.0)
        at = put(out, at, other.coloured_db, NOISE_DB, -LIMIT)
        at = put(out, at, other.path_loss_factor, FACTOR, 0.0)
        at = put(out, at, other.range_rate_mps, CLOSING_MPS, -LIMIT)
        at = put(out, at, other.radius_m, FAR_M, 0.0)
        at = put(out, at, other.range_m - other.radius_m, FAR_M, -LIMIT)
        at = put(out, at, 1.0 if other.warning else 0.0, 1.0, 0.0)
        at = put(out, at, other.streak, 1.0, 0.0)
        at = put(out, at, 1.0 if other.valid else 0.0, 1.0, 0.0)
        if not other.valid:
            at = skip(out, at, width - 11)
            continue
        at = put(out, at, other.age_s, AGE_S, 0.0)
        v = other.velocity_mps
        at = put_vector(out, at, v[0], v[1], v[2], along, SPEED_MPS, planar)
        if positions:
            at = put_difference(out, at, other.position_m, own.position_m, along, FAR_M, planar)
            at = put_difference(out, at, other.way_point_m, own.position_m, along, FAR_M, planar)
