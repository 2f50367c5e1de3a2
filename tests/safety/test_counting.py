"""Trials of independent looks: against the binomial law, in parts, and against the generator itself."""

import numpy as np
import pytest
from scipy.stats import binomtest

from rss_gym.params import ParamsError
from rss_gym.physics.random import uniform
from rss_gym.safety import miss_probability
from rss_gym.safety.counting import count_missed

TRIALS = 200_000


@pytest.mark.parametrize("probability", [0.5, 0.8, 0.95])
def test_counts_follow_the_formula(probability):
    missed = count_missed(probability, 6, TRIALS, key=7)
    assert missed.shape == (7,) and missed[0] == TRIALS
    for n in range(1, 7):
        assert binomtest(int(missed[n]), TRIALS, float(miss_probability(probability, n))).pvalue > 1e-4


def test_parts_add_up_and_keys_differ():
    whole = count_missed(0.8, 8, 3000, key=1)
    parts = count_missed(0.8, 8, 1000, key=1) + count_missed(0.8, 8, 2000, key=1, first=1000)
    assert np.array_equal(whole, parts)
    assert not np.array_equal(whole, count_missed(0.8, 8, 3000, key=2))


def test_each_look_is_its_own_draw():
    drawn = np.array([[uniform(np.uint64(3), trial, look) for look in range(4)] for trial in range(500)])
    wrong = np.cumprod(drawn > 0.8, axis=1)
    assert count_missed(0.8, 4, 500, key=3).tolist() == [500, *wrong.sum(axis=0)]


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("range_error_probability", (1.0, 8, 10)),
        ("range_error_probability", (float("nan"), 8, 10)),
        ("looks", (0.8, 0, 10)),
        ("looks", (0.8, 2.5, 10)),
        ("trials", (0.8, 8, 0)),
        ("trials", (0.8, 8, True)),
        ("key", (0.8, 8, 10, -1)),
        ("first", (0.8, 8, 10, 0, -1)),
    ],
)
def test_bad_arguments_are_named(name, arguments):
    with pytest.raises(ParamsError, match=name):
        count_missed(*arguments)
