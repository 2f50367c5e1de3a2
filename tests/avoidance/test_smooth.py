"""Smooth trajectories: way points met, derivatives continuous, limits and separations against dense sampling."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from rss_gym.avoidance.literal import flown
from rss_gym.avoidance.smooth import separation, smooth
from rss_gym.params import ParamsError

KINDS = ("quintic", "cubic")


def random_way_points(seed, count=6, axes=3):
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.uniform(0.2, 2.0, count)), np.cumsum(rng.normal(0.0, 3.0, (count, axes)), axis=0)


@pytest.mark.parametrize("kind", KINDS)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 8), axes=st.sampled_from([2, 3]))
def test_way_points_are_met_and_derivatives_continuous(kind, seed, count, axes):
    time, points = random_way_points(seed, count, axes)
    start, end = np.full(axes, 1.5), np.full(axes, -0.5)
    path = smooth(time, points, kind, start, end)
    assert path.position_m(time) == pytest.approx(points, abs=1e-9)
    assert path.velocity_mps(time[0]) == pytest.approx(start) and path.velocity_mps(time[-1]) == pytest.approx(end)
    h = 1e-9
    for knot in time[1:-1]:
        for of_time in (path.position_m, path.velocity_mps, path.acceleration_mps2):
            # Across a knot a continuous function changes by its slope times 2e-9 s.
            assert of_time(knot + h) == pytest.approx(of_time(knot - h), rel=1e-5, abs=1e-5)
    middle, h = 0.5 * (time[0] + time[1]), 1e-5 * (time[1] - time[0])
    slope = (path.position_m(middle + h) - path.position_m(middle - h)) / (2.0 * h)
    assert path.velocity_mps(middle) == pytest.approx(slope, rel=1e-4, abs=1e-4)
    bend = (path.velocity_mps(middle + h) - path.velocity_mps(middle - h)) / (2.0 * h)
    assert path.acceleration_mps2(middle) == pytest.approx(bend, rel=1e-3, abs=1e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_straight_and_parabolic_flight_come_back(kind):
    time = np.array([0.0, 1.0, 2.5, 3.0])
    straight = smooth(time, np.outer(time, [3.0, 4.0]), kind)
    at = np.linspace(0.0, 3.0, 50)
    assert straight.position_m(at) == pytest.approx(np.outer(at, [3.0, 4.0]))
    assert straight.speed_max_mps == pytest.approx(5.0) and straight.acceleration_max_mps2 == pytest.approx(
        0.0, abs=1e-9
    )
    assert straight.breach(5.0, 0.1) == ""
    # x = t^2: parabolas through three points are exact inside, so the middle piece is.
    curved = smooth(time, np.column_stack([time**2, 0.0 * time]), kind, (0.0, 0.0), (6.0, 0.0))
    at = np.linspace(1.0, 2.5, 50)
    assert curved.position_m(at)[:, 0] == pytest.approx(at**2)


def test_cubic_is_scipys_spline():
    time, points = random_way_points(1)
    ends = (points[1] - points[0]) / (time[1] - time[0]), (points[-1] - points[-2]) / (time[-1] - time[-2])
    want = CubicSpline(time, points, bc_type=((1, ends[0]), (1, ends[1])))
    at = np.linspace(time[0], time[-1], 100)
    assert smooth(time, points, "cubic").position_m(at) == pytest.approx(want(at))


def test_quintic_feels_a_way_point_four_pieces_around():
    time, points = np.arange(10.0), random_way_points(2, 10)[1]
    moved = points.copy()
    moved[5] += 1.0
    at = np.linspace(0.0, 9.0, 901)
    change = np.linalg.norm(smooth(time, points).position_m(at) - smooth(time, moved).position_m(at), axis=1)
    assert change[(at <= 3.0) | (at >= 7.0)].max() < 1e-9 < change[(at > 3.1) & (at < 3.9)].min()


@pytest.mark.parametrize("kind", KINDS)
@given(seed=st.integers(0, 2**32 - 1))
def test_largest_speed_and_acceleration(kind, seed):
    path = smooth(*random_way_points(seed), kind)
    at = np.linspace(path.time_s[0], path.time_s[-1], 3001)
    speeds, accelerations = (np.linalg.norm(f(at), axis=1) for f in (path.velocity_mps, path.acceleration_mps2))
    for largest, sampled in ((path.speed_max_mps, speeds), (path.acceleration_max_mps2, accelerations)):
        assert sampled.max() * (1.0 - 1e-9) <= largest <= sampled.max() * 1.01 + 1e-3
    assert path.breach(path.speed_max_mps, path.acceleration_max_mps2) == ""
    assert path.breach(0.99 * path.speed_max_mps, 1e9).startswith("The trajectory cannot be flown: its speed reaches ")
    both = path.breach(0.5 * path.speed_max_mps, 0.5 * path.acceleration_max_mps2)
    assert "m/s, above" in both and " and its acceleration reaches" in both and "m/s^2." in both


@given(seed=st.integers(0, 2**32 - 1), kinds=st.tuples(st.sampled_from(KINDS), st.sampled_from(KINDS)))
def test_separation_is_the_least_distance(seed, kinds):
    time, points = random_way_points(seed)
    later, others = random_way_points(seed + 1)
    one, two = smooth(time, points, kinds[0]), smooth(later, others, kinds[1])
    got = separation(one, two)
    at = np.linspace(max(time[0], later[0]), min(time[-1], later[-1]), 3001)
    distances = np.linalg.norm(one.position_m(at) - two.position_m(at), axis=1)
    assert distances.min() * 0.99 - 0.01 <= got.distance_m <= distances.min() + 1e-9
    there = np.linalg.norm(one.position_m(got.time_s) - two.position_m(got.time_s))
    assert there == pytest.approx(got.distance_m, abs=1e-6)
    assert got.respects(got.distance_m) and not got.respects(got.distance_m * 1.001 + 1e-3)


def test_head_on_pair_round_the_zone():
    """Way points of the rule keep S = 30 m; the curve through them keeps 29 m, and cannot be flown at 5 m/s."""
    time = np.arange(0.0, 41.0)
    u_i = np.column_stack([4.0 * time, 0.0 * time])
    u_j = np.column_stack([160.0 - 4.0 * time, 0.1 + 0.0 * time])
    way_points = flown(u_i, np.tile([4.0, 0.0], (41, 1)), u_j, 30.0).next_j_m
    assert np.linalg.norm(way_points - u_i, axis=1).min() == pytest.approx(30.0)
    path, other = smooth(time, way_points), smooth(time, u_i)
    closest = separation(path, other)
    assert 29.0 < closest.distance_m < 30.0
    assert closest.respects(29.0) and not closest.respects(30.0)
    assert "its speed reaches" in path.breach(5.0, 2.0)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: smooth([0.0], [[0.0, 0.0]]), r"time_s must have the shape \(n,\), n >= 2"),
        (lambda: smooth([0.0, 1.0, 1.0], np.zeros((3, 2))), "time_s must increase, got 1 after 1"),
        (lambda: smooth([0.0, 1.0], np.zeros((2, 2)), "septic"), "kind must be 'quintic' or 'cubic', got 'septic'"),
        (
            lambda: smooth([0.0, 1.0], np.zeros((2, 2)), end_mps=[1.0]),
            r"end_mps must have the shape \(2,\), got \(1,\)",
        ),
        (lambda: smooth([0.0, 1.0], np.zeros((2, 2))).position_m(1.5), r"time_s must be finite in \[0, 1\], got 1.5"),
        (
            lambda: separation(smooth([0, 1], np.zeros((2, 2))), smooth([2, 3], np.zeros((2, 2)))),
            "must overlap in time, but one ends at 1 s and the other starts at 2 s",
        ),
        (
            lambda: separation(smooth([0, 1], np.zeros((2, 2))), smooth([0, 1], np.zeros((2, 3)))),
            "same number of coordinates",
        ),
    ],
)
def test_bad_input_is_one_sentence(call, words):
    with pytest.raises(ParamsError, match=words):
        call()
