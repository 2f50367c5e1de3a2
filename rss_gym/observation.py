"""Sensed and tracks -> observation: a flat float32 vector of named fields, in the axes of the current leg.

`fields(params)` is the table of them. `write` writes their raw SI values in the order of the table, `transform` scales,
clips or stretches them as the table says, and `split` goes back to SI. The axes are along the leg, to the right of it,
and up; planar worlds have no `up` fields, information `ranges` no announced positions.
"""

from dataclasses import dataclass
from math import sqrt

import numpy as np

from rss_gym.jit import inner, kernel
from rss_gym.params import Params
from rss_gym.tracking.approach import closest

LIMIT = 3.0  # scaled values are clipped to this
AHEAD_M, FAR_M, SPEED_MPS, CLOSING_MPS, STD_M, ACCURACY_M = 30.0, 120.0, 5.0, 10.0, 60.0, 15.0
NOISE_DB, FACTOR, TIME_S, AGE_S = 10.0, 4.0, 20.0, 10.0
# Half of what a stretched distance can say is said within this. Scaled linearly the offsets are too small where nearly
# all flights are, and clipped where few come back from: after 1 M decisions PPO costs 21.0 and 30.9 m by seed, and 13.5
# and 26.3 m with the offsets stretched.
NEAR_M, OFFSET_M = 10.0, 20.0


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
        Bounds of the column.
    meaning : str
        What it is and where it comes from.
    stretch : float
        If above 0 the column is x / (|x| + stretch) in place of that: small values far apart, none clipped.
    """

    name: str
    unit: str
    scale: float
    low: float
    high: float
    meaning: str
    stretch: float = 0.0


def _vector(stem: str, unit: str, scale: float, meaning: str, suffix: str = "m") -> list[Field]:
    names = [f"{stem}_{axis}_{suffix}" for axis in ("along", "right", "up")]
    return [Field(name, unit, scale, -LIMIT, LIMIT, meaning) for name in names]


def _stretched(stem: str, stretch: float, meaning: str) -> list[Field]:
    names = [f"{stem}_{axis}_m" for axis in ("along", "right", "up")]
    return [Field(name, "m", 1.0, -1.0, 1.0, meaning, stretch) for name in names]


def _approach(way: str, meaning: str) -> list[Field]:
    return [
        Field(f"{way}_time_s", "s", TIME_S, 0.0, LIMIT, f"time to the closest approach by the track, {meaning}"),
        *_stretched(f"{way}_miss", NEAR_M, "where the intruder is then"),
        Field(f"{way}_distance_m", "m", 1.0, 0.0, 1.0, "how far away it is then", NEAR_M),
    ]


_OWN = [
    *_stretched("way_point", OFFSET_M, "commanded way point minus predefined trajectory"),
    *_stretched("offset", OFFSET_M, "own solution minus predefined trajectory"),
    *_vector("velocity", "m/s", SPEED_MPS, "own velocity, own solution", "mps"),
    Field("cruise_mps", "m/s", SPEED_MPS, 0.0, LIMIT, "speed of the predefined trajectory"),
    *_vector("ahead", "m", AHEAD_M, "predefined trajectory `announce_s` later minus now")[:2],
    Field("solution_std_m", "m", ACCURACY_M, 0.0, LIMIT, "standard deviation of the own solution, per axis"),
]
_RADIO = [
    Field("present", "1", 1.0, 0.0, 1.0, "1 if this intruder exists; the row is zero otherwise"),
    Field("range_m", "m", FAR_M, 0.0, LIMIT, "estimated range"),
    Field("range_std_m", "m", STD_M, 0.0, LIMIT, "its standard deviation according to the filter"),
    Field("range_rate_mps", "m/s", CLOSING_MPS, -LIMIT, LIMIT, "smoothed rate of the estimated range"),
    Field("coloured_db", "dB", NOISE_DB, -LIMIT, LIMIT, "estimated coloured noise of the link"),
    Field("path_loss_factor", "1", FACTOR, 0.0, LIMIT, "path loss factor that the filter holds"),
    Field("white_std_db", "dB", NOISE_DB, 0.0, LIMIT, "standard deviation of the white noise that it holds"),
    Field("coloured_std_db", "dB", NOISE_DB, 0.0, LIMIT, "that of the coloured noise"),
    Field("coloured_tc_s", "s", AGE_S, 0.0, LIMIT, "correlation time of the coloured noise"),
    Field("zone_radius_m", "m", FAR_M, 0.0, LIMIT, "radius S of the safety zone in force"),
    Field("margin_m", "m", FAR_M, -LIMIT, LIMIT, "estimated range minus zone radius"),
    Field("warning", "1", 1.0, 0.0, 1.0, "1 while the warning is open"),
    Field("consecutive_warnings", "1", 1.0, 0.0, 1.0, "consecutive ticks inside the zone over n_d"),
]
_MESSAGE = [
    Field("message_valid", "1", 1.0, 0.0, 1.0, "1 once a message is held; its fields and the track's are zero before"),
    Field("message_age_s", "s", AGE_S, 0.0, LIMIT, "time since the held message was sent"),
    *_vector("message_velocity", "m/s", SPEED_MPS, "intruder's velocity, its own solution", "mps"),
]
_POSITION = [
    *_vector("message_position", "m", FAR_M, "intruder's announced position minus own solution"),
    *_vector("message_way_point", "m", FAR_M, "intruder's announced next way point minus own solution"),
    Field("message_std_m", "m", ACCURACY_M, 0.0, LIMIT, "accuracy of its position that the intruder states, per axis"),
]
_TRACK = [
    Field("track_valid", "1", 1.0, 0.0, 1.0, "1 once there is a track"),
    *_vector("track_position", "m", FAR_M, "track: intruder's position relative to the own"),
    *_vector("track_velocity", "m/s", CLOSING_MPS, "track: intruder's velocity relative to the own", "mps"),
    Field("track_std_along_m", "m", ACCURACY_M, 0.0, LIMIT, "track: standard deviation along the bearing"),
    Field("track_std_across_m", "m", ACCURACY_M, 0.0, LIMIT, "track: standard deviation across the bearing, level"),
    Field("track_std_up_m", "m", ACCURACY_M, 0.0, LIMIT, "track: standard deviation of the height"),
]
_SIDES = [
    Field("side_probability", "1", 1.0, 0.0, 1.0, "probability of the side of the relative velocity the track is on"),
    *_vector("other_position", "m", FAR_M, "where the intruder is if it is on the other side")[:2],
]
_APPROACH = [
    *_approach("flown", "the own velocity staying as it is"),
    *_approach("planned", "the agent flying its predefined trajectory"),
]


def fields(params: Params) -> list[Field]:
    """The columns of the observation in a world of these parameters, in order."""
    ranges = params.interface.information == "ranges"
    intruder = _RADIO + _MESSAGE + ([] if ranges else _POSITION) + _TRACK + (_SIDES if ranges else []) + _APPROACH
    # By dead reckoning the accuracy of the own solution would tell the flight's clock.
    columns = _OWN[:-1] if ranges else list(_OWN)
    for k in range(params.encounter.intruders):
        columns += [
            Field(f"intruder_{k}.{f.name}", f.unit, f.scale, f.low, f.high, f.meaning, f.stretch) for f in intruder
        ]
    return [f for f in columns if not (params.encounter.planar and "_up_" in f.name)]


def split(observation: np.ndarray, params: Params) -> dict[str, np.ndarray]:
    """Split observations into their fields: name -> values in SI units.

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
    values = restored(values, table)
    columns: dict[str, list[int]] = {}
    for index, f in enumerate(table):
        columns.setdefault(f.name.partition(".")[2] or f.name, []).append(index)
    return {name: values[..., at] if "." in table[at[0]].name else values[..., at[0]] for name, at in columns.items()}


