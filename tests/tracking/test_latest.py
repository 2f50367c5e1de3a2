"""The message held, and the closest approach of a straight relative flight."""

import numpy as np
import pytest
import sensed_flights as sensing
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from rss_gym.params import Params
from rss_gym.tracking import TRACKERS, approach, latest, memory_columns, model

place, speed = st.floats(-150.0, 150.0), st.floats(-6.0, 6.0)


def test_latest_is_its_formula():
    memory, track = sensing.empty("latest")
    constants = sensing.tracker_model(planar=False)
    own, other = sensing.records(
        own_position_m=(5.0, -2.0, 20.0), own_velocity_mps=(3.0, 1.0, 0.5), position_m=(60.0, 20.0, 30.0),
        velocity_mps=(-2.0, 1.5, -0.5), age_s=2.0,
    )  # fmt: skip
    latest.advance(own, other, memory, track, constants)
    np.testing.assert_allclose(track["position_m"], [60.0 - 4.0 - 5.0, 20.0 + 3.0 + 2.0, 30.0 - 1.0 - 20.0])
    np.testing.assert_allclose(track["velocity_mps"], [-5.0, 0.5, -1.0])
    flown = 4.0 * (0.2**2 + 0.2**2 + 0.35**2 + 1.0**2)
    assert track["xx"] == track["yy"] == pytest.approx(6.0**2 + 7.0**2 + flown)
    assert track["xy"] == 0.0
    assert track["zz"] == pytest.approx(2.0 * (1.0**2 + 3.0**2) + flown)


@pytest.mark.parametrize("tracker", TRACKERS)
def test_without_a_message_there_is_no_track(tracker):
    from importlib import import_module

    memory, track = sensing.empty(tracker)
    own, other = sensing.records(valid=False)
    import_module(f"rss_gym.tracking.{tracker}").advance(own, other, memory, track, sensing.tracker_model())
    assert not track["valid"]
    assert len(memory) == memory_columns(tracker)


def test_the_model_knows_who_is_localised_how():
    by_radio, gnss = sensing.tracker_model(), sensing.tracker_model(agent="gnss", intruder="gnss")
    drifting = model(Params.of(agent="dead-reckoning", intruder="dead-reckoning"))[0]
    assert by_radio["own_tc_s"] == by_radio["other_tc_s"] == 0.0
    assert gnss["own_tc_s"] == gnss["other_tc_s"] == 30.0
    assert drifting["own_vertical_m2"] < 0.0 < by_radio["own_vertical_m2"]


@given(place, place, place, speed, speed, speed)
def test_closest_approach_is_the_minimum(x, y, z, vx, vy, vz):
    t, mx, my, mz = approach.closest(x, y, z, vx, vy, vz)
    r, v = np.array([x, y, z]), np.array([vx, vy, vz])
    found = minimize_scalar(lambda s: np.sum((r + s * v) ** 2), bounds=(0.0, 60.0), method="bounded")
    assert 0.0 <= t <= 60.0
    np.testing.assert_allclose([mx, my, mz], r + t * v, atol=1e-9)
    assert np.hypot(np.hypot(mx, my), mz) <= np.sqrt(found.fun) + 1e-3


def test_no_relative_motion_has_its_closest_approach_now():
    assert approach.closest(30.0, -4.0, 1.0, 0.0, 0.0, 0.0) == (0.0, 30.0, -4.0, 1.0)
    assert approach.closest(30.0, 0.0, 0.0, 1e-9, 0.0, 0.0) == (0.0, 30.0, 0.0, 0.0)
