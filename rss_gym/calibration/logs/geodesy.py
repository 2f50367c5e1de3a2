"""From latitude, longitude and altitude to metres, and from positions and velocities to range and range rate."""

from __future__ import annotations

import numpy as np

from rss_gym.calibration.logs.record import Floats

# WGS-84
SEMI_MAJOR_M = 6378137.0
FLATTENING = 1.0 / 298.257223563
ECCENTRICITY_SQUARED = FLATTENING * (2.0 - FLATTENING)


def east_north_up_m(point: Floats, reference: Floats) -> Floats:
    """Position of `point` relative to `reference`, in metres east, north and up.

    The differences of the angles times the ellipsoid's radii of curvature half-way between the two. The length errs
    by less than 1 part in a million of the distance up to 10 km between 70 degrees south and north.

    Parameters
    ----------
    point, reference : (n, 3) arrays
        Latitude and longitude in degrees (WGS-84), altitude in metres.

    Returns
    -------
    (n, 3) array
        East, north, up.
    """
    middle, difference = 0.5 * (point + reference), point - reference
    latitude, altitude_m = np.radians(middle[:, 0]), middle[:, 2]
    flattened = 1.0 - ECCENTRICITY_SQUARED * np.sin(latitude) ** 2
    prime_vertical_m = SEMI_MAJOR_M / np.sqrt(flattened)
    meridian_m = prime_vertical_m * (1.0 - ECCENTRICITY_SQUARED) / flattened
    turn = np.remainder(difference[:, 1] + 180.0, 360.0) - 180.0  # across the antimeridian too
    return np.column_stack(
        [
            (prime_vertical_m + altitude_m) * np.cos(latitude) * np.radians(turn),
            (meridian_m + altitude_m) * np.radians(difference[:, 0]),
            difference[:, 2],
        ]
    )


def range_rate_mps(relative_m: Floats, relative_mps: Floats) -> Floats:
    """Rate of the length of `relative_m` (n, 3), none of them null, at the velocities `relative_mps` (n, 3)."""
    rate: Floats = np.sum(relative_m * relative_mps, axis=1) / np.linalg.norm(relative_m, axis=1)
    return rate
