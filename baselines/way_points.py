"""From a way point, or a velocity, to the action that commands it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rss_gym.baselines.policy import vectors
from rss_gym.jit import kernel
from rss_gym.params import Params
from rss_gym.physics.motion import limit

HOMING_PS = 0.1  # slower than the autopilot, so that a velocity on the way back holds for some seconds


@kernel
def _limit(velocity, speed_mps, vertical_mps):
    """`limit` in place on every row."""
    for row in range(len(velocity)):
        v = velocity[row]
        v[0], v[1], v[2] = limit(v[0], v[1], v[2], speed_mps, vertical_mps)


def limited(velocity_mps: np.ndarray, params: Params) -> np.ndarray:
    """Velocities (n, 3) held within the limits on speed, as the world holds that of the way point."""
    velocity = np.array(velocity_mps, dtype=np.float64)
    _limit(velocity, params.aircraft.speed_max_mps, params.aircraft.vertical_speed_max_mps)
    return velocity


def commanded(velocity_mps: np.ndarray, seen: Mapping[str, np.ndarray], params: Params) -> np.ndarray:
    """Actions that give the way point these velocities.

    a = (v - v_planned) / limit, in each axis, of v held within the limits on speed as the world holds it. Backwards an
    action says no more than the limit less the planned speed. To hold v to that before the limits, which favours the
    way to the side, had the orthogonal rule collide 5 times in place of 3 (40 m, 4,000 encounters of split
    `validation`, seed 0).

    Parameters
    ----------
    velocity_mps : (n, 3) array
        Along the leg, right, up.
    seen : mapping
        Own fields in SI units.
    params : Params
        For its limits.

    Returns
    -------
    (n, 3) array
        In [-1, 1].
    """
    aircraft, velocity = params.aircraft, limited(velocity_mps, params)
    velocity[:, 0] -= seen["cruise_mps"]
    actions = velocity / [aircraft.speed_max_mps, aircraft.speed_max_mps, aircraft.vertical_speed_max_mps]
    return np.maximum(actions, -1.0)


def towards(target_m: np.ndarray, seen: Mapping[str, np.ndarray], params: Params) -> np.ndarray:
    """Actions that bring the way point to a displacement within one decision, or as near as the limits allow.

    v = v_planned + (target - w) / T, w the way point minus the predefined trajectory, T the time of a decision.

    Parameters
    ----------
    target_m : (n, 3) array
        Displacements from the predefined trajectory: along the leg, right, up.
    seen, params
        See `commanded`.

    Returns
    -------
    (n, 3) array
        In [-1, 1].
    """
    velocity = (target_m - vectors(seen, "way_point", "m")) / params.clock.decision_s
    velocity[:, 0] += seen["cruise_mps"]
    return commanded(velocity, seen, params)


def path_following(seen: Mapping[str, np.ndarray], params: Params) -> np.ndarray:
    """Velocity of the way point that leads it back to the predefined trajectory, m/s, shape (n, 3).

    v = v_planned - w / 10 s.
    """
    velocity = -HOMING_PS * vectors(seen, "way_point", "m")
    velocity[:, 0] += seen["cruise_mps"]
    return limited(velocity, params)
