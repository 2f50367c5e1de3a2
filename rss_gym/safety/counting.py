"""The counting behind (32) and (36), trial by trial: how many looks in a row err by more than delta."""

import numpy as np
import numpy.typing as npt

from rss_gym.checks import single
from rss_gym.jit import kernel
from rss_gym.params import ParamsError
from rss_gym.physics.random import uniform
from rss_gym.safety.zone import PROBABILITY


@kernel
def _count(key, first, trials, looks, probability, ended):  # type: ignore[no-untyped-def]
    """Add to `ended[n]` the trials, from number `first` on, that end after n wrong looks."""
    for trial in range(first, first + trials):
        n = 0
        while n < looks and uniform(key, trial, n) > probability:
            n += 1
        ended[n] += 1


def count_missed(
    range_error_probability: float, looks: int, trials: int, key: int = 0, first: int = 0
) -> npt.NDArray[np.int64]:
    """Run trials of independent looks, each wrong with probability 1 - P(delta), until one is right.

    Parameters
    ----------
    range_error_probability : float
        P(delta) of (31).
    looks : int
        Most looks in a trial, 1 to 1000.
    trials : int
        Trials to run, 1 to 2^31.
    key : int
        The key of the random numbers, 0 to 2^63 - 1; each trial draws from its own stream.
    first : int
        Number of the first trial, 0 to 2^31: a long run may be cut into parts, whose counts add up.

    Returns
    -------
    ndarray of int64, shape (looks + 1,)
        Trials whose first n looks all err, for n = 0 to `looks`; divided by `trials` it estimates (36).

    Raises
    ------
    ParamsError
        When an argument is out of its range.
    """
    probability = single("range_error_probability", range_error_probability, *PROBABILITY)
    limits = {"looks": (1, 1000), "trials": (1, 2**31), "key": (0, 2**63 - 1), "first": (0, 2**31)}
    for (name, (low, high)), value in zip(limits.items(), (looks, trials, key, first), strict=True):
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not low <= value <= high:
            raise ParamsError(f"{name} must be a whole number in [{low}, {high}], got {value!r}")
    ended = np.zeros(int(looks) + 1, np.int64)
    _count(np.uint64(key), np.int64(first), np.int64(trials), np.int64(looks), probability, ended)
    return ended[::-1].cumsum()[::-1]
