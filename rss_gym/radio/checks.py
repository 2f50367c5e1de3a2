"""Checks of what a caller hands in, each with one sentence for what is wrong."""

from __future__ import annotations

import math
import numbers
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rss_gym.params import ParamsError

Floats = NDArray[np.floating[Any]]


def finite(name: str, values: Any, shapes: tuple[int, ...] = (1,)) -> Floats:
    """`values` as an array of finite numbers with one of the numbers of dimensions in `shapes`."""
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "iuf":
            raise ValueError(f"its type is {array.dtype}")
    except ValueError as error:  # lists of unequal length too
        raise ParamsError(f"{name} must be an array of numbers: {error}") from error
    if array.ndim not in shapes or array.size == 0:
        wanted = " or ".join(f"{n}-D" for n in shapes)
        raise ParamsError(f"{name} must be a {wanted} array that is not empty, got shape {array.shape}")
    array = array.astype(np.float64)
    if not np.isfinite(array).all():
        where = int(np.argmin(np.isfinite(array)))
        raise ParamsError(f"{name} must be finite, got {array.flat[where]} at element {where}; leave lost samples out")
    return array


def distances(values: Any, shapes: tuple[int, ...] = (1, 2)) -> Floats:
    """`values` as true distances: an array of finite numbers above 0."""
    array = finite("distance_m", values, shapes)
    if array.min() <= 0.0:
        raise ParamsError(f"distance_m must be above 0, got {array.min():g} at element {int(np.argmin(array))}")
    return array


def positive(name: str, value: Any, high: float = math.inf) -> float:
    """`value` as a finite number in (0, high]."""
    kind: Any = numbers.Real  # NumPy's scalars too
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, kind):
        raise ParamsError(f"{name} must be a number, got {value!r}")
    if not (0.0 < value <= high and value < math.inf):
        limit = "" if high == math.inf else f" and at most {high:g}"
        raise ParamsError(f"{name} must be finite, above 0{limit}, got {value!r}")
    return float(value)


def whole(name: str, value: Any, high: int) -> int:
    """`value` as a whole number in [0, high)."""
    kind: Any = numbers.Integral
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, kind) or not 0 <= value < high:
        raise ParamsError(f"{name} must be a whole number in [0, {high}), got {value!r}")
    return int(value)
