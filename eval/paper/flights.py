"""Flights like those of Sec. VIII-A: out from the ground antenna and back, in four directions at three altitudes."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, hypot, radians, sin, sqrt

import numpy as np
from numpy.typing import NDArray

PERIOD_S = 0.1  # the paper's update rate of 10 Hz
REACH_M = 58.0  # the paper's flights stay within 60 m of the antenna
NEAR_M = 3.0  # on the ground, from the antenna to where a flight begins
SPEEDS_MPS = 2.0, 5.0  # slowest and fastest cruise
ACCELERATION_MPS2 = 1.0
HOVER_S = 4.0  # at the beginning, at the turn and at the end

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class PaperFlight:
    """One flight, the antenna at the origin: axes north, east, up."""

    name: str
    time_s: Floats  # (n,)
    position_m: Floats  # (n, 3)

    @property
    def distance_m(self) -> Floats:
        """(n,): length of the link."""
        return np.linalg.norm(self.position_m, axis=1)

    @property
    def speed_mps(self) -> Floats:
        """(n,): mean over the interval that ends at the sample."""
        way = np.linalg.norm(np.diff(self.position_m, axis=0, prepend=self.position_m[:1]), axis=1)
        return way / PERIOD_S

    @property
    def range_rate_mps(self) -> Floats:
        """(n,): change of the distance over the interval that ends at the sample, over its length."""
        return np.diff(self.distance_m, prepend=self.distance_m[0]) / PERIOD_S

    @property
    def line_of_sight(self) -> Floats:
        """(n, 3): unit vectors from the antenna."""
        return self.position_m / self.distance_m[:, None]


def paper_flights(pace: float = 1.0) -> tuple[PaperFlight, ...]:
    """The twelve flights: north, east, south and west at 10, 20 and 30 m, cruising at 2 to 5 m/s times `pace`."""
    names = ("north", "east", "south", "west")
    speeds = np.linspace(*SPEEDS_MPS, 12).reshape(3, 4)
    return tuple(
        _flight(f"{name}, {altitude:g} m", 90.0 * k, altitude, speed, pace)
        for altitude, row in zip((10.0, 20.0, 30.0), speeds, strict=True)
        for k, (name, speed) in enumerate(zip(names, row, strict=True))
    )


def tuning_flights(pace: float = 1.0) -> tuple[PaperFlight, ...]:
    """Eight others, on which the filters are tuned: the directions between, at 15 and 25 m, other speeds."""
    speeds = np.linspace(2.2, 4.8, 8).reshape(2, 4)
    return tuple(
        _flight(f"{45 + 90 * k}°, {altitude:g} m", 45.0 + 90.0 * k, altitude, speed, pace)
        for altitude, row in zip((15.0, 25.0), speeds, strict=True)
        for k, speed in enumerate(row)
    )


def _flight(name: str, bearing_deg: float, altitude_m: float, cruise_mps: float, pace: float) -> PaperFlight:
    reach = sqrt(REACH_M**2 - altitude_m**2) - NEAR_M
    out_s = reach / cruise_mps + cruise_mps / ACCELERATION_MPS2
    time = np.arange(0.0, (2.0 * out_s + 3.0 * HOVER_S) / pace, PERIOD_S)
    own_s = pace * time  # the same path, at another pace
    gone = _leg(own_s - HOVER_S, reach, cruise_mps) - _leg(own_s - 2.0 * HOVER_S - out_s, reach, cruise_mps)
    along, bearing = NEAR_M + gone, radians(bearing_deg)
    position = np.column_stack([along * cos(bearing), along * sin(bearing), np.full(len(time), altitude_m)])
    assert hypot(reach + NEAR_M, altitude_m) <= REACH_M + 1e-9
    return PaperFlight(name, time, position)


def _leg(time_s: Floats, length_m: float, cruise_mps: float) -> Floats:
    """Way flown from rest to rest with constant acceleration, cruise, constant deceleration; 0 before the start."""
    ramp = cruise_mps / ACCELERATION_MPS2
    whole = length_m / cruise_mps + ramp
    t = np.clip(time_s, 0.0, whole)
    start = 0.5 * ACCELERATION_MPS2 * np.minimum(t, ramp) ** 2
    middle = cruise_mps * np.clip(t - ramp, 0.0, whole - 2.0 * ramp)
    last = np.maximum(t - (whole - ramp), 0.0)
    return start + middle + cruise_mps * last - 0.5 * ACCELERATION_MPS2 * last**2
