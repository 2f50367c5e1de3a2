"""White plus Gauss-Markov noise found from simulated records; its standard errors against the scatter."""

import numpy as np
import pytest
from scipy.stats import binom

from rss_gym.params import ParamsError, load_channel
from rss_gym.radio import GaussMarkov, allan_curve, identify, regular, simulate

PERIOD_S = 0.1
TRUTH = {"white_variance": 4.0, "coloured_variance": 4.0, "coloured_tc": 2.0}
UNITS = {"white_variance": "db2", "coloured_variance": "db2", "coloured_tc": "s"}


def noises(records, n, seed, *, white=4.0, variance=4.0, tc_s=2.0):
    """Records of the channel `paper`, or another, at one metre without wander."""
    channel = load_channel("paper").replace(
        white_variance_db2=white, coloured_variance_db2=variance, coloured_tc_s=tc_s, path_loss_wander=0.0
    )
    return simulate(np.ones((records, n)), PERIOD_S, channel, seed).rss_dbm


def values(fit, name):
    """A number of a fit and its standard error."""
    return getattr(fit, f"{name}_{UNITS[name]}"), getattr(fit, f"{name}_std_{UNITS[name]}")


@pytest.fixture(scope="module", params=[600, 6000], ids=["1 min", "10 min"])
def fits(request):
    """300 records of the channel `paper`."""
    return request.param, [identify(allan_curve(x, PERIOD_S)) for x in noises(300, request.param, 7)]


@pytest.mark.slow
@pytest.mark.parametrize("name", TRUTH)
def test_standard_errors_are_those_of_the_scatter(fits, name):
    """Within a factor of 1.5 of the spread of the middle 80 %: a minute gives Tc and S long tails."""
    n, found = fits
    value, error = np.array([values(fit, name) for fit in found]).T
    low, high = np.quantile(value, [0.1, 0.9])
    ratio = np.median(error) / ((high - low) / 2.5631)
    assert 1 / 1.5 < ratio < 1.5, ratio
    assert abs(np.median(value) / TRUTH[name] - 1.0) < (0.2 if n == 600 else 0.04)
    inside = np.sum(np.abs(value - TRUTH[name]) < 2.0 * error)
    assert inside >= binom.ppf(0.001, 300, 0.9), inside / 300


@pytest.mark.slow
def test_false_alarms_of_the_misfit(fits):
    """On noise that is of the model p is below 5 % in about 5 % of the records (binomial, 0.1 % each side of 3-7 %)."""
    alarms = sum(fit.misfit < 0.05 for fit in fits[1])
    assert binom.ppf(0.001, 300, 0.03) <= alarms <= binom.ppf(0.999, 300, 0.07)


@pytest.mark.slow
def test_a_minute_is_said_to_be_short(fits):
    n, found = fits
    said = np.mean([any("100 s" in w or "is short" in w for w in fit.warnings) for fit in found])
    assert said > 0.5 if n == 600 else said == 0.0


@pytest.mark.parametrize(
    "truth", [{"white": 4.0, "variance": 9.0, "tc_s": 2.0}, {"white": 17.6, "variance": 7.5, "tc_s": 3.5}]
)
def test_long_record_gives_the_truth(truth):
    fit = identify(allan_curve(noises(1, 40_000, 2, **truth)[0], PERIOD_S))
    for name, true in zip(TRUTH, truth.values(), strict=True):
        value, error = values(fit, name)
        assert abs(value - true) < 3.5 * error
        assert error < 0.12 * true
    assert fit.misfit > 0.001
    assert fit.noise == GaussMarkov(fit.coloured_variance_db2, fit.coloured_tc_s)
    low, high = fit.curve.interval(0.999)
    assert ((low < fit.model_db2) & (fit.model_db2 < high)).all()


def test_pooled_records_are_as_good_as_one():
    """Of 12 records of 500 samples the truth lies within 3.5 standard errors, which are near those of one of 6000."""
    pooled = identify(allan_curve(list(noises(12, 500, 9)), PERIOD_S))
    one = identify(allan_curve(noises(1, 6000, 9)[0], PERIOD_S))
    for name, true in TRUTH.items():
        value, error = values(pooled, name)
        assert abs(value - true) < 3.5 * error
        assert error < 2.0 * values(one, name)[1]


def test_only_white_noise_is_found_white():
    fit = identify(allan_curve(np.random.default_rng(3).normal(0.0, 2.0, 6000), PERIOD_S))
    assert fit.white_variance_db2 + fit.coloured_variance_db2 == pytest.approx(4.0, rel=0.1)
    assert any("not told from none" in w for w in fit.warnings)


def test_only_coloured_noise_leaves_no_white():
    fit = identify(allan_curve(noises(1, 6000, 4, white=0.0)[0], PERIOD_S))
    assert fit.white_variance_db2 < 3.5 * fit.white_variance_std_db2 + 1e-3
    assert abs(fit.coloured_tc_s - 2.0) < 3.5 * fit.coloured_tc_std_s


def test_two_times_are_a_misfit():
    """Two Gauss-Markov noises, 0.3 s and 20 s, are not one."""
    x = noises(1, 20_000, 5, white=0.5, tc_s=0.3)[0] + noises(1, 20_000, 6, white=0.5, tc_s=20.0)[0]
    fit = identify(allan_curve(x, PERIOD_S))
    assert fit.misfit < 0.01
    assert any("not that of white plus one" in w for w in fit.warnings)


def test_uneven_times_with_gaps():
    """Samples at 4 Hz with jitter, 10 % lost, a pause: R, S, Tc within 15 % and 3 standard errors of the truth."""
    fine = noises(1, 200_000, 8, white=0.0)[0]  # coloured noise every 0.1 s
    rng = np.random.default_rng(8)
    pick = np.cumsum(rng.integers(2, 4, 60_000))
    pick = pick[(pick < len(fine)) & (rng.random(60_000) > 0.1)]
    pick = pick[(pick < 90_000) | (pick > 91_000)]
    x = fine[pick] + rng.normal(0.0, 2.0, len(pick))
    records, period_s = regular(pick * PERIOD_S, x)
    assert len(records) > 1
    fit = identify(allan_curve(records, period_s))
    for name, true in TRUTH.items():
        value, error = values(fit, name)
        assert abs(value - true) < 3.0 * error + 0.15 * true, (name, value, error)


@pytest.mark.parametrize(("x", "says"), [(np.ones(100), "constant"), (np.arange(11.0), "at least 4 clusters, got 2")])
def test_bad_input(x, says):
    with pytest.raises(ParamsError, match=says):
        identify(allan_curve(x, PERIOD_S))