def restored(values: np.ndarray, table: list[Field]) -> np.ndarray:
    """Columns of the observation as SI values, what was clipped excepted. Shape as `values` (..., d)."""
    scale, stretch, _, _ = transforms(table).T
    share = np.where(stretch > 0.0, np.minimum(np.abs(values), 1.0 - 2.0**-24), 0.0)  # the largest float32 below 1
    return values * scale / (1.0 - share)


def bounds(params: Params) -> tuple[np.ndarray, np.ndarray]:
    """Low and high of the Box, float32, shape (d,)."""
    table = fields(params)
    return np.array([f.low for f in table], np.float32), np.array([f.high for f in table], np.float32)


def transforms(table: list[Field]) -> np.ndarray:
    """Of each column a, b, low and high, for `transform`: clip(x / (a + b |x|), low, high). Shape (d, 4)."""
    return np.array([[f.stretch or f.scale, float(f.stretch > 0.0), f.low, f.high] for f in table])


@kernel(forceinline=True)
def transform(raw, table, out):
    """SI values `raw` (d,) -> columns `out` (d,) float32, each scaled and clipped, or stretched, as `table` says."""
    for column in range(len(out)):
        x = raw[column]
        y = x / (table[column, 0] + table[column, 1] * abs(x))
        out[column] = np.float32(min(max(y, table[column, 2]), table[column, 3]))


@inner
def put_vector(out, at, x, y, z, along, planar):
    """Write a vector in the axes of the leg into `out` (d,) from column `at` on. Returns the next column."""
    out[at] = x * along[0] + y * along[1]
    out[at + 1] = x * along[1] - y * along[0]
    if planar:
        return at + 2
    out[at + 2] = z
    return at + 3


@inner
def put_difference(out, at, to, start, along, planar):
    """Write the vector from `start` to `to` in the axes of the leg."""
    return put_vector(out, at, to[0] - start[0], to[1] - start[1], to[2] - start[2], along, planar)


