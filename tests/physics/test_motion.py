"""Limits on vectors, and the autopilot's gains against a numerical Riccati solver."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_continuous_are

from rss_gym.params import Aircraft
from rss_gym.physics.motion import clip, limit, regulate

COMPONENTS = st.floats(-1e3, 1e3).filter(lambda x: x == 0.0 or abs(x) > 1e-100)
LARGEST = st.floats(0.1, 100.0)


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6), st.floats(0.0, 1e6))
def test_clip_is_numpys(x, low, width):
    assert clip(x, low, low + width) == np.clip(x, low, low + width)


@given(COMPONENTS, COMPONENTS, COMPONENTS, LARGEST, LARGEST)
def test_limit_bounds_the_vector_and_keeps_its_direction(x, y, z, largest, largest_z):
    a, b, c = limit(x, y, z, largest, largest_z)
    assert math.hypot(a, b, c) <= largest * (1.0 + 1e-12)
    assert abs(c) <= largest_z
    held = np.array([x, y, np.clip(z, -largest_z, largest_z)])
    length = np.linalg.norm(held)
    np.testing.assert_allclose([a, b, c], held * min(1.0, largest / length) if length else held, rtol=1e-12, atol=1e-12)


@given(COMPONENTS, COMPONENTS, COMPONENTS, LARGEST, LARGEST)
def test_limit_is_idempotent(x, y, z, largest, largest_z):
    once = limit(x, y, z, largest, largest_z)
    np.testing.assert_allclose(limit(*once, largest, largest_z), once, rtol=1e-12, atol=0.0)


def test_limit_leaves_short_vectors_bit_for_bit():
    assert limit(0.1, -0.2, 0.3, 1.0, 0.3) == (0.1, -0.2, 0.3)
    assert limit(0.0, 0.0, 0.0, 1.0, 1.0) == (0.0, 0.0, 0.0)
    assert limit(3.0, 0.0, 4.0, 5.0, 4.0) == (3.0, 0.0, 4.0)
    assert limit(0.0, 0.0, -9.0, 5.0, 2.0) == (0.0, 0.0, -2.0)


@given(st.floats(1e-3, 1e3), st.floats(0.0, 1e3), st.floats(1e-3, 1e3))
def test_gains_solve_the_riccati_equation(q, qv, r):
    """Double integrator, cost q e^2 + qv e'^2 + r a^2: K = R^-1 B^T P, P from SciPy."""
    aircraft = Aircraft(regulator_position_weight=q, regulator_velocity_weight=qv, regulator_effort_weight=r)
    a, b = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]])
    gains = (b.T @ solve_continuous_are(a, b, np.diag([q, qv]), np.array([[r]])) / r)[0]
    assert (aircraft.position_gain_ps2, aircraft.velocity_gain_ps) == pytest.approx(gains, rel=1e-6)


@given(st.floats(-200.0, 200.0), st.floats(-10.0, 10.0))
def test_regulate_is_linear_feedback(e, e_dot):
    aircraft = Aircraft()
    k1, k2 = aircraft.position_gain_ps2, aircraft.velocity_gain_ps
    assert (k1, k2) == (1.0, math.sqrt(3.0))
    assert regulate(e, e_dot, k1, k2) == pytest.approx(k1 * e + k2 * e_dot, rel=1e-14, abs=1e-14)


def test_the_closed_loop_is_stable_and_does_not_ring():
    aircraft = Aircraft()
    poles = np.roots([1.0, aircraft.velocity_gain_ps, aircraft.position_gain_ps2])
    assert all(poles.real < 0.0)
    damping = aircraft.velocity_gain_ps / (2.0 * math.sqrt(aircraft.position_gain_ps2))
    assert 0.8 < damping < 1.2
