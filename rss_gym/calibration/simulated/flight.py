"""A flight like those that logs are made of: on the ground, out and back about a station, on the ground again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rss_gym.checks import Floats, positive, whole
from rss_gym.params import ParamsError
from rss_gym.radio import simulate
from rss_gym.radio.path_loss import AnyChannel

HOME = (47.0, 8.0, 400.0)  # latitude, longitude in degrees, altitude in m
START_S = 1_714_060_800.0  # the time of the first row, since 1970: 2024-04-25T16:00:00Z
GROUND_S = 20.0  # before and after
REACH_M, HEIGHTS_M, SPEEDS_MPS, CLIMB_MPS = 90.0, (12.0, 30.0), (2.0, 5.0), 1.5
_SMOOTH_S = 3.0
_STAND_M = 2.0  # from the antenna to where the aircraft stands
METRES_A_DEGREE = 111_198.0  # of latitude at HOME


@dataclass(frozen=True, eq=False)
class SimulatedFlight:
    """What every format is written from.

    Attributes
    ----------
    time_s : (n,) array
        From 0, at the RSS' rate.
    position_m, velocity_mps : (n, 3) arrays
        East, north, up of the antenna on the ground, and their rates.
    distance_m : (n,) array
        True length of the link.
    rss_dbm : (2, n) array
        At the ground and at the aircraft; NaN where lost.
    armed : (n,) array of bool
        Whether the motors run.
    """

    time_s: Floats
    position_m: Floats
    velocity_mps: Floats
    distance_m: Floats
    rss_dbm: Floats
    armed: Any

    @property
    def flying(self) -> Any:
        """(n,) whether each sample is off the ground."""
        return self.position_m[:, 2] > 2.0

    @property
    def latitude(self) -> Floats:
        """(n,) degrees."""
        return HOME[0] + self.position_m[:, 1] / METRES_A_DEGREE

    @property
    def longitude(self) -> Floats:
        """(n,) degrees."""
        return HOME[1] + self.position_m[:, 0] / (_METRES_EAST)

    @property
    def altitude_m(self) -> Floats:
        """(n,) above the sea."""
        return HOME[2] + self.position_m[:, 2]


_METRES_EAST = 76_062.0  # a degree of longitude at HOME


def fly(
    channel: AnyChannel = "outdoor", seconds: float = 300.0, rate_hz: float = 5.0, seed: int = 0
) -> SimulatedFlight:
    """Fly a path drawn by the seed, and what both ends of its radio link receive.

    Parameters
    ----------
    channel : Channel, str, path or dict
        As `rss_gym.params.load_channel` takes it.
    seconds : float
        In the air, 30 to 36,000.
    rate_hz : float
        Samples of the RSS, 0.1 to 100.
    seed : int
        The seed of the path and the noise.

    Raises
    ------
    ParamsError
        For numbers out of range, or what is not a channel.
    """
    seconds, rate_hz = positive("seconds", seconds, high=36_000.0), positive("rate", rate_hz, high=100.0)
    seed = whole("seed", seed, 2**31)
    if seconds < 30.0 or rate_hz < 0.1:
        raise ParamsError(f"a log needs 30 s and 0.1 Hz at least, got {seconds:g} s and {rate_hz:g} Hz")
    time_s = np.arange(0.0, seconds + 2.0 * GROUND_S, 1.0 / rate_hz)
    position = _path(time_s, seconds, np.random.default_rng(seed))
    velocity = np.gradient(position, time_s, axis=0)
    distance = np.linalg.norm(position, axis=1)
    log = simulate(np.tile(distance, (2, 1)), 1.0 / rate_hz, channel, seed=seed)
    armed = (time_s >= GROUND_S - 5.0) & (time_s <= time_s[-1] - GROUND_S + 5.0)
    return SimulatedFlight(time_s, position, velocity, distance, log.rss_dbm, armed)


def _path(time_s: Floats, seconds: float, random: np.random.Generator) -> Floats:
    """(n, 3): legs between random places within reach at random speeds, smoothed over 3 s."""
    fine_s = np.arange(0.0, time_s[-1] + 0.1, 0.1)
    places, times = [np.array([_STAND_M, 0.0, 0.0])], [GROUND_S]
    while times[-1] < GROUND_S + seconds:
        # Near and far alike: legs out and back, not the middle of a disc.
        bearing, reach = random.uniform(0.0, 2.0 * np.pi), REACH_M * random.uniform(0.1, 1.0)
        place = np.array([reach * np.sin(bearing), reach * np.cos(bearing), random.uniform(*HEIGHTS_M)])
        way = place - places[-1]
        duration = max(np.linalg.norm(way[:2]) / random.uniform(*SPEEDS_MPS), abs(way[2]) / CLIMB_MPS, 1.0)
        places.append(place)
        times.append(times[-1] + float(duration))
    home_s = GROUND_S + seconds
    legs = np.array(places)
    path = np.column_stack([np.interp(fine_s, times, legs[:, k]) for k in range(3)])
    # It comes back in the last fifth, at most 20 s a leg above its speed's limit, and lands.
    back = np.clip((home_s - fine_s) / max(0.2 * seconds, 25.0), 0.0, 1.0)[:, None]
    path = places[0] + (path - places[0]) * np.where(fine_s[:, None] < GROUND_S, 0.0, back)
    window = np.hanning(round(_SMOOTH_S / 0.1) + 2)[1:-1]
    padded = np.pad(path, ((len(window), len(window)), (0, 0)), mode="edge")
    smooth = np.column_stack([np.convolve(padded[:, k], window / window.sum(), "same") for k in range(3)])
    smooth = smooth[len(window) : -len(window)]
    found: Floats = np.column_stack([np.interp(time_s, fine_s, smooth[:, k]) for k in range(3)])
    return found
