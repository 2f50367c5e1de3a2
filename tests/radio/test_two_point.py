"""The literal two-point method: right on the autocovariance, divergent on the rising part of the Allan curve."""

import math

import numpy as np
import pytest

from rss_gym.params import ParamsError, load_channel
from rss_gym.radio import (
    AllanCurve,
    Autocovariance,
    GaussMarkov,
    allan_curve,
    allan_model,
    autocovariance,
    simulate,
    two_point,
)

PERIOD_S = 0.1
NOISE = GaussMarkov(9.0, 2.0)


def exact_allan(white):
    """The Allan curve without any sampling error."""
    m = 2 ** np.arange(11)
    return AllanCurve(PERIOD_S, m, allan_model(m, white, NOISE, PERIOD_S), m, np.ones(11), (2**12,))


def test_exact_autocovariance_gives_the_truth():
    lags = np.arange(40)
    curve = Autocovariance(PERIOD_S, lags, NOISE.autocovariance(lags * PERIOD_S))
    for one, two in ((0.0, 1.0), (0.2, 1.0), (3.0, 0.5)):
        found = two_point(curve, one, two)
        assert found.lambda_ps == pytest.approx(-0.5, rel=1e-12)
        assert found.sigma_w2_db == pytest.approx(NOISE.driving_std_db(PERIOD_S), rel=1e-12)
        assert not found.diverges
        again = GaussMarkov.of_lambda(found.lambda_ps, found.sigma_w2_db, PERIOD_S)
        assert again.variance_db2 == pytest.approx(9.0)


@pytest.mark.parametrize(("one", "two"), [(0.2, 1.6), (0.4, 1.6), (0.4, 3.2)])
def test_allan_curve_gives_a_process_that_diverges_where_it_rises(one, two):
    found = two_point(exact_allan(white=1.0), one, two)
    assert found.lambda_ps > 0.0
    assert found.diverges and math.isnan(found.sigma_w2_db)
    with pytest.raises(ParamsError, match="lambda_ps"):
        GaussMarkov.of_lambda(found.lambda_ps, 1.0, PERIOD_S)


def test_allan_curve_gives_a_wrong_lambda_elsewhere():
    """At the white end too fast, on the falling end an order of magnitude too slow; the truth is -0.5."""
    assert two_point(exact_allan(white=4.0), 0.1, 0.2).lambda_ps < -1.5
    assert -0.1 < two_point(exact_allan(white=4.0), 12.8, 51.2).lambda_ps < 0.0


def test_simulated_record():
    channel = load_channel("outdoor").replace(white_variance_db2=1.0, coloured_variance_db2=9.0, path_loss_wander=0.0)
    x = simulate(np.ones(50_000), PERIOD_S, channel, seed=6).rss_dbm
    assert two_point(allan_curve(x, PERIOD_S), 0.4, 1.6).diverges
    assert two_point(autocovariance(x, PERIOD_S, 20), 0.2, 1.0).lambda_ps == pytest.approx(-0.5, rel=0.15)


def test_autocovariance_is_numpys():
    x = np.random.default_rng(2).normal(size=200)
    full = np.correlate(x - x.mean(), x - x.mean(), "full") / 200
    curve = autocovariance(x, PERIOD_S, 30)
    np.testing.assert_allclose(curve.covariance_db2, full[199:230], rtol=1e-10, atol=1e-14)
    assert curve.covariance_db2[0] == pytest.approx(x.var())
    np.testing.assert_allclose(curve.tau_s, 0.1 * np.arange(31))


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: two_point(exact_allan(1.0), 0.1, 500.0), "tau_2_s"),
        (lambda: two_point(exact_allan(1.0), math.nan, 1.0), "tau_1_s"),
        (lambda: two_point(exact_allan(1.0), 0.8, 0.81), "one point"),
        (lambda: two_point(exact_allan(1.0), "0.8", 1.0), "tau_1_s must be a number"),
        (lambda: two_point(np.ones(5), 0.1, 0.2), "curve must be an Autocovariance, got ndarray"),
        (lambda: two_point(Autocovariance(0.1, np.arange(3), np.array([1.0, 0.5, -0.1])), 0.0, 0.2), "positive"),
        (lambda: autocovariance([1.0, 2.0, 3.0], 0.1, 3), "lags"),
        (lambda: autocovariance([1.0, 2.0, 3.0], 0.1, True), "lags"),
        (lambda: autocovariance([1.0, np.nan, 3.0], 0.1, 1), "nan"),
    ],
)
def test_bad_input(call, says):
    with pytest.raises(ParamsError, match=says):
        call()
