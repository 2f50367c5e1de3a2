"""(43)-(45) on arrays: the three conditions, the smallest of all candidates, the edges, and the shortfall at n+1."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rss_gym.avoidance.literal import flown, literal
from rss_gym.params import ParamsError

share = st.floats(-1.0, 1.0)
speed = st.floats(-5.0, 5.0)
radii = st.floats(5.0, 120.0)
ANGLES = np.linspace(0.0, 2.0 * np.pi, 2001)


def vectors(element, axes):
    return st.tuples(*[element] * axes).map(np.array)


def candidates(axes, radius):
    """Points of the circle or sphere of the radius, on a grid."""
    if axes == 2:
        return radius * np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])
    a, b = np.meshgrid(ANGLES[::40], ANGLES[:1001:20] - np.pi / 2)
    return radius * np.stack([np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)], axis=-1).reshape(-1, 3)


def orthogonal_candidates(r, v, radius):
    """Every point (of 2,001) on the circle or sphere whose difference from r is at right angles to v."""
    unit = v / np.linalg.norm(v)
    a = r @ unit
    reach = np.sqrt(radius**2 - a**2)
    if len(v) == 2:
        side = np.array([-unit[1], unit[0]])
        return np.array([a * unit + reach * side, a * unit - reach * side])
    one = np.cross(unit, [1.0, 0.0, 0.0] if abs(unit[0]) < 0.7 else [0.0, 1.0, 0.0])
    one /= np.linalg.norm(one)
    two = np.cross(unit, one)
    return a * unit + reach * (np.cos(ANGLES)[:, None] * one + np.sin(ANGLES)[:, None] * two)


@pytest.mark.parametrize("axes", [2, 3])
@given(data=st.data())
def test_literal_meets_45(axes, data):
    """Within 1e-9 of S, at right angles to v_i, and no other such point is nearer; also from outside the zone."""
    radius, v = data.draw(radii), data.draw(vectors(speed, axes))
    u_i, r = data.draw(vectors(st.floats(-200.0, 200.0), axes)), 1.2 * radius * data.draw(vectors(share, axes))
    speed_mps = np.linalg.norm(v)
    assume(speed_mps > 0.1 and abs(r @ v) < 0.999 * radius * speed_mps)
    assume(np.linalg.norm(r - (r @ v) / speed_mps**2 * v) > 1e-3)
    u_j = u_i + r
    got = literal([u_i], [u_i], [v], [u_j], [u_i], radius)  # way points that meet: (44) holds
    assert got.due.all() and got.changed.all()
    new = got.next_j_m[0]
    assert np.linalg.norm(new - u_i) == pytest.approx(radius, rel=1e-9)
    assert (new - u_j) @ v / speed_mps == pytest.approx(0.0, abs=1e-9 * (radius + np.abs(u_i).max()))
    others = np.linalg.norm(u_i + orthogonal_candidates(r, v, radius) - u_j, axis=1)
    assert np.linalg.norm(new - u_j) <= others.min() + 1e-9
    # And the search has it, to the spacing of its points.
    assert np.linalg.norm(new - u_j) >= others.min() - radius * (ANGLES[1] if axes == 3 else 1e-9)


@pytest.mark.parametrize("axes", [2, 3])
@given(data=st.data())
def test_flown_meets_45_about_the_next_way_point(axes, data):
    radius, v = data.draw(radii), data.draw(vectors(speed, axes))
    next_i, r = data.draw(vectors(st.floats(-200.0, 200.0), axes)), 0.57 * radius * data.draw(vectors(share, axes))
    speed_mps = np.linalg.norm(v)
    assume(speed_mps > 0.1 and np.linalg.norm(r - (r @ v) / speed_mps**2 * v) > 1e-3)
    next_j = next_i + r
    got = flown([next_i], [v], [next_j], radius)
    assert got.changed.all()
    new = got.next_j_m[0]
    assert np.linalg.norm(new - next_i) == pytest.approx(radius, rel=1e-9)
    assert (new - next_j) @ v / speed_mps == pytest.approx(0.0, abs=1e-9 * (radius + np.abs(next_i).max()))
    others = np.linalg.norm(next_i + orthogonal_candidates(r, v, radius) - next_j, axis=1)
    assert np.linalg.norm(new - next_j) <= others.min() + 1e-9


@pytest.mark.parametrize("axes", [2, 3])
@given(data=st.data())
def test_hovering_other_is_left_by_the_shortest_way(axes, data):
    """v_i = 0 leaves only the first condition of (45): no point of the circle or sphere is nearer."""
    radius, r = data.draw(radii), data.draw(vectors(st.floats(-50.0, 50.0), axes))
    assume(np.linalg.norm(r) > 1e-3)
    zero = np.zeros(axes)
    got = literal([zero], [zero], [zero], [r], [zero], radius).next_j_m[0]
    assert np.linalg.norm(got) == pytest.approx(radius, rel=1e-9)
    assert np.linalg.norm(got - r) <= np.linalg.norm(candidates(axes, radius) - r, axis=1).min() + 1e-9


@pytest.mark.parametrize("axes", [2, 3])
@given(data=st.data())
def test_shortfall_at_the_next_step_is_at_most_the_way_flown(axes, data):
    """Printed: |u_j(n+1) - u_i(n+1)| >= S - |v_i| dt, and the bound is nearly reached; flown: it is S."""
    radius, step_s = data.draw(radii), data.draw(st.floats(0.05, 1.0))
    seed = data.draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    u_i, v = rng.uniform(-50.0, 50.0, (200, axes)), rng.uniform(-5.0, 5.0, (200, axes))
    u_j, v_j = u_i + radius * rng.uniform(-0.7, 0.7, (200, axes)), rng.uniform(-5.0, 5.0, (200, axes))
    next_i, next_j = u_i + v * step_s, u_j + v_j * step_s
    got = literal(u_i, next_i, v, u_j, next_j, radius)
    distance = np.linalg.norm(got.next_j_m - next_i, axis=1)[got.changed]
    assert (distance >= radius - step_s * np.linalg.norm(v, axis=1)[got.changed] - 1e-9).all()
    better = flown(next_i, v, next_j, radius)
    assert np.linalg.norm(better.next_j_m - next_i, axis=1)[better.changed] == pytest.approx(radius, rel=1e-9)
    assert (np.linalg.norm(better.next_j_m - next_i, axis=1) >= radius * (1.0 - 1e-9)).all()
    assert (better.due == got.due).all()


def test_half_of_all_pairs_fall_short_as_printed():
    """4,000 pairs in random motion: the share that is nearer than S at n+1, and the largest shortfall in ways flown."""
    rng = np.random.default_rng(1)
    u_i, v = np.zeros((4000, 2)), rng.normal(0.0, 3.0, (4000, 2))
    u_j = rng.uniform(-100.0, 100.0, (4000, 2))  # a / S, which the shortfall is in ways flown, up to 1
    got = literal(u_i, u_i + 0.5 * v, v, u_j, u_j, 120.0)
    short = 120.0 - np.linalg.norm(got.next_j_m - 0.5 * v, axis=1)[got.changed]
    assert np.mean(short > 1e-9) == pytest.approx(0.5, abs=0.04)
    assert 0.9 < np.max(short / (0.5 * np.linalg.norm(v, axis=1)[got.changed])) <= 1.0


def test_no_action_when_the_next_way_points_are_apart():
    """(43) is about n+1: nearer than S at n does not count."""
    got = literal([[0.0, 0.0]], [[0.0, 0.0]], [[1.0, 0.0]], [[50.0, 0.0]], [[60.0, 0.0]], 60.0)
    assert not got.due[0] and not got.changed[0] and got.next_j_m.tolist() == [[60.0, 0.0]]
    apart = flown([[0.0, 0.0]], [[1.0, 0.0]], [[60.0, 0.0]], 60.0)
    assert not apart.due[0] and apart.next_j_m.tolist() == [[60.0, 0.0]]


def test_edges():
    zero, east = [[0.0, 0.0, 0.0]], [[0.0, 4.0, 0.0]]
    # Head-on, p = 0: to the right of v_i; its right, flying north (+x), is +y.
    head_on = literal(zero, zero, [[4.0, 0.0, 0.0]], [[30.0, 0.0, 0.0]], zero, 50.0)
    assert head_on.next_j_m[0] == pytest.approx([30.0, 40.0, 0.0])
    climbing = literal(zero, zero, [[0.0, 0.0, 2.0]], [[0.0, 0.0, 30.0]], zero, 50.0)
    assert climbing.next_j_m[0] == pytest.approx([0.0, 40.0, 30.0])
    same_place = literal(zero, zero, zero, zero, zero, 50.0)
    assert same_place.next_j_m[0] == pytest.approx([0.0, 50.0, 0.0])
    # |a| > S: (45) has no solution, the predefined way point stays although (44) holds.
    ahead = literal(zero, [[0.0, 3.0, 0.0]], east, [[1.0, 51.0, 0.0]], [[1.0, 48.0, 0.0]], 50.0)
    assert ahead.due[0] and not ahead.changed[0] and ahead.next_j_m.tolist() == [[1.0, 48.0, 0.0]]
    for rule in (
        literal(zero, zero, east, [[0.0, 30.0, 0.0]], [[0.0, 30.0, 0.0]], 50.0),
        flown(zero, east, [[0.0, 30.0, 0.0]], 50.0),
    ):
        assert rule.next_j_m[0] == pytest.approx([-40.0, 30.0, 0.0])


def test_rows_broadcast_and_radii_differ():
    u_j = np.array([[10.0, 5.0], [10.0, 5.0], [10.0, -5.0]])
    got = literal([[0.0, 0.0]], [[0.0, 0.0]], [[1.0, 0.0]], u_j, u_j, [20.0, 40.0, 5.0])
    assert got.changed.tolist() == [True, True, False]
    assert got.next_j_m == pytest.approx(np.array([[10.0, np.sqrt(300.0)], [10.0, np.sqrt(1500.0)], [10.0, -5.0]]))
    assert literal(*[np.empty((0, 3))] * 5, 10.0).next_j_m.shape == (0, 3)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: flown([0.0, 0.0], [[1.0, 0.0]], [[1.0, 0.0]], 5.0), r"must all be \(n, 2\) or all \(n, 3\)"),
        (lambda: flown([[0.0, 0.0]], [[1.0, 0.0, 0.0]], [[1.0, 0.0]], 5.0), r"velocity_i_mps \(1, 3\)"),
        (lambda: flown(np.zeros((2, 2)), np.ones((3, 2)), [[1.0, 0.0]], 5.0), r"next_i_m \(2, 2\)"),
        (lambda: flown([[0.0, 0.0]], [[1.0, np.inf]], [[1.0, 0.0]], 5.0), "velocity_i_mps must be finite, got inf"),
        (lambda: flown([[0.0, 0.0]], [[1.0, 0.0]], [[1.0, 0.0]], 0.0), "radius_m must be finite in"),
    ],
)
def test_bad_input_is_one_sentence(call, words):
    with pytest.raises(ParamsError, match=words):
        call()
