"""Checks of arguments: what passes comes back as float64, what does not is named."""

import numpy as np
import pytest

from rss_gym.checks import finite, single, together
from rss_gym.params import ParamsError


def test_numbers_become_float64():
    for value in (3, 3.0, np.int8(3), np.float32(3.0), [3], np.array([[3]])):
        array = finite("x_m", value, 0.0, 3.0)
        assert array.dtype == np.float64 and (array == 3.0).all() and array.shape == np.shape(value)
    assert finite("x_m", []).size == 0
    assert single("x_m", np.int64(3)) == 3.0


def test_the_argument_is_not_touched():
    given = np.array([1.0, 2.0])
    finite("x_m", given)[0] = 9.0
    assert given[0] == 1.0


@pytest.mark.parametrize("value", [None, "3", True, [True], 1j, [1.0, None], [[1.0], [1.0, 2.0]], {}])
def test_what_is_no_number(value):
    with pytest.raises(ParamsError, match=r"^x_m must be a number or an array of numbers, got "):
        finite("x_m", value)


@pytest.mark.parametrize(
    ("value", "shown"), [(np.nan, "nan"), ([1.0, np.inf], "inf"), (-0.5, "-0.5"), ([0, 7, 8], "7")]
)
def test_the_first_wrong_value_is_named(value, shown):
    with pytest.raises(ParamsError, match=rf"^x_m must be finite in \[0, 6\], got {shown}( at element \d)?$"):
        finite("x_m", value, 0.0, 6.0)


def test_one_number_is_no_array():
    with pytest.raises(ParamsError, match=r"^x_m must be one number, got an array of shape \(1,\)$"):
        single("x_m", [3.0])


def test_together_broadcasts_or_names_the_shapes():
    a, b = together(a_m=(np.ones((2, 1)), 0.0), b_m=([1, 2, 3],))
    assert a.shape == b.shape == (2, 3)
    with pytest.raises(ParamsError, match=r"must broadcast against each other, got a_m \(2,\), b_m \(3,\)$"):
        together(a_m=([1, 2],), b_m=([1, 2, 3],))
    with pytest.raises(ParamsError, match=r"^b_m must be finite in \[0, 1\], got 2$"):
        together(a_m=(1.0,), b_m=(2.0, 0.0, 1.0))
