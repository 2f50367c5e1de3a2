"""One hypothesis of the bearing against matrix algebra, finite differences and the link's own filter."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.ranging import coloured
from rss_gym.tracking import bearing

UPPER = np.triu_indices(3)
GAMMA = 2.7
SCALE = np.array([15.0, 15.0, 2.0])
place = st.floats(-150.0, 150.0)
root = st.lists(st.floats(-1.0, 1.0), min_size=9, max_size=9)


def covariance(entries):
    """A positive definite covariance of [x, y, phi] in plausible units."""
    a = np.reshape(entries, (3, 3))
    return np.diag(SCALE) @ (a @ a.T + 0.05 * np.eye(3)) @ np.diag(SCALE)


def packed(p):
    return tuple(float(v) for v in p[UPPER])


def full(p):
    out = np.zeros((3, 3))
    out[UPPER] = p
    return out + np.triu(out, 1).T


def h(c):
    return c[2] - 10.0 * GAMMA * np.log10(np.hypot(c[0], c[1]))


@given(place, place, st.floats(-5.0, 5.0), root)
def test_predict_is_the_matrix_formula(x, y, phi, entries):
    p, a = covariance(entries), 0.78
    f, q = np.diag([1.0, 1.0, a]), np.diag([0.4, 0.4, 4.0 * (1 - a * a)])
    c, got = bearing.predict((x, y, phi), packed(p), 1.5, -2.0, 0.4, a, 4.0)
    np.testing.assert_allclose(c, [x + 1.5, y - 2.0, a * phi])
    np.testing.assert_allclose(full(got), f @ p @ f.T + q, rtol=1e-12, atol=1e-12)


@given(st.floats(20.0, 150.0), st.floats(-3.14, 3.14), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0), root)
def test_update_is_the_second_order_filter(d, angle, phi, miss_db, entries):
    """Jacobian by finite differences, Hessian of x and y in closed form, and the matrix formulas."""
    p, c = covariance(entries), np.array([d * np.cos(angle), d * np.sin(angle), phi])
    step = 1e-3
    jacobian = np.array([(h(c + e) - h(c - e)) / (2.0 * step) for e in step * np.eye(3)])
    n = c[:2] / d
    hessian = np.zeros((3, 3))
    hessian[:2, :2] = -10.0 * GAMMA / np.log(10.0) / d**2 * (np.eye(2) - 2.0 * np.outer(n, n))
    z = h(c) + miss_db
    curved = hessian @ p
    s = jacobian @ p @ jacobian + 0.5 * np.trace(curved @ curved) + 1.2
    innovation = miss_db - 0.5 * np.trace(curved)
    gain = p @ jacobian / s
    got_c, got_p, got_innovation, got_s = bearing.update(tuple(c), packed(p), z, GAMMA, 1.2, 1.0)
    np.testing.assert_allclose(got_c, c + gain * innovation, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(full(got_p), p - s * np.outer(gain, gain), rtol=1e-4, atol=1e-4)
    assert (got_innovation, got_s) == pytest.approx((innovation, s), rel=1e-5, abs=1e-5)
    assert np.linalg.eigvalsh(full(got_p) / np.outer(SCALE, SCALE)).min() > 0.0


@given(st.floats(5.0, 150.0), st.floats(0.5, 20.0), st.floats(0.5, 20.0))
def test_held_variance_is_the_limit_of_the_recursion(range_m, white, drive):
    slope, p = 10.0 * GAMMA / np.log(10.0) / range_m, 1.0
    for _ in range(300):
        prior = p + slope**2 * 16.0 + drive
        p = prior * white / (prior + white)
    assert bearing.held_variance_db2(range_m, GAMMA, 16.0, drive, white) == pytest.approx(p, rel=1e-6)


@pytest.mark.parametrize(("s", "white", "tc_s"), [(4.0, 4.0, 2.0), (20.9, 1.6, 6.7)])
def test_covariance_at_the_opening_is_that_of_the_links_filter(s, white, tc_s):
    """The link's filter runs at 110 m until its covariance is steady."""
    a = float(np.exp(-0.1 / tc_s))
    drive = s * (1.0 - a * a)
    state = (110.0, 0.0, 1200.0, 0.0, s)
    rss = -10.0 * GAMMA * np.log10(110.0)
    for _ in range(200):
        state = coloured.predict(*state, 0.0, 16.0, a, np.sqrt(drive) / a)
        state = coloured.update(*state, rss, 0.0, GAMMA, white, 0.3)
    d, _, p_dd, p_dp, p_pp = state
    rest = bearing.held_variance_db2(d, GAMMA, 16.0, drive, white)
    got = bearing.open_covariance(d, p_dd, GAMMA, s, rest)
    np.testing.assert_allclose(got, (p_dp, p_pp), rtol=0.15)
    assert got[0] ** 2 < got[1] * p_dd


def test_an_unlikely_range_variance_still_opens_a_valid_bank():
    p_dp, p_pp = bearing.open_covariance(120.0, 180.0**2, GAMMA, 4.0, 1.2)
    assert 0.0 < p_pp < 4.0 and p_dp**2 < p_pp * 180.0**2
