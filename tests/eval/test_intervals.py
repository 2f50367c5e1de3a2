"""Intervals against SciPy, published numbers, and a bootstrap."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from rss_gym.eval.intervals import (
    Interval,
    clopper_pearson,
    mean_t,
    odds_exact,
    overdispersion,
    paired_difference,
    paired_risk_ratio,
    poisson_rate,
    quantile_order_statistics,
    ranks,
    wilson_limits,
)

COUNTS = [(0, 10), (1, 10), (5, 10), (10, 10), (0, 100_000), (1, 100_000), (41_000, 100_000)]
ALTERNATIVE = {"two": "two-sided", "lower": "greater", "upper": "less"}

pairs = st.tuples(st.integers(0, 40), st.integers(0, 40), st.integers(0, 40), st.integers(0, 400))


# Proportions


@pytest.mark.parametrize("side", ALTERNATIVE)
@pytest.mark.parametrize(("k", "n"), COUNTS)
def test_clopper_pearson_is_scipys(k, n, side):
    expected = stats.binomtest(k, n, alternative=ALTERNATIVE[side]).proportion_ci(0.95, "exact")
    found = clopper_pearson(k, n, side=side)
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high), rel=1e-9)
    assert (found.value, found.n) == (k / n, n)


def test_published_clopper_pearson():
    """One collision in 100,000 flights, the paper's Fig. 12 (research/evaluation.md, sec. 0), and the rule of three."""
    found = clopper_pearson(1, 100_000)
    assert (found.low, found.high) == pytest.approx((2.5e-7, 5.6e-5), rel=0.02)
    assert clopper_pearson(0, 10_000, side="upper").high == pytest.approx(3.0e-4, rel=2e-3)


@pytest.mark.parametrize(("k", "n"), COUNTS)
def test_wilson_is_scipys(k, n):
    expected = stats.binomtest(k, n).proportion_ci(0.95, "wilson")
    assert wilson_limits(k, n, 0.025, 0.025) == pytest.approx((expected.low, expected.high), rel=1e-9, abs=1e-15)


def test_odds_exact():
    """20 and 40 events: share 1/3 with the interval of 20 of 60."""
    share = stats.binomtest(20, 60).proportion_ci(0.95, "exact")
    found = odds_exact(20, 40)
    assert found.value == 0.5
    assert (found.low, found.high) == pytest.approx((share.low / (1 - share.low), share.high / (1 - share.high)))


# Means, quantiles, rates


@pytest.mark.parametrize("side", ALTERNATIVE)
@pytest.mark.parametrize("n", [2, 3, 50, 5000])
def test_mean_t_is_scipys(n, side):
    x = np.random.default_rng(n).normal(7.0, 3.0, n)
    expected = stats.ttest_1samp(x, 0.0, alternative=ALTERNATIVE[side]).confidence_interval(0.95)
    found = mean_t(x, side=side)
    ends = [np.inf if end is None else end for end in (found.high,)] + [-np.inf if found.low is None else found.low]
    assert ends == pytest.approx([expected.high, expected.low], rel=1e-9)
    assert found.value == pytest.approx(np.mean(x), rel=1e-12)


@pytest.mark.parametrize("q", [0.001, 0.05, 0.5, 0.8, 0.95])
@pytest.mark.parametrize("n", [1, 5, 59, 60, 1000, 100_000])
def test_ranks_are_the_tightest_that_hold(n, q):
    """P(x_(low) > quantile) = P(B <= low - 1) and P(x_(high) < quantile) = P(B >= high), B binomial (n, q)."""
    low, high = ranks(n, q, 0.025, 0.025)
    below = stats.binom(n, q)
    if low >= 1:
        assert below.cdf(low - 1) <= 0.025
    assert below.cdf(low) > 0.025
    if high <= n:
        assert below.sf(high - 1) <= 0.025 + 1e-15
    assert below.sf(high - 2) > 0.025


def test_median_interval_in_the_textbook():
    """n = 10: x_(2) and x_(9) with 0.9785, found in every table of the sign test."""
    assert ranks(10, 0.5, 0.025, 0.025) == (2, 9)
    assert quantile_order_statistics(np.arange(10.0), 0.5) == Interval(4.5, 1.0, 8.0, 10)


def test_where_no_order_statistic_bounds_a_quantile():
    x = np.array([3.0, 5.0, 4.0])
    assert quantile_order_statistics(x, 0.5) == Interval(4.0, None, None, 3)
    assert quantile_order_statistics(x, 0.005, lowest=0.0) == Interval(3.0, 0.0, 3.0, 3)
    assert quantile_order_statistics(x, 0.95, lowest=0.0, highest=9.0).high == 9.0


@given(st.integers(1, 300), st.floats(0.0005, 0.9995))
def test_quantile_lies_in_its_interval(n, q):
    found = quantile_order_statistics(np.arange(float(n)), q)
    assert found.low is None or found.low <= found.value
    assert found.high is None or found.value <= found.high


@pytest.mark.parametrize("events", [0, 1, 3, 1000])
def test_poisson_is_garwoods(events):
    """Ends are chi-square quantiles."""
    found = poisson_rate(events, 50.0)
    low = stats.chi2.ppf(0.025, 2 * events) / 2 if events else 0.0
    assert (found.low, found.high) == pytest.approx((low / 50.0, stats.chi2.ppf(0.975, 2 * events + 2) / 100.0))
    assert poisson_rate(0, 1.0, side="upper").high == pytest.approx(-np.log(0.05))


