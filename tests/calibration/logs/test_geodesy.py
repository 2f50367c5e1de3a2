"""Local metres against the exact difference of earth-centred coordinates."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.calibration.logs.geodesy import ECCENTRICITY_SQUARED, SEMI_MAJOR_M, east_north_up_m, range_rate_mps


def earth_centred_m(point):
    """The standard formula, x y z."""
    latitude, longitude, altitude_m = np.radians(point[0]), np.radians(point[1]), point[2]
    radius_m = SEMI_MAJOR_M / np.sqrt(1.0 - ECCENTRICITY_SQUARED * np.sin(latitude) ** 2)
    ground_m = (radius_m + altitude_m) * np.cos(latitude)
    height_m = (radius_m * (1.0 - ECCENTRICITY_SQUARED) + altitude_m) * np.sin(latitude)
    return np.array([ground_m * np.cos(longitude), ground_m * np.sin(longitude), height_m])


def axes(point):
    """Unit vectors east, north, up."""
    latitude, longitude = np.radians(point[:2])
    return np.array(
        [
            [-np.sin(longitude), np.cos(longitude), 0.0],
            [-np.sin(latitude) * np.cos(longitude), -np.sin(latitude) * np.sin(longitude), np.cos(latitude)],
            [np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)],
        ]
    )


@given(
    latitude=st.floats(-70.0, 70.0),
    longitude=st.floats(-180.0, 180.0),
    altitude_m=st.floats(-100.0, 5000.0),
    away_m=st.tuples(st.floats(-7000.0, 7000.0), st.floats(-7000.0, 7000.0), st.floats(-500.0, 500.0)),
)
def test_length_against_earth_centred_difference(latitude, longitude, altitude_m, away_m):
    reference = np.array([latitude, longitude, altitude_m])
    degrees_m = 111_200.0
    turned = longitude + away_m[0] / (degrees_m * np.cos(np.radians(latitude)))
    point = np.array([latitude + away_m[1] / degrees_m, (turned + 180.0) % 360.0 - 180.0, altitude_m + away_m[2]])
    exact_m = earth_centred_m(point) - earth_centred_m(reference)
    local_m = east_north_up_m(point[None], reference[None])[0]
    assert np.linalg.norm(local_m) == pytest.approx(np.linalg.norm(exact_m), rel=1e-6, abs=1e-6)
    # Each component, along the axes half-way between the two.
    turn = (point[1] - longitude + 180.0) % 360.0 - 180.0
    half_way = np.array([(latitude + point[0]) / 2.0, longitude + turn / 2.0, 0.0])
    np.testing.assert_allclose(local_m, axes(half_way) @ exact_m, rtol=0.0, atol=1e-6 * np.linalg.norm(exact_m) + 1e-6)


def test_rate_is_the_derivative_of_the_length():
    start_m, velocity_mps, step_s = np.array([3.0, -40.0, 12.0]), np.array([4.0, 1.0, -2.0]), 1e-4
    lengths_m = [np.linalg.norm(start_m + sign * step_s * velocity_mps) for sign in (-1.0, 1.0)]
    rate_mps = range_rate_mps(start_m[None], velocity_mps[None])[0]
    assert rate_mps == pytest.approx((lengths_m[1] - lengths_m[0]) / (2.0 * step_s), rel=1e-6)
