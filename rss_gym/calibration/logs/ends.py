"""From the positions and velocities of both ends of a link to its length and rate."""

from __future__ import annotations

import numpy as np

from rss_gym.calibration.logs.geodesy import east_north_up_m, range_rate_mps
from rss_gym.calibration.logs.record import Floats

_SURE = 0.2  # correlation from which a sign is told
AIRCRAFT_MPS = 150.0
NOWHERE_DEG = 0.01  # a receiver without a fix reports 0, 0, or next to it


def relative_m(first: Floats, second: Floats, is_global: bool) -> Floats:
    """(n, 3) from `second` to `first`; global positions in degrees and metres become east, north, up."""
    return east_north_up_m(first, second) if is_global else first - second


def rate_mps(relative: Floats, velocity: Floats) -> Floats:
    """(n,) range rate; 0 where both ends are in one place."""
    apart = np.linalg.norm(relative, axis=1) > 0.0
    rate = np.zeros(len(relative))
    rate[apart] = range_rate_mps(relative[apart], velocity[apart])
    return rate


def agreement(time_s: Floats, value: Floats, rate: Floats) -> float:
    """Correlation of a logged rate with the change of what it is the rate of, in [-1, 1]; 0 where nothing moves.

    Both are summed over about a second, so that single steps of a rounded value count little.
    """
    good = np.isfinite(time_s) & np.isfinite(value) & np.isfinite(rate)
    time_s, value, rate = time_s[good], value[good], rate[good]
    if time_s.size < 3:
        return 0.0
    order = np.argsort(time_s, kind="stable")
    time_s, value, rate = time_s[order], value[order], rate[order]
    interval_s = max(float(np.median(np.diff(time_s))), 1e-6)
    stride = max(1, min(round(1.0 / interval_s), time_s.size // 3))
    steps = np.diff(time_s)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * steps)])
    expected, seen = way[stride:] - way[:-stride], value[stride:] - value[:-stride]
    near = time_s[stride:] - time_s[:-stride] < 5.0 * stride * interval_s
    expected, seen = expected[near], seen[near]
    norm = float(np.linalg.norm(expected) * np.linalg.norm(seen))
    return float(expected @ seen) / norm if norm > 0.0 else 0.0


def sign(time_s: Floats, value: Floats, rate: Floats) -> float:
    """-1 where the logged rate runs against the change of the value, else 1."""
    return -1.0 if agreement(time_s, value, rate) < -_SURE else 1.0


def known_places(latitude: Floats, longitude: Floats, altitude_m: Floats) -> np.ndarray:
    """Whether a place can be one: finite, on the globe, and not beside 0, 0, where receivers without a fix are."""
    finite = np.isfinite(latitude) & np.isfinite(longitude) & np.isfinite(altitude_m)
    on_globe = (np.abs(latitude) <= 90.0) & (np.abs(longitude) <= 360.0) & (np.abs(altitude_m) <= 1e5)
    fixed = (np.abs(latitude) > NOWHERE_DEG) | (np.abs(longitude) > NOWHERE_DEG)
    known: np.ndarray = finite & on_globe & fixed
    return known


def jumps(time_s: Floats, place_m: Floats) -> np.ndarray:
    """Whether a position is one that an aircraft cannot have reached from either neighbour, nor left to it."""
    steps = np.linalg.norm(np.diff(place_m, axis=0), axis=1)
    span = np.maximum(np.diff(time_s), 1e-3)
    fast = steps > AIRCRAFT_MPS * np.maximum(span, 0.05) + 5.0
    before, after = np.concatenate([[True], fast]), np.concatenate([fast, [True]])
    wrong: np.ndarray = before & after
    if place_m.shape[0] < 3:
        wrong[:] = False
    else:  # at an end one fast step is enough only if the next two points agree with each other
        wrong[0] = bool(fast[0] and not fast[1])
        wrong[-1] = bool(fast[-1] and not fast[-2])
    return wrong
