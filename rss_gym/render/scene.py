"""What one picture shows, as plain numbers: positions in metres on the axes (east, north, up)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Aircraft:
    """One aircraft at one moment.

    Attributes
    ----------
    position_m : array (3,)
        True position [m].
    estimate_m : array (3,) or None
        Position solution [m]: its own, or for another aircraft the last message held. None when nothing is known.
    flown_m : array (t, 3)
        True positions since the start [m], evenly spaced in time but for the last.
    predefined_m : array (p, 3)
        Way points of the predefined trajectory [m]. The view is fitted to them.
    velocity_mps : array (3,)
        True velocity [m/s].
    """

    position_m: NDArray[np.floating]
    estimate_m: NDArray[np.floating] | None
    flown_m: NDArray[np.floating]
    predefined_m: NDArray[np.floating]
    velocity_mps: NDArray[np.floating]


@dataclass(frozen=True, slots=True, eq=False)
class Intruder(Aircraft):
    """Another aircraft, and what the agent's radio says of it.

    Attributes
    ----------
    range_m, range_std_m : float
        The filter's range and its standard deviation [m]. No ring is drawn when the range is not finite.
    zone_radius_m : float
        Radius of the safety zone in force [m].
    warning : bool
        Whether the warning is open.
    """

    range_m: float
    range_std_m: float
    zone_radius_m: float
    warning: bool


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Everything one picture needs.

    Attributes
    ----------
    own : Aircraft
        The agent.
    planned_m : array (3,)
        Where the agent would be now on its predefined trajectory [m].
    way_point_m : array (3,)
        Commanded way point [m].
    intruders : tuple of Intruder
        In ID order; drawn with the numbers 1, 2, ... when there are several.
    time_s, duration_s : float
        Time flown and length of the flight [s].
    zone_radius_m : float
        Nominal radius of the safety zone [m]. The view depends on it: keep it the same during an episode.
    collision_radius_m : float
        Separation below which a collision is counted [m].
    min_separation_m : float
        Smallest true separation so far [m].
    planar : bool
        False adds a strip of altitude against time.
    outcome : {"", "collision", "complete"}
        Empty while the flight lasts.
    playback_speed : float
        Seconds flown per second shown, written as "5x real time".
    """

    own: Aircraft
    planned_m: NDArray[np.floating]
    way_point_m: NDArray[np.floating]
    intruders: tuple[Intruder, ...]
    time_s: float
    duration_s: float
    zone_radius_m: float
    collision_radius_m: float
    min_separation_m: float
    planar: bool
    outcome: str
    playback_speed: float
