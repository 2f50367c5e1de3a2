"""The order of policies: by hand, and its properties on random ones."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.eval.costs import SCORE, Costs, cost_m
from rss_gym.eval.ranking import Candidate, front, rank

N = 2000


def entry(name, collided=(), deviation_m=10.0, faults=0, snmac=()):
    """An entry that collides in the encounters given; each is an sNMAC too."""
    collision, near = np.zeros(N, bool), np.zeros(N, bool)
    collision[list(collided)] = True
    near[[*collided, *snmac]] = True
    return Candidate(name, faults, Costs(cost_m(deviation_m, near, collision), near, collision), np.arange(N))


def names(places):
    """In order."""
    return [place.name for place in places]


def test_by_hand():
    """A collision of 2,000 costs 5.05 m with its sNMAC."""
    entries = [
        entry("none", range(800), 1.0),  # 4,041
        entry("a", [], 30.0),  # 30
        entry("b", range(3), 10.0),  # 25.15
        entry("c", range(50), 5.0),  # 257.5
        entry("d", [], 31.0, snmac=range(20)),  # 32
        entry("broken", [], 0.0, faults=1),
    ]
    places = rank(entries)
    assert names(places) == ["b", "a", "d", "c", "none", "broken"]
    assert [place.place for place in places] == [1, 2, 3, 4, 5, None]
    assert [round(place.difference.value, 2) for place in places[1:5]] == [4.85, 6.85, 232.35, 4015.85]
    assert places[0].difference is None and places[-1].difference is None
    # `a` and `b` are not told apart: 3 collisions against none. `c` is.
    assert places[1].difference.low < 0.0 < places[1].difference.high
    assert places[3].difference.low > 0.0
    assert [place.front for place in places] == [True, True, False, True, True, False]
    assert [place.why_not for place in places] == [""] * 5 + ["not ranked: 1 fault"]


def test_differences_are_those_of_the_costs():
    entries = [entry("a", range(5), 10.0), entry("b", range(3, 9), 12.0)]
    first, second = rank(entries)
    assert second.difference == entries[1].costs.minus(entries[0].costs)
    assert rank(entries, differences=False)[1].difference is None and first.name == "a"


def test_ties_go_by_name():
    entries = [entry(name, [1], 5.0) for name in "dbca"]
    assert names(rank(entries)) == ["a", "b", "c", "d"]
    assert all(place.front for place in rank(entries))  # none beats another


def test_entries_with_faults_are_not_ranked_however_cheap():
    entries = [entry("a", [], 30.0), entry("c", range(50), 5.0)]
    broken = [entry("x", [], 0.0, faults=9), entry("b", [], 0.0, faults=2)]
    places = rank(entries + broken)
    assert names(places) == ["a", "c", "b", "x"]
    assert places[:2] == rank(entries)
    assert [place.place for place in places[2:]] == [None, None]
    assert places[3].why_not == "not ranked: 9 faults"


def test_none_and_one():
    assert rank([]) == []
    assert names(rank([entry("a")])) == ["a"]
    assert [place.place for place in rank([entry("a", faults=3)])] == [None]


def test_what_cannot_be_ranked():
    with pytest.raises(ValueError, match="'z' has a cost that is not finite"):
        rank([entry("z", [], float("nan"))])
    with pytest.raises(ValueError, match="'a' is given twice"):
        rank([entry("a"), entry("a")])


def test_entries_from_flights(random_flights):
    flights = random_flights(500)
    one, other = (Candidate.of(name, table, SCORE) for name, table in (("one", flights.table), ("none", flights.none)))
    assert one.costs.mean_m == pytest.approx(float(np.mean(flights.table["cost_m"])))
    assert names(rank([other, one])) == ["one", "none"]
    with pytest.raises(ValueError, match="different encounters"):
        rank([one, Candidate.of("two", random_flights(400).table, SCORE)])
    with pytest.raises(ValueError, match="'nobody' has no flights"):
        rank([Candidate.of("nobody", random_flights(0).table, SCORE)])


policies = st.lists(
    st.tuples(st.integers(0, 40), st.integers(0, 900), st.sampled_from([1.0, 2.0, 3.0]), st.integers(0, 1)),
    min_size=1,
    max_size=7,
)


@given(policies, st.randoms(), st.integers(1, 7))
def test_properties(drawn, random, few):
    entries = [
        entry(f"p{i}", range(start, start + count), deviation, faults)
        for i, (count, start, deviation, faults) in enumerate(drawn)
    ]
    places = rank(entries)
    by_name = {one.name: one for one in entries}
    # Everybody once, whatever the order given
    assert sorted(names(places)) == sorted(by_name)
    shuffled = list(entries)
    random.shuffle(shuffled)
    assert rank(shuffled) == places
    # Faults last; the rest by cost, with the places 1, 2, ...
    assert [place.place is None for place in places] == sorted(by_name[place.name].faults > 0 for place in places)
    ranked = [by_name[place.name] for place in places if place.place is not None]
    assert [place.place for place in places[: len(ranked)]] == list(range(1, len(ranked) + 1))
    assert [one.costs.mean_m for one in ranked] == sorted(one.costs.mean_m for one in ranked)
    # Whom else one adds changes the order of nobody
    some = shuffled[:few]
    kept = {one.name for one in some}
    assert names(rank(some)) == [name for name in names(places) if name in kept]
    # The cheapest of all by whatever prices is on the front, so the first is
    assert not ranked or places[0].front


@given(st.lists(st.tuples(st.integers(0, 4), st.integers(0, 4)), max_size=8))
def test_the_front_is_what_nobody_beats(drawn):
    points = [(float(x), float(y)) for x, y in drawn]
    marks = front(points)
    for mark, (x, y) in zip(marks, points, strict=True):
        better = [p for p in points if (p[0] < x and p[1] <= y) or (p[0] <= x and p[1] < y)]
        assert mark == (not better)
