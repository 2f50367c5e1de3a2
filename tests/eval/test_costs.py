"""Costs of encounters: the arithmetic, and intervals that hold where collisions are rare."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.eval.costs import SCORE, Costs, Prices, cost_m
from rss_gym.eval.intervals import Interval, mean_t
from rss_gym.params import Params

SETS = 300  # estimate a coverage of 0.95 with a standard deviation of 0.013
FLOOR = 0.915


def of(deviation_m, snmac, collision, prices=SCORE):
    """Costs of these flights."""
    snmac, collision = np.asarray(snmac, bool), np.asarray(collision, bool)
    return Costs(cost_m(np.asarray(deviation_m, float), snmac, collision, prices), snmac, collision, prices)


def test_one_collision_in_ten_thousand_weighs_as_a_metre():
    n = 10_000
    events = np.arange(n) < 1
    assert of(np.full(n, 7.0), np.zeros(n), events).mean_m == pytest.approx(8.0)
    assert of(np.full(n, 7.0), np.arange(n) < 100, np.zeros(n)).mean_m == pytest.approx(8.0)


def test_prices_are_those_of_the_world():
    assert Prices.of(Params()) == SCORE == Prices(1.0, 100.0, 10_000.0)
    params = Params.of(deviation_price=2.0, snmac_price_m=3.0, collision_price_m=5.0)
    assert cost_m(10.0, True, True, Prices.of(params)) == 28.0
    assert of([10.0, 10.0], [1, 0], [1, 0], Prices.of(params)).deviation_m.tolist() == [20.0, 20.0]


def test_without_events_the_interval_of_the_deviation_is_raised_by_what_none_of_n_allows():
    n, deviation_m = 1000, np.random.default_rng(0).exponential(10.0, 1000)
    found, student = of(deviation_m, np.zeros(n), np.zeros(n)).interval(), mean_t(deviation_m)
    assert found.value == pytest.approx(student.value)
    assert found.low == pytest.approx(student.low)
    unseen = 1.0 - 0.025 ** (1 / n)
    expected = np.sqrt((student.high - student.value) ** 2 + (100.0 * unseen) ** 2 + (10_000.0 * unseen) ** 2)
    assert found.high == pytest.approx(found.value + expected)


def test_few_flights():
    assert of([], [], []).interval() == Interval(None, None, None, 0)
    assert of([3.0], [0], [0]).interval() == Interval(3.0, None, None, 1)
    assert of([3.0], [0], [0]).minus(of([1.0], [0], [0])) == Interval(2.0, None, None, 1)
    low = of([1.0, 90.0], [0, 0], [0, 0]).interval().low
    assert low == 0.0  # no cost is below


def test_other_encounters_or_prices_are_not_compared():
    with pytest.raises(ValueError, match="same encounters"):
        of([1.0], [0], [0]).minus(of([1.0, 2.0], [0, 0], [0, 0]))
    with pytest.raises(ValueError, match="same prices"):
        of([1.0], [0], [0]).minus(of([1.0], [0], [0], Prices(collision_m=1.0)))


# Encounters, probability of an sNMAC (collisions among them) and of a collision.
CASES = [
    (300, 0.02, 0.003),
    (1000, 0.003, 0.001),
    (2000, 0.05, 0.02),
    (2000, 0.01, 5e-4),
    (1000, 0.9, 0.4),
    (4000, 2e-3, 1e-4),
]


def drawn(generator, uniform, snmac, collision):
    """Flights whose events are where the uniform numbers are small; a collision halves the deviation."""
    n = len(uniform)
    deviation_m = generator.lognormal(1.5, 0.8, n) * np.where(uniform < collision, 0.5, 1.0)
    return of(deviation_m, uniform < snmac, uniform < collision)


def truth(snmac, collision):
    return np.exp(1.5 + 0.32) * (1.0 - 0.5 * collision) + 100.0 * snmac + 10_000.0 * collision


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_intervals_cover(case):
    """Student's covers down to 0.4 here, as most sets hold no collision."""
    n, snmac, collision = case
    generator = np.random.default_rng(n)
    found = [drawn(generator, generator.random(n), snmac, collision).interval() for _ in range(SETS)]
    assert np.mean([low <= truth(snmac, collision) <= high for _, low, high, _ in found]) >= FLOOR


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("shared", [0.0, 0.8])
def test_paired_intervals_cover(case, shared):
    """The other has half as many events again; they share their bad luck in most encounters or in none."""
    n, snmac, collision = case
    snmac, collision = min(snmac, 0.6), min(collision, 0.3)
    generator = np.random.default_rng(n + 1)
    expected = truth(snmac, collision) - truth(1.5 * snmac, 1.5 * collision)
    inside = []
    for _ in range(SETS):
        one = generator.random(n)
        two = np.where(generator.random(n) < shared, one, generator.random(n))
        costs = drawn(generator, one, snmac, collision), drawn(generator, two, 1.5 * snmac, 1.5 * collision)
        _, low, high, _ = costs[0].minus(costs[1])
        inside.append(low <= expected <= high)
    assert np.mean(inside) >= FLOOR


def test_intervals_against_a_bootstrap():
    """With many events, where the percentile bootstrap is right: the mean, and a paired difference."""
    generator = np.random.default_rng(5)
    uniform = generator.random(3000)
    one, two = drawn(generator, uniform, 0.3, 0.1), drawn(generator, 1.0 - uniform, 0.35, 0.12)
    rows = generator.integers(0, 3000, (4000, 3000))
    for found, values in ((one.interval(), one.cost_m), (one.minus(two), one.cost_m - two.cost_m)):
        low, high = np.quantile(values[rows].mean(axis=1), [0.025, 0.975])
        width = high - low
        assert found.low == pytest.approx(low, abs=0.05 * width)
        assert found.high == pytest.approx(high, abs=0.05 * width)


def test_pairs_narrow():
    """Two policies that collide in the same encounters differ by their deviations alone."""
    n = 5000
    generator = np.random.default_rng(1)
    events, deviation_m = np.arange(n) < 50, generator.exponential(5.0, n)
    one, two = of(deviation_m, events, events), of(deviation_m + 1.0, events, events)
    difference = one.minus(two)
    assert difference.value == pytest.approx(-1.0)
    width = one.interval().high - one.interval().low
    assert difference.high - difference.low < 0.4 * width


@given(st.integers(2, 60), st.integers(0, 2**32))
def test_an_interval_holds_its_value_and_a_difference_turns_round(n, seed):
    generator = np.random.default_rng(seed)
    one, two = (drawn(generator, generator.random(n), 0.5, 0.3) for _ in range(2))
    for _, low, high, _ in (found := (one.interval(), two.interval())):
        assert 0.0 <= low <= high
    assert all(value is not None for value, *_ in found)
    there, back = one.minus(two), two.minus(one)
    assert there.low <= there.value <= there.high
    assert (there.value, there.low, there.high) == pytest.approx((-back.value, -back.high, -back.low))
    order = generator.permutation(n)
    shuffled = [Costs(c.cost_m[order], c.snmac[order], c.collision[order]) for c in (one, two)]
    assert shuffled[0].interval() == one.interval() and shuffled[0].minus(shuffled[1]) == there
