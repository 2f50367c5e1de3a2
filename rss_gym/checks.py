"""Checks of the numbers and arrays that a library function is handed."""

import numpy as np
import numpy.typing as npt

from rss_gym.params import ParamsError


def finite(name: str, value: npt.ArrayLike, low: float = -np.inf, high: float = np.inf) -> npt.NDArray[np.float64]:
    """`value` as an array of float64, all of it finite and in [low, high].

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
        raise ParamsError(f"{name} must be a number or an array of numbers, got {value!r}")
    array = array.astype(np.float64)
    wrong = array[~(np.isfinite(array) & (array >= low) & (array <= high))]
    if wrong.size:
        bounds = "" if (low, high) == (-np.inf, np.inf) else f" in [{low:g}, {high:g}]"
        raise ParamsError(f"{name} must be finite{bounds}, got {wrong[0]:g}")
    return array


def single(name: str, value: npt.ArrayLike, low: float = -np.inf, high: float = np.inf) -> float:
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
