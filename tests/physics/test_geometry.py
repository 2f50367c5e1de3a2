"""Closed forms of vectors and separation against NumPy and fine steps by brute force."""

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from rss_gym.params import Params
from rss_gym.physics.geometry import enters_cylinder, entry_s, least_square_separation, turned

STEPS = 2001
ZONE = Params().zone
RADIUS, HALF_HEIGHT = ZONE.snmac_horizontal_m, ZONE.snmac_vertical_m

# Physical sizes, and exactly zero; a component of 1e-160 m/s would only test the underflow of its square.
LENGTHS = st.one_of(st.just(0.0), st.floats(-200.0, 200.0).filter(lambda x: abs(x) > 1e-6))
SPEEDS = st.one_of(st.just(0.0), st.floats(-60.0, 60.0).filter(lambda x: abs(x) > 1e-6))
PERIODS = st.sampled_from([0.01, 0.1, 1.0, 7.3])


def _path(r, v, period_s):
    """Relative positions at fine steps; shape (STEPS, 3)."""
    return np.asarray(r) + np.linspace(0.0, period_s, STEPS)[:, None] * np.asarray(v)


def _brute_least(r, v, period_s):
    """Least separation over the steps, and how far the true least can lie below it."""
    distances = np.linalg.norm(_path(r, v, period_s), axis=1)
    return distances.min(), 0.5 * np.linalg.norm(v) * period_s / (STEPS - 1) + 1e-9


def _brute_cylinder(r, v, period_s, radius_m, half_height_m):
    """Depth in the cylinder at the deepest step (positive inside, in metres), and the error of the steps."""
    path = _path(r, v, period_s)
    depth = np.minimum(radius_m - np.hypot(path[:, 0], path[:, 1]), half_height_m - abs(path[:, 2])).max()
    return depth, 0.5 * np.linalg.norm(v) * period_s / (STEPS - 1) + 1e-9


