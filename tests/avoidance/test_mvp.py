"""MVP: the changed velocity passes at the edge of the zone; edges give their stated answers."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rss_gym.avoidance.approach import conflict, side_of
from rss_gym.avoidance.mvp import velocity_change
from rss_gym.tracking.approach import closest

coordinate = st.floats(-100.0, 100.0)
speed = st.floats(-4.0, 4.0)


@given(
    st.floats(5.0, 40.0),
    st.floats(1.1, 6.0),
    st.floats(-0.98, 0.98),
    st.floats(2.0, 20.0),
    st.sampled_from([0.0, 1.0, -1.0]),
)
def test_the_new_velocity_passes_at_the_radius(radius_m, radii, share, t, side):
    distance, miss = radius_m * radii, radius_m * share
    assume(abs(share) > 0.02)
    # The other is at +x, flown towards: it is passed to its left if the offset is to the right.
    wanted = side or -np.sign(miss)
    turn = np.arcsin(1.0 / radii) + wanted * np.arcsin(miss / distance)
    assume(turn < 1.4)  # less than a right angle
    along = np.sqrt(distance**2 - miss**2)
    dx, dy = velocity_change(along, miss, along / t, 0.0, radius_m, 21.0, side)
    vx, vy = along / t + dx, dy
    assert side_of(along, miss, vx, vy) == wanted
    _, cx, cy, _ = closest(along, miss, 0.0, -vx, -vy, 0.0)
    assert np.hypot(cx, cy) == pytest.approx(radius_m, rel=1e-9)


@given(coordinate, coordinate, speed, speed, st.floats(5.0, 40.0))
def test_mirror_symmetry(x, y, vx, vy, radius_m):
    assume(abs(x * vy - y * vx) > 1e-3)
    dx, dy = velocity_change(x, y, vx, vy, radius_m, 20.0, 0.0)
    assert velocity_change(x, -y, vx, -vy, radius_m, 20.0, 0.0) == pytest.approx((dx, -dy), abs=1e-9)


def test_without_a_conflict_nothing_changes():
    assert velocity_change(50.0, 0.0, -3.0, 0.0, 20.0, 20.0, 0.0) == (0.0, 0.0)  # opening
    assert velocity_change(50.0, 30.0, 3.0, 0.0, 20.0, 20.0, 0.0) == (0.0, 0.0)  # passes clear
    assert velocity_change(100.0, 0.0, 3.0, 0.0, 20.0, 20.0, 0.0) == (0.0, 0.0)  # beyond the look-ahead
    assert velocity_change(50.0, 0.0, 0.0, 0.0, 20.0, 20.0, 0.0) == (0.0, 0.0)  # no relative motion


def test_exactly_head_on_goes_to_one_side():
    dx, dy = velocity_change(60.0, 0.0, 6.0, 0.0, 20.0, 20.0, 0.0)
    assert abs(dy) > 1.0 and dx == pytest.approx(0.0)


def test_a_conflict_is_an_approach_within_radius_and_look_ahead():
    assert conflict(60.0, 1.0, 6.0, 0.0, 20.0, 20.0)
    assert not conflict(60.0, 30.0, 6.0, 0.0, 20.0, 20.0)  # passes clear
    assert not conflict(60.0, 1.0, 6.0, 0.0, 20.0, 5.0)  # later
    assert not conflict(-60.0, 1.0, 6.0, 0.0, 20.0, 20.0)  # past
    assert conflict(-10.0, 1.0, 6.0, 0.0, 20.0, 20.0)  # within
