"""Functions of means by the delta method, and policies beside a rule's curve, against closed forms and a bootstrap."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from rss_gym.eval.curve import Points, deviation_beside, frontier, rate_beside
from rss_gym.eval.delta import Delta

N = 4000


def points(rate, deviation_m, n=N, seed=0, common=None):
    """Flights whose deviations are correlated by `common`, collisions drawn from it too."""
    generator = np.random.default_rng(seed)
    common = np.zeros(n) if common is None else common
    collision = stats.norm.cdf(0.6 * common + 0.8 * generator.normal(size=n)) < rate
    return Points(collision, deviation_m * np.exp(0.3 * common + 0.1 * generator.normal(size=n)))


@pytest.fixture
def flown():
    """A policy and three settings of a rule over the same encounters."""
    common = np.random.default_rng(7).normal(size=N)
    policy = points(0.02, 6.0, seed=1, common=common)
    return policy, [points(*at, seed=2 + i, common=common) for i, at in enumerate([(0.2, 4), (0.05, 9), (0.01, 20)])]


def test_a_mean_has_the_interval_and_test_of_student():
    x = np.random.default_rng(0).normal(0.1, 1.0, 300)
    found, expected = Delta.mean(x), stats.ttest_1samp(x, 0.0)
    ends = expected.confidence_interval(0.95)
    assert found.interval()[:3] == pytest.approx((np.mean(x), ends.low, ends.high), rel=1e-9)
    assert found.p() == pytest.approx(expected.pvalue, rel=1e-9)


def test_a_difference_of_means_is_the_paired_test():
    x, y = np.random.default_rng(1).normal(5.0, 1.0, (2, 300)) + np.random.default_rng(2).normal(0, 3, 300)
    found, expected = Delta.mean(x) - 0.98 * Delta.mean(y), stats.ttest_rel(x, 0.98 * y)
    assert found.p() == pytest.approx(expected.pvalue, rel=1e-9)


def test_derivatives_are_those_of_finite_differences():
    """What one encounter weighs: the value with its weight raised by h, less the value, over h / n."""
    x, y = np.random.default_rng(3).uniform(1.0, 2.0, (2, 20))

    def function(a, b):
        return ((a.log() - b) / (a * b) + b).exp() if isinstance(a, Delta) else np.exp((np.log(a) - b) / (a * b) + b)

    found, h = function(Delta.mean(x), Delta.mean(y)), 1e-6
    assert found.value == pytest.approx(function(x.mean(), y.mean()), rel=1e-12)
    for i in range(20):
        weights = np.full(20, 1.0 / 20)
        weights *= 1.0 - h
        weights[i] += h
        numeric = (function(weights @ x, weights @ y) - function(x.mean(), y.mean())) / h
        assert found.influence[i] == pytest.approx(numeric, rel=1e-4, abs=1e-6)


def test_a_rate_without_an_event_counts_half_a_one():
    assert Delta.rate(np.zeros(200, bool)).value == 0.5 / 200
    assert Delta.rate(np.arange(200) < 3).value == 3 / 200
    with pytest.raises(ValueError, match="no encounter"):
        Delta.mean(np.zeros(0))


def test_a_rate_without_an_event_is_as_uncertain_as_one_event():
    """Variance of one event in n, (1/n)(1 - 1/n); the value without a logarithm is zero."""
    for found, value in ((Delta.share(np.zeros(200, bool)), 0.0), (Delta.rate(np.zeros(200, bool)), 0.5 / 200)):
        assert found.value == value
        assert np.var(found.influence) == pytest.approx((1 / 200) * (1 - 1 / 200))
        assert np.mean(found.influence) == pytest.approx(0.0, abs=1e-15)
        assert found.p() > 0.3
    share = Delta.share(np.arange(200) < 3)
    assert (share.value, share.p()) == (Delta.mean(np.arange(200) < 3).value, Delta.mean(np.arange(200) < 3).p())


def test_frontier_by_hand():
    assert frontier([(9, 1), (5, 4), (7, 4), (6, 2), (5, 4), (12, 1)]) == [1, 3, 0]
    assert frontier([]) == []


@given(st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), max_size=12))
def test_frontier_holds_those_that_no_other_beats(drawn):
    kept = frontier(drawn)
    for i, (x, y) in enumerate(drawn):
        beaten = any(a <= x and b <= y and ((a, b) != (x, y) or j < i) for j, (a, b) in enumerate(drawn) if j != i)
        assert (i in kept) == (not beaten)
    assert kept == sorted(kept, key=lambda i: drawn[i])


def test_the_curve_is_straight_in_the_logarithm_of_the_rate():
    """Half way between 4 m and 8 m, the rate is the geometric mean of 0.08 and 0.02; and the way back."""

    def fixed(count, deviation_m):
        return Points(np.arange(100) < count, np.full(100, float(deviation_m)))

    settings = [fixed(2, 8), fixed(8, 4), fixed(9, 9)]
    beside = rate_beside(fixed(1, 6), settings)
    assert (beside.own.value, beside.curve.value) == pytest.approx((0.01, 0.04))
    assert beside.used == (1, 0)  # the third is beaten by both
    back = deviation_beside(fixed(4, 3), settings)
    assert (back.own.value, back.curve.value) == pytest.approx((3.0, 6.0))


def test_beyond_its_ends_the_setting_there_stands_in():
    settings = [Points(np.arange(100) < 8, np.full(100, 4.0)), Points(np.arange(100) < 2, np.full(100, 8.0))]

    def at(collisions, deviation_m):
        policy = Points(np.arange(100) < collisions, np.full(100, deviation_m))
        return [read(policy, settings).curve.value for read in (rate_beside, deviation_beside)]

    assert at(0, 3.0) == pytest.approx([0.08, 8.0])
    assert at(9, 9.0) == pytest.approx([0.02, 4.0])
    with pytest.raises(ValueError, match="at least one setting"):
        rate_beside(settings[0], [])


@pytest.mark.parametrize("event", [0, 1, 2, None])
def test_without_collisions_neither_policy_nor_curve_is_known_exactly(event):
    """Wherever the only collision of the setting is, none against one shows nothing, nor does none against none."""
    n = 100
    none = Points(np.zeros(n, bool), np.full(n, 6.0))
    setting = Points(np.arange(n) == event if event is not None else np.zeros(n, bool), np.full(n, 6.0))
    beside = rate_beside(none, [setting])
    assert beside.own.value == 0.0
    difference = beside.own - beside.curve
    sd = (1.0 + 1.0) ** 0.5 / n  # of two independent counts of one
    width = difference.interval().high - difference.value
    assert width == pytest.approx(stats.t.ppf(0.975, n - 1) * sd, rel=0.02) and difference.p() > 0.05


def test_the_curve_is_not_extended_where_the_encounters_in_common_do_not_reach():
    """On all flights 6 m lies between 4 m and 8 m; on the first 100, which all flew, the second has 4.01 m."""
    late = np.where(np.arange(1000) < 100, 4.01, 8.0 + 399 / 900)
    settings = [
        Points(np.arange(100) < 8, np.full(100, 4.0)),
        Points(np.arange(1000) % 100 < 2, late),
    ]
    beside = rate_beside(Points(np.zeros(1000, bool), np.full(1000, 6.0)), settings)
    assert beside.curve.value == pytest.approx(0.02)
    assert beside.used == (1,) and len(beside.curve.influence) == 1000


def test_the_first_encounters_that_all_flew_are_compared(flown):
    policy, settings = flown
    short = [settings[0], settings[1].first(1000), settings[2]]
    beside = rate_beside(policy, short)
    assert len(beside.curve.influence) == 1000
    assert beside.own.value == np.mean(policy.collision[:1000])


@pytest.mark.parametrize("share", [1.0, 0.1])
@pytest.mark.parametrize("read", [rate_beside, deviation_beside])
def test_scatter_is_that_of_a_bootstrap(read, share, flown):
    policy, settings = flown
    beside = read(policy, settings)
    interval = (beside.own - share * beside.curve).interval()
    generator, drawn = np.random.default_rng(11), []
    ends = [settings[index] for index in beside.used]
    assert len(ends) == 2
    for _ in range(800):
        rows = generator.integers(0, N, N)
        one, *two = (Points(item.collision[rows], item.deviation_m[rows]) for item in (policy, *ends))
        again = read(one, two)
        drawn.append(again.own.value - share * again.curve.value)
    width = (interval.high - interval.low) / (2 * stats.norm.ppf(0.975))
    assert np.std(drawn) == pytest.approx(width, rel=0.1)
    assert np.mean(drawn) == pytest.approx(interval.value, abs=0.2 * width)
