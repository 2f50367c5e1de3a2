"""The path loss factor: Theorem 1, the closed form, the published sequence, windows along a record."""

import math
import re

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rss_gym.params import ParamsError
from rss_gym.ranging.path_loss_factor import adaptive, closed_form, estimate_path_loss_factor, squared_error

WINDOWS = st.lists(st.tuples(st.floats(1.5, 1e4), st.floats(-120.0, 10.0)), min_size=1, max_size=30)
THETAS = st.floats(0.05, 1.95)


def error_of(gamma, distance, phi):
    return float(np.sum((np.array(phi) + 10.0 * gamma * np.log10(distance)) ** 2))


@given(WINDOWS, st.floats(-10.0, 10.0), st.floats(1e-3, 2.0 - 1e-3))
def test_theorem_1(window, initial, theta):
    """For theta in (0, 2) a step lowers e^T e wherever its gradient is not 0, and the rest shrinks by (1 - theta)^2."""
    distance, phi = np.array(window).T
    best = closed_form(distance, phi)
    assume(abs(initial - best) > 1e-3)
    out = estimate_path_loss_factor(distance, phi, initial, theta, 0.0, iterations=1)
    before, after, least = (error_of(gamma, distance, phi) for gamma in (initial, out.value, best))
    excess = 100.0 * np.sum(np.log10(distance) ** 2) * (initial - best) ** 2
    assume(excess * (1.0 - (1.0 - theta) ** 2) > 1e-9 * before)  # the fall is above the rounding of the sum
    assert after < before
    assert after - least == pytest.approx((1.0 - theta) ** 2 * excess, rel=1e-6, abs=1e-9 * before)
    assert out.error_db2 == pytest.approx(after, rel=1e-9, abs=1e-9)


@given(WINDOWS, st.floats(-10.0, 10.0), THETAS)
def test_the_error_of_gamma_shrinks_by_one_minus_theta_a_step(window, initial, theta):
    distance, phi = np.array(window).T
    out = estimate_path_loss_factor(distance, phi, initial, theta, 0.0, iterations=8)
    error = out.history - closed_form(distance, phi)
    scale = np.abs(error).max() + np.abs(out.history).max()
    np.testing.assert_allclose(error[1:], (1.0 - theta) * error[:-1], rtol=0.0, atol=1e-12 * scale)


@given(WINDOWS, st.floats(-10.0, 10.0), THETAS)
def test_it_ends_at_the_closed_form(window, initial, theta):
    """Which is NumPy's linear least squares. (28) sees e^T e, flat there: gamma to the root of its rounding."""
    distance, phi = np.array(window).T
    best = np.linalg.lstsq(-10.0 * np.log10(distance)[:, None], phi, rcond=None)[0][0]
    assert closed_form(distance, phi) == pytest.approx(best, rel=1e-9, abs=1e-12)
    out = estimate_path_loss_factor(distance, phi, initial, theta, 0.0, iterations=2000)
    fall = 100.0 * np.sum(np.log10(distance) ** 2) * theta * (2.0 - theta)  # of e^T e, per squared error of gamma
    rounding = 1e-15 * len(window) * error_of(best, distance, phi)
    assert out.value == pytest.approx(best, rel=1e-9, abs=1e-9 + math.sqrt(rounding / fall))


def test_at_the_minimum_nothing_moves():
    """The case that (26) leaves out: a zero gradient."""
    out = estimate_path_loss_factor([10.0, 100.0], [-25.0, -50.0], initial=2.5)
    assert (out.value, out.iterations, out.stopped, out.error_db2) == (2.5, 1, "tolerance", 0.0)


def test_the_published_sequence():
    """From 2 to 2.571 with theta 0.5: 2.29, 2.43, 2.50; J as printed walks away: 1.7, 1.3, 0.64, -0.3, -1.8."""
    rng = np.random.default_rng(0)
    distance, noise = rng.uniform(5.0, 60.0, 50), 3.0 * rng.standard_normal(50)
    length = np.log10(distance)
    noise -= length * (noise @ length) / (length @ length)  # no part along J: the minimum is 2.571
    phi = -25.71 * length + noise
    out = estimate_path_loss_factor(distance, phi, initial=2.0, theta=0.5, mu_db2=1e-12)
    np.testing.assert_allclose(out.history[:4], [2.0, 2.29, 2.43, 2.50], atol=0.006)
    assert out.value == pytest.approx(2.571, abs=1e-6)
    assert out.stopped == "tolerance"
    gamma, walk = 2.0, []
    for _ in range(5):  # J = de / dgamma, added
        j = 10.0 * length
        gamma += 0.5 * (j @ (phi + 10.0 * gamma * length)) / (j @ j)
        walk.append(gamma)
    np.testing.assert_allclose(walk, [1.7, 1.3, 0.64, -0.3, -1.8], atol=0.05)


