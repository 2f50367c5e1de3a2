"""A policy that reads a table of values at the belief of the track."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import sqrt

import numpy as np

from rss_gym.avoidance.qmdp import solve, value
from rss_gym.baselines.intruders import intruders
from rss_gym.baselines.policy import Scripted, vectors
from rss_gym.baselines.velocity_rule import HEIGHT_M
from rss_gym.baselines.way_points import HOMING_PS, commanded
from rss_gym.jit import kernel
from rss_gym.params import Params, number
from rss_gym.physics.motion import limit

LOOKAHEAD_S, HALF_M, CELL_M = 20.0, 60.0, 1.0  # of the table
SPEEDS = (0.0, 0.25, 0.5, 0.75, 1.0, -0.25, -0.5, -0.75, -1.0)  # of the candidates, as shares of the limit on speed


@lru_cache(maxsize=8)
def table_of(params: Params, drift_mps: float, flight_s: float) -> np.ndarray:
    """V of a world, see `rss_gym.avoidance.qmdp.solve`; the speed is the one that its fastest cruise leaves across."""
    reward, zone, aircraft = params.reward, params.zone, params.aircraft
    across_mps = sqrt(max(aircraft.speed_max_mps**2 - params.encounter.cruise_max_mps**2, 1.0))
    return solve(
        np.array([reward.snmac_price_m, reward.collision_price_m]),
        np.array([zone.snmac_horizontal_m, zone.collision_m]),
        across_mps,
        drift_mps,
        flight_s,
        params.clock.decision_s,
        round(LOOKAHEAD_S / params.clock.decision_s),
        HALF_M,
        CELL_M,
    )


@kernel
def _meeting(p, q, w, cruise_mps, along_m, across_m):
    """Time to the closest approach (s), n (2), mean and standard deviation of the miss (m), if the path were flown.

    Position `p` (m) relative to the own aircraft and velocity `q` (m/s) are the other's, `w` (m) is the own way point
    beside the path; the standard deviations of the position are those along and across the bearing.
    """
    ux, uy = q[0] - cruise_mps, q[1]
    speed = max(sqrt(ux * ux + uy * uy), 0.1)
    ux, uy = ux / speed, uy / speed
    distance = max(sqrt(p[0] * p[0] + p[1] * p[1]), 1e-6)
    cosine = (p[1] * ux - p[0] * uy) / distance  # of n = (-uy, ux) and the bearing
    square = cosine * cosine * along_m**2 + (1.0 - cosine * cosine) * across_m**2
    miss = (p[1] + w[1]) * ux - (p[0] + w[0]) * uy
    return -(p[0] * ux + p[1] * uy) / speed, -uy, ux, miss, sqrt(square)


@kernel
def _choose(
    table, way_point, cruise, known, position, velocity, std_along, std_across,
    sigmas, lag_s, hold_s, step_s, speed_mps, out,
):  # fmt: skip
    """Write the velocity of least expected cost into each row of `out` (n, 3), m/s; homing where no intruder counts.

    `way_point` (n, 3) beside the path and `cruise` (n,) are the own state; `known` (n, K) says who counts, `position`
    and `velocity` (n, K, 3) are theirs, and their standard deviations along and across the bearing (n, K), m.
    """
    count = known.shape[1]
    n, miss, std, time = np.empty((count, 2)), np.empty(count), np.empty(count), np.empty(count)
    for row in range(len(out)):
        w, met = way_point[row], 0  # met: how many count
        for k in range(count):
            left, nx, ny, mean, spread = _meeting(
                position[row, k], velocity[row, k], w, cruise[row], std_along[row, k], std_across[row, k]
            )
            if known[row, k] and left >= -hold_s:
                n[met, 0], n[met, 1], miss[met], std[met] = nx, ny, mean, sigmas * spread
                time[met] = max(left - lag_s - step_s, 0.0)  # after this decision
                met += 1
        least = np.inf
        out[row, 0], out[row, 1], out[row, 2] = cruise[row] - HOMING_PS * w[0], -HOMING_PS * w[1], -HOMING_PS * w[2]
        for j in range(met):
            across = w[0] * n[j, 0] + w[1] * n[j, 1]
            for share in SPEEDS:
                change = share * speed_mps + HOMING_PS * across
                vx, vy, _ = limit(
                    cruise[row] - HOMING_PS * w[0] + change * n[j, 0], -HOMING_PS * w[1] + change * n[j, 1], 0.0,
                    speed_mps, 1.0,
                )  # fmt: skip
                x, y = w[0] + (vx - cruise[row]) * step_s, w[1] + vy * step_s
                total = 0.0
                for k in range(met):
                    to = x * n[k, 0] + y * n[k, 1]
                    total += value(table, std[k], time[k], to, miss[k], step_s, HALF_M, CELL_M)
                if total < least:
                    least, out[row, 0], out[row, 1] = total, vx, vy


@dataclass(frozen=True, kw_only=True)
class Qmdp(Scripted):
    """A table made by value iteration for one intruder, flown on the belief of its track.

    It manoeuvres in the horizontal plane only. With several intruders the expected costs are added up. The defaults are
    the cheapest of four settings over 20,000 encounters of split `validation`, seed 0, after twelve over 4,000.

    Parameters
    ----------
    sigmas : float
        The track's standard deviations are multiplied by it.
    drift_mps : float
        Standard deviation of the other's velocity, of which the table knows.
    lag_s : float
        Time that the aircraft is behind its way point.
    hold_s : float
        Time after the closest approach in which the intruder still counts.
    flight_s : float
        Length of a flight, over which the deviation is averaged.
    """

    sigmas: float = number(1.3, 0.0, 10.0)
    drift_mps: float = number(0.3, 0.0, 10.0)
    lag_s: float = number(3.0, 0.0, 20.0)
    hold_s: float = number(2.0, 0.0, 60.0)
    flight_s: float = number(60.0, 1.0, 3600.0)

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """The velocity of least expected cost."""
        others, out = intruders(seen), np.empty((len(memory), 3))
        _choose(
            table_of(self.params, self.drift_mps, self.flight_s),
            vectors(seen, "way_point", "m"),
            np.ascontiguousarray(seen["cruise_mps"]),
            others.known & (np.abs(others.position_m[..., 2]) < HEIGHT_M),
            others.position_m,
            others.velocity_mps,
            seen["track_std_along_m"],
            seen["track_std_across_m"],
            self.sigmas,
            self.lag_s,
            self.hold_s,
            self.params.clock.decision_s,
            self.params.aircraft.speed_max_mps,
            out,
        )
        return commanded(out, seen, self.params)
