"""The order of policies: by hand, and its properties on random ones."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.eval.intervals import paired_risk_ratio
from rss_gym.eval.metrics import measure
from rss_gym.eval.ranking import ALPHA, Candidate, rank

N = 2000
NONE = np.arange(N) < 800  # encounters in which `none` collides


def entry(name, collided, deviation_m, faults=0):
    """An entry that collides in the encounters given."""
    collision = np.zeros(N, np.bool_)
    collision[list(collided)] = True
    counts = [np.count_nonzero(x) for x in (collision & NONE, collision & ~NONE, ~collision & NONE)]
    upper = paired_risk_ratio(*counts, N, side="upper").high
    return Candidate(name, faults, upper, deviation_m, np.arange(N), collision)


def names(places):
    """In order."""
    return [place.name for place in places]


def test_by_hand():
    """`a` leads; `b` is not told apart (3 against 0, p = 0.25) and deviates less; `c` and `none` are."""
    entries = [
        entry("none", range(800), 1.0),
        entry("a", [], 30.0),
        entry("b", range(3), 10.0),
        entry("c", range(50), 5.0),
        entry("broken", [], 0.0, faults=1),
    ]
    places = rank(entries)
    assert names(places) == ["b", "a", "c", "none", "broken"]
    assert [place.place for place in places] == [1, 2, 3, 4, 5]
    assert [place.group for place in places] == [1, 1, 2, 3, None]
    assert [place.leader for place in places] == ["a", "a", "c", "none", None]
    # The greatest of three: unchanged by Holm
    assert places[0].p_adjusted == pytest.approx(0.25)
    assert [place.p_adjusted for place in places[1:]] == [None] * 4


def test_holm_spares_an_entry_that_one_test_would_separate():
    """7 against 0 has p = 0.0156; after Holm over four such comparisons 0.0625."""
    alone = rank([entry("safe", [], 9.0), entry("risky-0", range(7), 1.0)])
    assert names(alone) == ["safe", "risky-0"]
    five = [entry("safe", [], 9.0)] + [entry(f"risky-{i}", range(7 * i, 7 * i + 7), 1.0 + i) for i in range(4)]
    assert names(rank(five)) == ["risky-0", "risky-1", "risky-2", "risky-3", "safe"]


def test_ties_go_by_name():
    entries = [entry(name, [1], 5.0) for name in "dbca"]
    assert names(rank(entries)) == ["a", "b", "c", "d"]


def test_faulty_entries_come_last_and_change_nothing():
    entries = [entry("a", [], 30.0), entry("c", range(50), 5.0)]
    broken = [entry("x", [], 0.0, faults=9), entry("y", [], 0.0, faults=2), entry("z", [], float("nan"), faults=1)]
    with pytest.raises(ValueError, match="'z' has a score that is not finite"):
        rank(entries + broken)
    places = rank(entries + broken[:2])
    assert names(places) == ["a", "c", "y", "x"]
    assert places[:2] == rank(entries)


def test_without_collisions_of_none():
    """The ratio is undefined for everybody: collisions are compared all the same."""
    collision = np.arange(N) < 30
    entries = [
        Candidate("hits", 0, None, 1.0, np.arange(N), collision),
        Candidate("misses", 0, None, 2.0, np.arange(N), ~(NONE | ~NONE)),
    ]
    assert names(rank(entries)) == ["misses", "hits"]


def test_none_and_one():
    assert rank([]) == []
    assert names(rank([entry("a", [], 1.0)])) == ["a"]


def test_entries_from_flights(random_flights, make_flights):
    flights = random_flights(500)
    one, other = Candidate.of("one", flights), Candidate.of("none", make_flights(flights.none, flights.none))
    assert one.risk_ratio_upper == measure(flights)["risk_ratio_upper"].value
    assert names(rank([other, one])) == ["one", "none"]
    with pytest.raises(ValueError, match="'none' is given twice"):
        rank([other, other])
    with pytest.raises(ValueError, match="different encounters"):
        rank([one, Candidate.of("two", random_flights(400))])
    with pytest.raises(ValueError, match="'nobody' has no flights"):
        Candidate.of("nobody", random_flights(0))


policies = st.lists(
    st.tuples(st.integers(0, 40), st.integers(0, 900), st.sampled_from([1.0, 2.0, 3.0]), st.integers(0, 1)),
    min_size=1,
    max_size=7,
)


@given(policies, st.randoms())
def test_properties(drawn, random):
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
    # Faults last; groups in order; within a group by deviation, and nobody told apart from the leader
    faulty = [by_name[place.name].faults > 0 for place in places]
    assert faulty == sorted(faulty)
    ranked = [place for place in places if place.group is not None]
    assert [place.group for place in ranked] == sorted(place.group for place in ranked)
    bounds = []
    for _, members in itertools.groupby(ranked, key=lambda place: place.group):
        group = list(members)
        deviations = [by_name[place.name].path_deviation_mean_m for place in group]
        assert deviations == sorted(deviations)
        assert all(place.p_adjusted is None or place.p_adjusted >= ALPHA for place in group)
        bound = by_name[group[0].leader].risk_ratio_upper
        assert bound == min(by_name[place.name].risk_ratio_upper for place in group)
        bounds.append(bound)
    # Each leader's bound is worse than the one's before
    assert bounds == sorted(bounds)