def test_stop_reasons_and_history():
    distance, phi = [10.0, 20.0, 40.0], [-30.0, -36.0, -47.0]
    short = estimate_path_loss_factor(distance, phi, mu_db2=0.0, iterations=3)
    assert (short.stopped, short.iterations, short.history.shape) == ("iterations", 3, (4,))
    full = estimate_path_loss_factor(distance, phi, mu_db2=1e-3)
    assert full.stopped == "tolerance"
    errors = [squared_error(gamma, np.log10(distance), np.array(phi)) for gamma in full.history]
    falls = np.abs(np.diff(errors))
    assert falls[-1] <= 1e-3 < falls[-2]  # (28) at the first step where it holds
    assert full.history[-1] == full.value


def test_samples_that_are_missing_are_left_out():
    whole = estimate_path_loss_factor([10.0, 20.0], [-27.0, -35.0])
    holes = estimate_path_loss_factor([10.0, np.nan, 20.0, 5.0], [-27.0, -90.0, -35.0, np.nan])
    assert holes.value == whole.value


def test_adaptive_is_the_closed_form_of_each_window():
    """Run to the end in each window: 200 samples with gaps, M = 30."""
    rng = np.random.default_rng(1)
    gamma = 2.7 + 0.3 * np.sin(np.arange(200) / 40.0)
    distance = rng.uniform(5.0, 80.0, 200)
    rss = -40.0 - 10.0 * gamma * np.log10(distance) + 2.0 * rng.standard_normal(200)
    rss[rng.random(200) < 0.2] = np.nan
    distance[60:70] = np.nan
    out = adaptive(distance, rss, -40.0, window=30, mu_db2=0.0, iterations=60)
    kept = np.flatnonzero(~(np.isnan(rss) | np.isnan(distance)))
    for n in range(200):
        inside = kept[kept <= n][-30:]
        expected = closed_form(distance[inside], rss[inside] + 40.0) if len(inside) else 2.0
        assert out[n] == pytest.approx(expected, rel=1e-7)  # the root of the rounding of e^T e


def test_adaptive_follows_a_change():
    """gamma steps from 2.2 to 3.2 at sample 300; 100 samples later it is within 3 standard errors of the new one."""
    rng = np.random.default_rng(2)
    distance, gamma = rng.uniform(20.0, 80.0, 500), np.where(np.arange(500) < 300, 2.2, 3.2)
    rss = -35.0 - 10.0 * gamma * np.log10(distance) + 3.0 * rng.standard_normal(500)
    out = adaptive(distance, rss, -35.0, window=100)
    for n in (299, 499):
        std = 3.0 / (10.0 * math.sqrt(np.sum(np.log10(distance[n - 99 : n + 1]) ** 2)))
        assert abs(out[n] - gamma[n]) < 3.0 * std + 1e-3


def test_adaptive_holds_gamma():
    """At 1 m nothing is seen, missing samples change nothing, and limits hold."""
    assert adaptive([1.0, 1.0, np.nan], [-35.0, -50.0, -60.0], -35.0, window=2, initial=2.4).tolist() == [2.4] * 3
    assert adaptive([1.01] * 3, [-95.0] * 3, -35.0, window=3, limits=(1.6, 6.0)).tolist() == [6.0] * 3


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"theta": 0.0}, "theta must be between 0 and 2"),
        ({"theta": 2.0}, "theta must be between 0 and 2"),
        ({"theta": np.nan}, "theta must be between 0 and 2"),
        ({"initial": np.inf}, "initial must be a finite number"),
        ({"mu_db2": -1.0}, "mu_db2 must be a number of at least 0"),
        ({"iterations": 0}, "iterations must be a whole number of at least 1"),
        ({"iterations": 2.5}, "iterations must be a whole number of at least 1"),
        ({"distance_m": [10.0, 0.0]}, "distance_m must be above 0 m, got 0"),
        ({"distance_m": [10.0]}, "must have one shape (n,), got (1,) and (2,)"),
        ({"distance_m": ["near", "far"]}, "distance_m must be an array of numbers"),
        ({"distance_m": [1.0, 1.0]}, "at least one sample that is not at 1 m"),
        ({"phi_db": [np.inf, 1.0]}, "phi_db must be finite or NaN"),
        ({"phi_db": [np.nan, np.nan]}, "at least one sample"),
    ],
)
def test_bad_input(changes, sentence):
    with pytest.raises(ParamsError, match=re.escape(sentence)):
        estimate_path_loss_factor(**{"distance_m": [10.0, 20.0], "phi_db": [-27.0, -35.0], **changes})


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"window": 0}, "window must be a whole number of at least 1"),
        ({"offset_dbm": np.nan}, "offset_dbm must be a finite number"),
        ({"limits": (3.0, 2.0)}, "limits must be two increasing numbers"),
    ],
)
def test_bad_input_of_adaptive(changes, sentence):
    good = {"distance_m": [10.0, 20.0], "rss_dbm": [-60.0, -70.0], "offset_dbm": -35.0, "window": 5}
    with pytest.raises(ParamsError, match=re.escape(sentence)):
        adaptive(**{**good, **changes})
