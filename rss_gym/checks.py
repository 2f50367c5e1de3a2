"""Checks of the numbers and arrays that a library function is handed, each with one sentence for what is wrong."""

from __future__ import annotations

import math
import numbers
from typing import Any

import numpy as np
import numpy.typing as npt

from rss_gym.params import ParamsError

Floats = npt.NDArray[np.floating[Any]]  # what NumPy says its arithmetic returns


def finite(
    name: str,
    value: npt.ArrayLike,
    low: float = -math.inf,
    high: float = math.inf,
    dimensions: tuple[int, ...] = (),
) -> npt.NDArray[np.float64]:
    """`value` as an array of float64, all of it finite and in [low, high].

    With `dimensions` it must not be empty and have one of these numbers of dimensions.

    Raises
    ------
    ParamsError
        Naming the argument and the first value that is not.
    """
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        array = np.asarray(None)
    if array.dtype.kind not in "iuf":
        raise ParamsError(f"{name} must be a number or an array of numbers, got {value!r}"[:300])
    if dimensions and (array.ndim not in dimensions or array.size == 0):
        wanted = " or ".join(f"{n}-D" for n in dimensions)
        raise ParamsError(f"{name} must be a {wanted} array that is not empty, got shape {array.shape}")
    array = array.astype(np.float64)
    right = np.isfinite(array) & (array >= low) & (array <= high)
    if not right.all():
        bounds = "" if (low, high) == (-math.inf, math.inf) else f" in [{low:g}, {high:g}]"
        first = int(np.argmin(right))
        where = f" at element {first}" if array.ndim else ""
        raise ParamsError(f"{name} must be finite{bounds}, got {array.flat[first]:g}{where}")
    return array


def single(name: str, value: npt.ArrayLike, low: float = -math.inf, high: float = math.inf) -> float:
    """`value` as one finite number in [low, high]; raises as `finite` does."""
    array = finite(name, value, low, high)
    if array.ndim:
        raise ParamsError(f"{name} must be one number, got an array of shape {array.shape}")
    return float(array)


def together(**given: tuple[npt.ArrayLike, *tuple[float, ...]]) -> tuple[npt.NDArray[np.float64], ...]:
    """Each argument, a value with its limits if any, as `finite` gives it, broadcast against the others.

    Raises
    ------
    ParamsError
        As `finite`, or naming the shapes that do not broadcast.
    """
    arrays = {name: finite(name, *value) for name, value in given.items()}
    try:
        return tuple(np.broadcast_arrays(*arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise ParamsError(f"the arguments' shapes must broadcast against each other, got {shapes}") from None


def distances(values: npt.ArrayLike, dimensions: tuple[int, ...] = (1, 2)) -> npt.NDArray[np.float64]:
    """`values` as true distances, `distance_m`: an array of finite numbers above 0."""
    array = finite("distance_m", values, dimensions=dimensions)
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
