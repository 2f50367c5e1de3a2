"""Fewer than three nodes: every point of the stated set fits the ranges, and the true position is one of them."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rss_gym.params import ParamsError
from rss_gym.positioning.partial import partial

plane = st.tuples(*[st.floats(-100.0, 100.0)] * 2).map(np.array)
space = st.tuples(*[st.floats(-100.0, 100.0)] * 3).map(np.array)


@pytest.mark.parametrize("axes", [2, 3])
def test_no_node_and_one_node(axes):
    nothing = partial(np.empty((0, axes)), [])
    assert nothing.shape == "anywhere" and nothing.points_m is None and "neither" in nothing.sentence
    one = partial([np.arange(axes)], [7.0])
    assert one.shape == ("circle" if axes == 2 else "sphere")
    assert (one.centre_m == np.arange(axes)).all() and one.radius_m == 7.0
    assert one.shape in one.sentence and "(29)" in one.sentence


@given(plane, plane, plane)
def test_two_points_in_the_plane(a, b, position):
    apart = np.linalg.norm(b - a)
    assume(apart > 1.0)
    off = abs((b - a)[0] * (position - a)[1] - (b - a)[1] * (position - a)[0]) / apart
    assume(off > 0.1)
    nodes = np.array([a, b])
    ranges = np.linalg.norm(nodes - position, axis=1)
    got = partial(nodes, ranges)
    assert got.shape == "points" and got.points_m.shape == (2, 2) and got.gap_m == 0.0
    assert min(np.linalg.norm(point - position) for point in got.points_m) < 1e-6
    for point in got.points_m:
        assert np.linalg.norm(nodes - point, axis=1) == pytest.approx(ranges, abs=1e-7)
    assert np.diff(got.points_m, axis=0)[0] @ (b - a) == pytest.approx(0.0, abs=1e-6)


@given(space, space, space, st.floats(0.0, 6.3))
def test_circle_in_space(a, b, position, angle):
    apart = np.linalg.norm(b - a)
    assume(apart > 1.0)
    assume(np.linalg.norm(np.cross(b - a, position - a)) / apart > 0.1)
    nodes = np.array([a, b])
    ranges = np.linalg.norm(nodes - position, axis=1)
    got = partial(nodes, ranges)
    assert got.shape == "circle" and "circle" in got.sentence
    assert (position - got.centre_m) @ got.normal == pytest.approx(0.0, abs=1e-7)
    assert np.linalg.norm(position - got.centre_m) == pytest.approx(got.radius_m, abs=1e-6)
    across = np.cross(got.normal, [1.0, 0.0, 0.0] if abs(got.normal[0]) < 0.7 else [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    point = got.centre_m + got.radius_m * (np.cos(angle) * across + np.sin(angle) * np.cross(got.normal, across))
    assert np.linalg.norm(nodes - point, axis=1) == pytest.approx(ranges, abs=1e-6)


@pytest.mark.parametrize(
    ("ranges", "x", "gap"),
    [((30.0, 70.0), 30.0, 0.0), ((20.0, 70.0), 25.0, 10.0), ((160.0, 50.0), 155.0, 10.0), ((50.0, 160.0), -55.0, 10.0)],
)
@pytest.mark.parametrize("axes", [2, 3])
def test_ranges_that_do_not_cross(ranges, x, gap, axes):
    """Nodes 100 m apart: touching, apart, and one inside the other from either side; the middle of the gap."""
    nodes = np.zeros((2, axes))
    nodes[1, 0] = 100.0
    got = partial(nodes, ranges)
    assert got.shape == "points" and got.gap_m == gap
    assert got.points_m == pytest.approx(np.array([[x, *[0.0] * (axes - 1)]]))
    assert ("fail to meet by 10 m" if gap else "meet in one point") in got.sentence


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: partial(np.zeros((2, 2)), [1, 1]), "must be two different points"),
        (lambda: partial(np.eye(3), [1, 1, 1]), "at most two nodes, got 3; positioning.fix"),
        (lambda: partial([[0, 0]], [1, 1]), r"ranges_m \(J,\), got \(1, 2\) and \(2,\)"),
        (lambda: partial([[0, 0]], [-1]), "ranges_m must be finite in"),
    ],
)
def test_bad_input_is_one_sentence(call, words):
    with pytest.raises(ParamsError, match=words):
        call()