@inner
def put_approach(out, at, x, y, z, vx, vy, vz, along, planar):
    """Write time, miss vector and distance of the closest approach of straight relative flight."""
    time_s, x, y, z = closest(x, y, z, vx, vy, vz)
    out[at] = time_s
    at = put_vector(out, at + 1, x, y, z, along, planar)
    out[at] = sqrt(x * x + y * y + z * z)
    return at + 1


@inner
def put_own(own, planar, positions, out):
    """Write what the agent knows of itself; the accuracy of its position where positions are exchanged."""
    along, at = own.along, np.int64(0)  # a literal would compile the writers twice
    at = put_difference(out, at, own.way_point_m, own.planned_m, along, planar)
    at = put_difference(out, at, own.position_m, own.planned_m, along, planar)
    v = own.velocity_mps
    at = put_vector(out, at, v[0], v[1], v[2], along, planar)
    v = own.planned_mps
    out[at] = v[0] * along[0] + v[1] * along[1]
    at = put_vector(out, at + 1, own.ahead_m[0], own.ahead_m[1], 0.0, along, True)
    if positions:
        out[at] = own.std_m
        at += 1
    return at


@inner
def put_radio(other, out, at):
    """Write the filter's estimate, what it holds of the radio, and the zone: 13 columns."""
    out[at], out[at + 1], out[at + 2], out[at + 3] = 1.0, other.range_m, other.range_std_m, other.range_rate_mps
    out[at + 4], out[at + 5] = other.coloured_db, other.path_loss_factor
    out[at + 6], out[at + 7], out[at + 8] = other.white_std_db, other.coloured_std_db, other.coloured_tc_s
    out[at + 9], out[at + 10] = other.radius_m, other.range_m - other.radius_m
    out[at + 11], out[at + 12] = 1.0 if other.warning else 0.0, other.consecutive_warnings
    return at + 13


@inner
def put_message(own, other, planar, positions, out, at):
    """Write the message held: age (s), velocity (m/s) and, with `positions`, position, way point and accuracy (m)."""
    along, v = own.along, other.velocity_mps
    out[at], out[at + 1] = 1.0, other.age_s
    at = put_vector(out, at + 2, v[0], v[1], v[2], along, planar)
    if positions:
        at = put_difference(out, at, other.position_m, own.position_m, along, planar)
        at = put_difference(out, at, other.way_point_m, own.position_m, along, planar)
        out[at] = other.std_m
        at += 1
    return at


@inner
def put_track(own, track, planar, positions, out, at):
    """Write the track, and the closest approaches that it predicts."""
    along, p, v = own.along, track.position_m, track.velocity_mps
    out[at] = 1.0
    at = put_vector(out, at + 1, p[0], p[1], p[2], along, planar)
    at = put_vector(out, at, v[0], v[1], v[2], along, planar)
    bx, by = p[0], p[1]
    level = sqrt(bx * bx + by * by)
    bx, by = (bx / level, by / level) if level > 1e-9 else (1.0, 0.0)
    out[at] = sqrt(max(bx * bx * track.xx + 2.0 * bx * by * track.xy + by * by * track.yy, 0.0))
    out[at + 1] = sqrt(max(by * by * track.xx - 2.0 * bx * by * track.xy + bx * bx * track.yy, 0.0))
    at += 2
    if not planar:
        out[at] = sqrt(track.zz)
        at += 1
    if not positions:
        out[at] = track.side_probability
        at = put_vector(out, at + 1, track.other_m[0], track.other_m[1], 0.0, along, True)
    at = put_approach(out, at, p[0], p[1], p[2], v[0], v[1], v[2], along, planar)
    # On its plan the agent is displaced by minus the displacement of its way point, which it knows exactly and
    # which its autopilot follows, and flies the planned velocity.
    o, w, ov, wv = own.way_point_m, own.planned_m, own.velocity_mps, own.planned_mps
    return put_approach(
        out, at, p[0] + o[0] - w[0], p[1] + o[1] - w[1], p[2] + o[2] - w[2],
        v[0] + ov[0] - wv[0], v[1] + ov[1] - wv[1], v[2] + ov[2] - wv[2], along, planar,
    )  # fmt: skip


@kernel
def write(own, others, tracks, planar, positions, raw):
    """Write the SI values of one row's observation into `raw` (d,), in the order of `fields`.

    `own` is a record of OWN, `others` (K,) of OTHER and `tracks` (K,) of TRACK.
    """
    at = put_own(own, planar, positions, raw)
    raw[at:] = 0.0
    axes = 2 if planar else 3
    width = (len(raw) - at) // len(others)
    message = 2 + axes + (2 * axes + 1 if positions else 0)
    for k in range(len(others)):
        here = at + k * width
        if not others[k].present:
            continue
        here = put_radio(others[k], raw, here)
        if others[k].valid:
            put_message(own, others[k], planar, positions, raw, here)
        if tracks[k].valid:
            put_track(own, tracks[k], planar, positions, raw, here + message)
