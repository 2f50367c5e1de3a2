"""Uneven samples on a constant period."""

import numpy as np
import pytest

from rss_gym.params import ParamsError
from rss_gym.radio import regular


def test_even_samples_stay():
    x = np.random.default_rng(0).normal(size=50)
    records, period_s = regular(3.0 + 0.1 * np.arange(50), x)
    assert period_s == pytest.approx(0.1)
    assert len(records) == 1
    np.testing.assert_array_equal(records[0], x)


def test_nearest_sample_and_gaps():
    t = [0.0, 1.0, 2.1, 3.0, 5.0, 6.0, 20.0, 21.0, 22.0, 40.0, 41.0]
    records, period_s = regular(t, np.arange(11.0))
    assert period_s == 1.0
    # 4.0 s was lost: the two neighbours are as near, and the earlier is taken. The pair at the end is too short.
    np.testing.assert_array_equal(records[0], [0.0, 1.0, 2.0, 3.0, 3.0, 4.0, 5.0])
    np.testing.assert_array_equal(records[1], [6.0, 7.0, 8.0])
    assert len(records) == 2


@pytest.mark.parametrize(
    ("t", "x", "says"),
    [
        ([0.0, 1.0, 2.0], [1.0, 2.0], "one length, got 3 and 2"),
        ([0.0, 1.0], [1.0, 2.0], "at least 3"),
        ([0.0, 1.0, 1.0], [1.0, 2.0, 3.0], "rise"),
        ([0.0, 1.0, np.nan], [1.0, 2.0, 3.0], "time_s must be finite"),
        ([0.0, 1.0, 2.0], [1.0, np.nan, 3.0], "nan at element 1"),
        ([0.0, 0.1, 9.0, 9.1, 18.0, 18.1, 27.0, 27.1], np.zeros(8), "gap"),
    ],
)
def test_bad_input(t, x, says):
    with pytest.raises(ParamsError, match=says):
        regular(t, x)
