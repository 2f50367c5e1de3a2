"""Path loss on arrays against NumPy, and the fit of factor and offset against numpy.polyfit and its own scatter."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.params import Channel, ParamsError, load_channel
from rss_gym.radio import allan_curve, distance, fit_path_loss, identify, received, regular, simulate

FACTORS = st.floats(1.0, 8.0)
OFFSETS = st.floats(-150.0, 60.0)


@given(FACTORS, OFFSETS, st.lists(st.floats(0.01, 1e4), min_size=1, max_size=20))
def test_received_is_2_and_distance_its_inverse(gamma, offset, d):
    channel = Channel(path_loss_factor=gamma, offset_dbm=offset)
    rss = received(d, channel)
    np.testing.assert_allclose(rss, offset - 10.0 * gamma * np.log10(d), rtol=1e-13, atol=1e-11)
    np.testing.assert_allclose(distance(rss, channel), d, rtol=1e-10)


def test_batches_keep_their_shape():
    d = np.linspace(1.0, 50.0, 12).reshape(3, 4)
    np.testing.assert_array_equal(received(d, "paper")[1], received(d[1], "paper"))
    assert distance(received(d.T, "paper"), "paper").shape == (4, 3)


@given(FACTORS, OFFSETS, st.integers(0, 2**32 - 1), st.integers(3, 200))
def test_fit_is_a_line_in_the_logarithm(gamma, offset, seed, n):
    rng = np.random.default_rng(seed)
    d = np.geomspace(2.0, 80.0, n)
    rss = offset - 10.0 * gamma * np.log10(d) + rng.normal(0.0, 3.0, n)
    fit = fit_path_loss(d, rss)
    slope, level = np.polyfit(-10.0 * np.log10(d), rss, 1)
    assert (fit.path_loss_factor, fit.offset_dbm) == pytest.approx((slope, level), rel=1e-8, abs=1e-8)
    if n > 4:  # polyfit's own covariance
        _, covariance = np.polyfit(-10.0 * np.log10(d), rss, 1, cov=True)
        errors = np.sqrt(np.diag(covariance))
        assert (fit.path_loss_factor_std, fit.offset_std_dbm) == pytest.approx(tuple(errors), rel=1e-8)
    np.testing.assert_allclose(fit.residual_db, rss - level + slope * 10.0 * np.log10(d), atol=1e-8)


def test_coloured_errors_are_the_sandwich():
    """Against A C A^T with the full covariance matrix, at uneven times."""
    rng = np.random.default_rng(1)
    t, d = np.cumsum(rng.uniform(0.05, 0.4, 300)), rng.uniform(2.0, 60.0, 300)
    noise = identify(allan_curve(simulate(np.ones(2000), 0.1, "paper").rss_dbm, 0.1))
    fit = fit_path_loss(d, rng.normal(size=300), t, noise)
    design = np.stack([-10.0 * np.log10(d), np.ones(300)], axis=1)
    c = noise.white_variance_db2 * np.eye(300)
    c += noise.coloured_variance_db2 * np.exp(-np.abs(t[:, None] - t) / noise.coloured_tc_s)
    a = np.linalg.pinv(design)
    expected = np.sqrt(np.diag(a @ c @ a.T))
    assert (fit.path_loss_factor_std, fit.offset_std_dbm) == pytest.approx(tuple(expected), rel=1e-9)


@pytest.mark.slow
def test_errors_cover_the_truth():
    """200 flights of 5 min, 5 to 60 m and back in 40 s: with the noise found the error is the scatter."""
    channel = load_channel("outdoor").replace(path_loss_wander=0.0)
    t = 0.1 * np.arange(3000)
    d = 32.5 + 27.5 * np.cos(2.0 * np.pi * t / 40.0)
    errors, naive, found = [], [], []
    for rss in simulate(np.tile(d, (200, 1)), 0.1, channel, seed=4).rss_dbm:
        first = fit_path_loss(d, rss)
        records, period_s = regular(t, first.residual_db)
        fit = fit_path_loss(d, rss, t, identify(allan_curve(records, period_s)))
        found.append((fit.path_loss_factor, fit.offset_dbm))
        errors.append((fit.path_loss_factor_std, fit.offset_std_dbm))
        naive.append((first.path_loss_factor_std, first.offset_std_dbm))
    scatter = np.std(found, axis=0)
    assert (np.abs(np.mean(found, axis=0) - [2.7, -35.0]) < 4.5 * scatter / np.sqrt(200)).all()
    ratio = np.median(errors, axis=0) / scatter
    assert (ratio > 1 / 1.25).all() and (ratio < 1.25).all(), ratio
    assert (np.median(naive, axis=0) < 0.4 * scatter).all()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (([5.0] * 9, np.zeros(9)), "distance_m must vary"),
        (([5.0, 9.0], [-50.0, -60.0]), "at least 3"),
        (([5.0, 9.0, 12.0], [-50.0, -60.0]), "got 3 and 2"),
        (([5.0, 0.0, 12.0], [-50.0, -60.0, -63.0]), "above 0, got 0 at element 1"),
        (([5.0, np.inf, 12.0], [-50.0, -60.0, -63.0]), "distance_m must be finite"),
        (([5.0, 9.0, 12.0], [-50.0, np.nan, -63.0]), "rss_dbm must be finite, got nan at element 1"),
        (([5.0, 9.0, 12.0], ["-50", "-60", "-63"]), "rss_dbm must be a number or an array of numbers"),
        (([[5.0, 9.0, 12.0]], [-50.0, -60.0, -63.0]), "1-D"),
    ],
)
def test_bad_input(arguments, says):
    with pytest.raises(ParamsError, match=says):
        fit_path_loss(*arguments)


def test_noise_needs_its_times():
    noise = identify(allan_curve(simulate(np.ones(600), 0.1, "paper").rss_dbm, 0.1))
    for times in (None, [0.0, 1.0], [0.0, 2.0, 1.0]):
        with pytest.raises(ParamsError, match="time_s"):
            fit_path_loss([5.0, 9.0, 12.0], [-50.0, -60.0, -63.0], times, noise)


@pytest.mark.parametrize("call", [received, distance])
def test_bad_arrays(call):
    for values in ([], [np.nan], "x", np.ones((1, 2, 3))):
        with pytest.raises(ParamsError, match=r"distance_m|rss_dbm"):
            call(values, "paper")