def test_overdispersion():
    generator = np.random.default_rng(0)
    exposure = generator.uniform(0.5, 2.0, 20_000)
    assert overdispersion(generator.poisson(0.3 * exposure), exposure) == pytest.approx(1.0, abs=0.05)
    assert overdispersion(5 * generator.poisson(0.3 * exposure), exposure) == pytest.approx(5.0, rel=0.05)
    assert overdispersion(np.zeros(10, int), np.ones(10)) == 1.0


# Pairs


def test_published_paired_intervals():
    """Cavo et al. (2012): 59, 6, 16, 80 pairs; Fagerland, Lydersen, Laake, Statistical Analysis of Contingency Tables,
    chapter 8: Bonett-Price 0.7579 to 0.9910, Newcombe -0.1186 to -0.0046."""
    ratio = paired_risk_ratio(59, 6, 16, 161, limits="wilson")
    assert (ratio.value, ratio.low, ratio.high) == pytest.approx((65 / 75, 0.7579, 0.9910), abs=5e-5)
    difference = paired_difference(59, 6, 16, 161)
    assert (difference.value, difference.low, difference.high) == pytest.approx((-10 / 161, -0.1186, -0.0046), abs=5e-5)


@given(pairs)
def test_exact_ends_contain_wilsons_where_events_are_not_few(counts):
    both, only_a, only_b, neither = counts
    n = both + only_a + only_b + neither
    if both + min(only_a, only_b) < 5:
        return
    exact, wilson = (paired_risk_ratio(both, only_a, only_b, n, limits=limits) for limits in ("exact", "wilson"))
    assert exact.low <= wilson.low * (1 + 1e-3) and wilson.high <= exact.high * (1 + 1e-3)


@given(pairs)
def test_exchanging_the_flights_inverts_the_ratio_and_the_difference(counts):
    both, only_a, only_b, neither = counts
    n = both + only_a + only_b + neither
    forth, back = paired_difference(both, only_a, only_b, n), paired_difference(both, only_b, only_a, n)
    if n:
        assert (forth.value, forth.low, forth.high) == pytest.approx((-back.value, -back.high, -back.low), abs=1e-12)
        assert forth.low <= forth.value <= forth.high
    if both + only_a and both + only_b:
        forth, back = paired_risk_ratio(both, only_a, only_b, n), paired_risk_ratio(both, only_b, only_a, n)
        assert (forth.value, forth.low, forth.high) == pytest.approx((1 / back.value, 1 / back.high, 1 / back.low))
        assert forth.low <= forth.value <= forth.high


@given(pairs)
def test_one_side_at_95_is_two_sides_at_90(counts):
    both, only_a, only_b, neither = counts
    n = both + only_a + only_b + neither
    for interval in (paired_risk_ratio, paired_difference):
        two = interval(both, only_a, only_b, n, confidence=0.9)
        assert interval(both, only_a, only_b, n, side="lower").low == pytest.approx(two.low)
        assert interval(both, only_a, only_b, n, side="upper").high == pytest.approx(two.high)


@given(pairs)
def test_more_events_raise_the_upper_bound(counts):
    both, only_a, only_b, neither = counts
    if both + only_b == 0:
        return
    n = both + only_a + only_b + neither + 1
    bound = paired_risk_ratio(both, only_a, only_b, n, side="upper").high
    assert paired_risk_ratio(both, only_a + 1, only_b, n, side="upper").high > bound


def test_pairs_without_an_event_do_not_matter_to_the_ratio():
    assert paired_risk_ratio(10, 3, 40, 100)[:3] == paired_risk_ratio(10, 3, 40, 100_000)[:3]


def test_paired_intervals_against_a_bootstrap():
    """Percentile bootstrap on counts large enough for it to be right."""
    counts, n = (300, 60, 500), 2000
    draws = np.random.default_rng(0).multinomial(n, [*(c / n for c in counts), 1 - sum(counts) / n], 20_000)
    a, b = draws[:, 0] + draws[:, 1], draws[:, 0] + draws[:, 2]
    ratio, difference = paired_risk_ratio(*counts, n), paired_difference(*counts, n)
    assert [ratio.low, ratio.high] == pytest.approx(np.quantile(a / b, [0.025, 0.975]), rel=0.015)
    assert [difference.low, difference.high] == pytest.approx(np.quantile((a - b) / n, [0.025, 0.975]), rel=0.015)


# What is not defined, and what is not allowed


def test_nothing_gives_nothing():
    nothing = Interval(None, None, None, 0)
    empty = np.empty(0)
    assert clopper_pearson(0, 0) == mean_t(empty) == quantile_order_statistics(empty, 0.5) == nothing
    assert poisson_rate(0, 0.0) == odds_exact(0, 0) == nothing
    assert paired_risk_ratio(0, 0, 0, 0) == paired_difference(0, 0, 0, 0) == nothing
    assert paired_risk_ratio(0, 3, 0, 10) == Interval(None, None, None, 10)
    assert odds_exact(3, 0) == Interval(None, None, None, 3)
    assert mean_t(np.array([4.0])) == Interval(4.0, None, None, 1)


def test_what_cannot_be_is_refused():
    with pytest.raises(ValueError, match="got 3 of 2"):
        clopper_pearson(3, 2)
    with pytest.raises(ValueError, match="are no counts of 5 pairs"):
        paired_risk_ratio(3, 3, 3, 5)
    with pytest.raises(ValueError, match="are no counts of 5 pairs"):
        paired_difference(-1, 3, 3, 5)
    with pytest.raises(ValueError, match="confidence must lie between 0 and 1, got 95"):
        clopper_pearson(1, 2, confidence=95)
    with pytest.raises(ValueError, match="side must be"):
        clopper_pearson(1, 2, side="both")
    with pytest.raises(ValueError, match="q must lie between 0 and 1"):
        quantile_order_statistics(np.arange(3.0), 1.0)
