"""The collision-cone barrier: on the edge of its half-plane it falls at the rate allowed."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rss_gym.avoidance.collision_cone import half_plane

RESPONSE_S = 1.0
coordinate = st.floats(-100.0, 100.0)
speed = st.floats(-4.0, 4.0)


def barrier(p, v, radius_m):
    """h of the paper, as an independent formula: |v| |p| (cos phi - cos theta)."""
    distance = np.hypot(*p)
    return np.hypot(*v) * np.sqrt(distance**2 - radius_m**2) - p @ v


@given(coordinate, coordinate, speed, speed, speed, speed, st.floats(2.0, 40.0), st.floats(0.1, 2.0), speed)
def test_on_the_edge_the_barrier_falls_at_its_rate(x, y, vx, vy, ox, oy, radius_m, rate_ps, along):
    """dh/dt of the flight, by differences, is -alpha h for a command on the edge, whatever the part along it."""
    p, v, own = np.array([x, y]), np.array([vx, vy]), np.array([ox, oy])
    assume(np.hypot(x, y) > 1.2 * radius_m and np.hypot(vx, vy) > 0.5)
    planes = np.zeros((1, 4))
    half_plane(x, y, vx, vy, ox, oy, radius_m, rate_ps, RESPONSE_S, planes, 0)
    point, edge = planes[0, :2], planes[0, 2:]
    assert np.hypot(*edge) == pytest.approx(1.0)
    acceleration = (point + along * edge - own) / RESPONSE_S
    step_s = 1e-5
    assume(np.hypot(*acceleration) < 50.0)
    after = barrier(p - v * step_s, v + acceleration * step_s, radius_m)
    before = barrier(p + v * step_s, v - acceleration * step_s, radius_m)
    rate = (after - before) / (2.0 * step_s)
    assert rate == pytest.approx(
        -rate_ps * barrier(p, v, radius_m), abs=0.05 + 1e-3 * np.hypot(x, y) * np.hypot(vx, vy)
    )


@given(coordinate, coordinate, speed, speed, st.floats(2.0, 40.0))
def test_mirror_symmetry(x, y, vx, vy, radius_m):
    assume(abs(x * vy - y * vx) > 1e-2 and np.hypot(x, y) > 1e-3)
    one, two = np.zeros((1, 4)), np.zeros((1, 4))
    half_plane(x, y, vx, vy, vx, vy, radius_m, 0.5, RESPONSE_S, one, 0)
    half_plane(x, -y, vx, -vy, vx, -vy, radius_m, 0.5, RESPONSE_S, two, 0)
    # The point mirrored; the edge mirrored and turned round, so that the allowed side is on its left again.
    assert two[0] == pytest.approx(one[0] * [1.0, -1.0, -1.0, 1.0], abs=1e-6 * (1.0 + np.abs(one[0]).max()))


def test_within_the_radius_it_leaves():
    planes = np.zeros((1, 4))
    half_plane(5.0, 0.0, 1.0, 0.0, 1.0, 0.0, 20.0, 0.5, RESPONSE_S, planes, 0)
    x, _, dx, dy = planes[0]
    assert x == pytest.approx(-7.5)  # away from the other, at rest here, at alpha times the depth
    assert (dx, dy) == pytest.approx((0.0, 1.0))


@pytest.mark.parametrize(
    "state", [(0.0, 0.0, 0.0, 0.0), (50.0, 0.0, 3.0, 0.0), (50.0, 0.0, 0.0, 0.0), (0.0, 0.0, 3.0, 0.0)]
)
def test_degenerate_states_give_finite_half_planes(state):
    planes = np.zeros((1, 4))
    half_plane(*state, 1.0, 0.0, 20.0, 0.5, RESPONSE_S, planes, 0)
    assert np.isfinite(planes).all() and np.hypot(*planes[0, 2:]) == pytest.approx(1.0)