@given(st.tuples(LENGTHS, LENGTHS, LENGTHS), st.tuples(SPEEDS, SPEEDS, SPEEDS), PERIODS)
@example((10.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.1)
@example((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.1)
@example((1.0, 0.0, 0.0), (-20.0, 0.0, 0.0), 0.1)
@example((5.0, 3.0, 0.0), (-50.0, 0.0, 0.0), 0.1)
def test_least_separation_is_the_brute_force_minimum(r, v, period_s):
    least = np.sqrt(least_square_separation(*r, *v, period_s))
    brute, slack = _brute_least(r, v, period_s)
    assert brute - slack <= least <= brute + 1e-9 * (1.0 + brute)


def test_least_separation_random():
    """20,000 encounters inside one tick, a third with the minimum inside it."""
    rng = np.random.default_rng(5)
    n, period_s = 20_000, 0.1
    r, v = rng.normal(0.0, 1.0, (n, 3)), rng.normal(0.0, 10.0, (n, 3))
    exact = np.array([least_square_separation(*r[i], *v[i], period_s) for i in range(n)])
    # By calculus: |r + v t|^2 at the clipped root of its derivative.
    t = np.clip(-np.sum(r * v, axis=1) / np.sum(v * v, axis=1), 0.0, period_s)
    np.testing.assert_allclose(exact, np.sum((r + v * t[:, None]) ** 2, axis=1), rtol=1e-12, atol=1e-12)
    assert 0.2 < np.mean((t > 0.0) & (t < period_s)) < 0.6


def test_least_separation_edges():
    assert least_square_separation(3.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.1) == 25.0  # no relative motion
    assert least_square_separation(3.0, 4.0, 0.0, 3.0, 4.0, 0.0, 0.1) == 25.0  # receding
    assert least_square_separation(3.0, 4.0, 0.0, 4.0, -3.0, 0.0, 0.1) == 25.0  # passing now
    assert least_square_separation(10.0, 2.0, 0.0, -50.0, 0.0, 0.0, 0.2) == 4.0  # at the very end
    assert least_square_separation(10.0, 2.0, 0.0, -50.0, 0.0, 0.0, 0.1) == 29.0  # not yet
    assert least_square_separation(10.0, 2.0, 0.0, -200.0, 0.0, 0.0, 0.1) == 4.0  # between two ticks


@given(
    st.tuples(st.floats(-40.0, 40.0), st.floats(-40.0, 40.0), st.floats(-12.0, 12.0)),
    st.tuples(SPEEDS, SPEEDS, SPEEDS),
    PERIODS,
)
@example((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.1)
@example((10.0, 0.0, 3.0), (0.0, 0.0, 0.0), 0.1)
@example((10.0, 0.0, 6.0), (0.0, 0.0, -30.0), 0.1)
@example((20.0, 0.0, 6.0), (-60.0, 0.0, -30.0), 1.0)
@example((20.0, 0.0, 3.0), (-60.0, 0.0, 0.0), 1.0)
def test_cylinder_is_the_brute_force_answer(r, v, period_s):
    depth, slack = _brute_cylinder(r, v, period_s, RADIUS, HALF_HEIGHT)
    assume(not -slack < depth <= 1e-9)  # the steps cannot tell a grazing pass
    assert enters_cylinder(*r, *v, period_s, RADIUS, HALF_HEIGHT) == (depth > 0.0)


def test_cylinder_random():
    """2,000 passes of one second; the steps decide all but a handful."""
    rng = np.random.default_rng(6)
    wrong = decided = inside = 0
    for _ in range(2000):
        r, v = rng.uniform((-30, -30, -10), (30, 30, 10)), rng.uniform(-30, 30, 3)
        v[rng.integers(3)] *= rng.integers(2)
        depth, slack = _brute_cylinder(r, v, 1.0, RADIUS, HALF_HEIGHT)
        if -slack < depth <= 1e-9:
            continue
        decided, inside = decided + 1, inside + (depth > 0.0)
        wrong += enters_cylinder(*r, *v, 1.0, RADIUS, HALF_HEIGHT) != (depth > 0.0)
    assert wrong == 0
    assert decided > 1990
    assert 0.1 < inside / decided < 0.9


@pytest.mark.parametrize(
    ("r", "v", "period_s", "inside"),
    [
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.1, True),  # at rest in the middle
        ((RADIUS, 0.0, 0.0), (0.0, 0.0, 0.0), 0.1, False),  # at rest on the rim: the limits are strict
        ((0.0, 0.0, HALF_HEIGHT), (0.0, 0.0, 0.0), 0.1, False),  # and on the lid
        ((0.0, 0.0, -HALF_HEIGHT), (1.0, 0.0, 0.0), 0.1, False),
        ((0.0, 0.0, HALF_HEIGHT), (0.0, 0.0, -1.0), 0.1, True),  # enters through the lid at once
        ((0.0, 0.0, HALF_HEIGHT), (0.0, 0.0, 1.0), 0.1, False),  # leaves at once
        ((0.0, 0.0, 5.57), (0.0, 0.0, -10.0), 0.1, False),  # would enter as the tick ends
        ((0.0, 0.0, 5.56), (0.0, 0.0, -10.0), 0.1, True),
        ((RADIUS, 0.0, 0.0), (0.0, 5.0, 0.0), 0.1, False),  # along the tangent
        ((RADIUS, -1.0, 0.0), (0.0, 20.0, 0.0), 0.1, False),  # touches the rim from outside
        ((20.0, 0.0, 0.0), (-400.0, 0.0, 0.0), 0.1, True),  # right through it within one tick
        ((20.0, 0.0, 20.0), (-400.0, 0.0, -100.0), 0.1, False),  # both limits, but at different instants
        ((20.0, 0.0, 20.0), (-400.0, 0.0, -400.0), 0.1, True),
    ],
)
def test_cylinder_edges(r, v, period_s, inside):
    assert enters_cylinder(*r, *v, period_s, RADIUS, HALF_HEIGHT) is inside


@given(st.tuples(st.floats(-6.0, 6.0), st.floats(-6.0, 6.0), st.floats(-6.0, 6.0)), st.tuples(SPEEDS, SPEEDS, SPEEDS))
def test_a_collision_is_an_snmac(r, v):
    """The sphere of `collision_m` lies inside the cylinder, so the events are nested."""
    assert RADIUS >= ZONE.collision_m
    assert HALF_HEIGHT >= ZONE.collision_m
    if least_square_separation(*r, *v, 0.1) < ZONE.collision_m**2:
        assert enters_cylinder(*r, *v, 0.1, RADIUS, HALF_HEIGHT)


@given(LENGTHS, LENGTHS, st.floats(-np.pi, np.pi))
def test_turned_is_a_rotation_to_the_right(x, y, angle_rad):
    turn = complex(x, y) * np.exp(-1j * angle_rad)
    assert turned(x, y, np.cos(angle_rad), np.sin(angle_rad)) == pytest.approx(
        (turn.real, turn.imag), abs=1e-12 * (abs(x) + abs(y)) + 1e-300
    )


@given(st.tuples(LENGTHS, LENGTHS, LENGTHS), st.tuples(SPEEDS, SPEEDS, SPEEDS))
@example((150.0, 0.0, 0.0), (0.0, 0.0, 0.0))
@example((150.0, 0.0, 0.0), (-5.0, 0.0, 0.0))
@example((10.0, 0.0, 0.0), (5.0, 0.0, 0.0))
def test_entry_is_the_first_time_within_the_radius(r, v):
    assume(np.linalg.norm(v) == 0.0 or np.linalg.norm(v) > 0.01)
    time_s, radius = entry_s(*r, *v, ZONE.radius_m), ZONE.radius_m
    assert 0.0 <= time_s < np.inf
    reached = np.linalg.norm(np.add(r, np.multiply(v, time_s)))
    least = np.sqrt(least_square_separation(*r, *v, 1e6))
    if np.linalg.norm(r) <= radius or np.dot(r, v) >= 0.0:
        assert time_s == pytest.approx(0.0, abs=1e-3)  # inside, or never nearer than now
    else:
        assert reached == pytest.approx(max(radius, least), rel=1e-6)
        assert (_path(r, v, time_s)[:-1] ** 2).sum(axis=1).min() >= (reached * (1.0 - 1e-6)) ** 2
