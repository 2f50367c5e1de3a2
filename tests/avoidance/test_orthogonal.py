"""The orthogonal rule: the closed form satisfies (45), each edge gives its stated answer."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rss_gym.avoidance.modified_orthogonal import bearing_cosine, velocity
from rss_gym.avoidance.orthogonal import displacement, side_of

coordinate = st.floats(-150.0, 150.0)
share = st.floats(-0.57, 0.57)  # three of them stay inside the unit ball
speed = st.floats(-5.0, 5.0)
FREE = (0.0, 0.0, 0.0)


def rule(r, v, radius_m, side=FREE):
    """The displacement as an array."""
    return np.array(displacement(*map(float, r), *map(float, v), float(radius_m), *map(float, side)))


def side_at(r, v):
    """The side as an array."""
    return np.array(side_of(*map(float, r), *map(float, v)))


@given(st.tuples(share, share, share), st.tuples(speed, speed, speed), st.floats(5.0, 120.0))
def test_closed_form_satisfies_the_three_equations(r, v, radius_m):
    r, v = radius_m * np.array(r), np.array(v)
    speed_mps = np.linalg.norm(v)
    assume(speed_mps > 0.1)
    across = r - (r @ v) / speed_mps**2 * v
    assume(np.linalg.norm(across) > 1e-3)
    moved = rule(r, v, radius_m)
    assert np.linalg.norm(r + moved) == pytest.approx(radius_m, rel=1e-9)  # on the edge of the zone
    assert moved @ v == pytest.approx(0.0, abs=1e-7 * speed_mps * radius_m)  # at right angles to v_i
    # The smallest: the other intersection, on the far side, is no nearer.
    far = -np.linalg.norm(across) - np.sqrt(radius_m**2 - (r @ v / speed_mps) ** 2)
    assert np.linalg.norm(moved) <= abs(far) + 1e-9


@given(st.tuples(coordinate, coordinate, coordinate), st.tuples(speed, speed, speed))
def test_the_side_is_a_unit_vector_at_right_angles_to_the_velocity(r, v):
    side, v = side_at(r, v), np.array(v)
    assume(np.linalg.norm(v) > 0.1)
    assert np.linalg.norm(side) == pytest.approx(1.0)
    assert side @ v == pytest.approx(0.0, abs=1e-6 * np.linalg.norm(v))
    assert side @ np.array(r) >= -1e-6  # on which the point is


@given(st.tuples(coordinate, coordinate), st.tuples(speed, speed), st.floats(5.0, 120.0))
def test_mirror_symmetry(r, v, radius_m):
    one = rule((*r, 0.0), (*v, 0.0), radius_m)
    two = rule((r[0], -r[1], 0.0), (v[0], -v[1], 0.0), radius_m)
    v2 = np.hypot(*v)
    assume(v2 > 0.1 and abs(r[0] * v[1] - r[1] * v[0]) > 1e-3 * v2)
    assert two == pytest.approx([one[0], -one[1], one[2]], abs=1e-9)


def test_outside_the_zone_nothing_changes():
    assert not rule((60.0, 0.0, 0.0), (1.0, 0.0, 0.0), 60.0).any()


def test_exactly_head_on_goes_to_the_right_of_the_other_in_the_horizontal_plane():
    # The other flies north (+x) straight at the agent: its right is +y in axes whose y is to the right of x.
    assert rule((30.0, 0.0, 0.0), (4.0, 0.0, 0.0), 50.0) == pytest.approx([0.0, 40.0, 0.0])
    assert side_at((30.0, 0.0, 0.0), (4.0, 0.0, 0.0)) == pytest.approx([0.0, 1.0, 0.0])


def test_hovering_other_is_left_along_the_line_to_it():
    moved = rule((30.0, 40.0, 0.0), (0.0, 0.0, 0.0), 100.0)
    assert moved == pytest.approx([30.0, 40.0, 0.0])


def test_same_place_and_hovering_goes_to_the_right():
    moved = rule((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 60.0)
    assert moved == pytest.approx([0.0, 60.0, 0.0])


def test_vertical_velocity_with_no_offset_still_gives_a_finite_answer():
    moved = rule((0.0, 0.0, 10.0), (0.0, 0.0, 1.0), 50.0)
    assert np.isfinite(moved).all() and moved[2] == pytest.approx(0.0)


def test_the_side_is_kept_across_the_line_of_flight():
    side = side_at((20.0, 1.0, 0.0), (4.0, 0.0, 0.0))
    moved = rule((20.0, -1.0, 0.0), (4.0, 0.0, 0.0), 60.0, side)
    assert moved[1] == pytest.approx(np.sqrt(60.0**2 - 20.0**2) + 1.0)


def test_the_side_is_held_until_the_way_back_is_clear():
    side = (0.0, 1.0, 0.0)
    beside = rule((10.0, -70.0, 0.0), (4.0, 0.0, 0.0), 60.0, side)  # beyond the zone, on the other side of U_i
    assert beside[1] > 70.0
    passed = rule((-61.0, -70.0, 0.0), (4.0, 0.0, 0.0), 60.0, side)
    assert not passed.any()


@given(st.floats(1.0, 150.0), st.floats(0.0, np.pi), st.floats(1.0, 25.0))
def test_the_triangle_gives_the_angle_back(after_m, angle_rad, flown_m):
    before_m = np.sqrt(after_m**2 + flown_m**2 + 2.0 * after_m * flown_m * np.cos(angle_rad))
    assume(before_m > 1e-3)
    assert bearing_cosine(before_m, after_m, flown_m) == pytest.approx(np.cos(angle_rad), abs=1e-6)


def test_impossible_triangles_are_held_within_the_cosine():
    assert bearing_cosine(100.0, 10.0, 1.0) == 1.0
    assert bearing_cosine(10.0, 100.0, 1.0) == -1.0
    assert bearing_cosine(10.0, 10.0, 0.0) == 0.0


@given(st.tuples(speed, speed), st.tuples(speed, speed), st.floats(-1.0, 1.0))
def test_modified_rule_is_orthogonal_as_fast_and_opens_the_range(other, flown, cosine):
    assume(np.hypot(*other) > 0.1 and np.hypot(*flown) > 0.1)
    v = np.array(velocity(*other, *flown, cosine))
    assert v @ np.array(other) == pytest.approx(0.0, abs=1e-9)
    assert np.linalg.norm(v) == pytest.approx(np.hypot(*other))
    # Towards the mean of the two mirror images of the other, or where they agree towards both, the range must grow.
    unit = np.array(flown) / np.hypot(*flown)
    left = np.array([-unit[1], unit[0]]) * np.sqrt(1.0 - cosine**2)
    images = np.array([cosine * unit + left, cosine * unit - left]) @ v
    if images[0] * images[1] > 0.0:
        assert (images <= 1e-9).all()
    else:
        assert images.sum() <= 1e-9
