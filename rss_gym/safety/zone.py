"""The safety zone, (29)-(37) and (40): kernels of the world, and the same equations on arrays.

Arguments of the functions on arrays broadcast against each other; scalars give a scalar. Whatever is not finite or out
of its range raises `ParamsError`.
"""

import numpy as np
import numpy.typing as npt

from rss_gym.checks import finite, together
from rss_gym.jit import kernel
from rss_gym.params import ParamsError

# 80 % of a normal error lies within this many standard deviations; turns a filter's std into delta of (31).
STD_TO_80_PERCENT = 1.2815515655446004

PROBABILITY = 1e-6, 1.0 - 1e-6  # P(delta) of (31) at the least and at the most

Floats = npt.NDArray[np.float64]


@kernel(inline="always")
def zone_radius_m(range_error_m, range_error_probability, speed_relative_mps, reaction_s, trials):
    """S of (40): (delta / P(delta) + |v| t_r) n_d."""
    return (range_error_m / range_error_probability + speed_relative_mps * reaction_s) * trials


@kernel(inline="always")
def violates(range_m, radius_m):
    """(29): a warning is due."""
    return range_m <= radius_m


def perfect_radius_m(speed_relative_mps: npt.ArrayLike, reaction_s: npt.ArrayLike) -> Floats:
    """(30): radius (m) that perfect ranging needs, |v| t_r.

    Parameters
    ----------
    speed_relative_mps : array_like
        Largest relative speed of the pair, >= 0.
    reaction_s : array_like
        t_r, >= 0.
    """
    speed, reaction = together(speed_relative_mps=(speed_relative_mps, 0.0), reaction_s=(reaction_s, 0.0))
    return speed * reaction


def error_probability(errors_m: npt.ArrayLike, range_error_m: npt.ArrayLike) -> Floats:
    """(31), P(delta) measured: share of the errors that are at most `range_error_m` in size.

    Parameters
    ----------
    errors_m : array_like, shape (n,)
        Errors of a range estimate; the sign does not matter.
    range_error_m : array_like
        delta, >= 0.
    """
    errors = np.sort(np.abs(finite("errors_m", errors_m)).ravel())
    if errors.size == 0:
        raise ParamsError("errors_m must hold at least one error, got none")
    return np.searchsorted(errors, finite("range_error_m", range_error_m, 0.0), side="right") / errors.size


def error_probability_normal(std_m: npt.ArrayLike, range_error_m: npt.ArrayLike) -> Floats:
    """(33), P(delta) of a normal error of mean 0: the integral of the density of its size from 0 to `range_error_m`."""
    from scipy.special import erf

    std, delta = together(std_m=(std_m, 1e-9), range_error_m=(range_error_m, 0.0))
    return erf(delta / (np.sqrt(2.0) * std))


def miss_probability(range_error_probability: npt.ArrayLike, trials: npt.ArrayLike) -> Floats:
    """(32) and (36): probability (1 - P)^n that `trials` independent errors all exceed delta; bounds a collision's."""
    probability, looks = together(range_error_probability=(range_error_probability, *PROBABILITY), trials=(trials, 1.0))
    return (1.0 - probability) ** looks


def missed_detection(distance_m: npt.ArrayLike, estimate_m: npt.ArrayLike, radius_m: npt.ArrayLike) -> float:
    """Left side of (34), measured: share of the looks without a warning at which the true distance was in the zone.

    (34) bounds it by 1 - P(delta), and (35) takes it as bound of the collision probability. It is NaN when every look
    gave a warning.
    """
    distance, estimate, radius = together(
        distance_m=(distance_m, 0.0), estimate_m=(estimate_m, 0.0), radius_m=(radius_m, 0.0)
    )
    silent = estimate > radius
    return float(np.mean(distance[silent] <= radius[silent])) if silent.any() else np.nan


def trials(range_error_probability: npt.ArrayLike, collision_probability: npt.ArrayLike) -> npt.NDArray[np.int64]:
    """(37): n_d, the fewest independent looks whose miss probability (36) is at most `collision_probability`."""
    probability, target = together(
        range_error_probability=(range_error_probability, *PROBABILITY),
        collision_probability=(collision_probability, 1e-300, 1.0 - 1e-9),
    )
    # A target that is a power of 1 - P to rounding takes that power.
    return np.ceil(np.log(target) / np.log(1.0 - probability) - 1e-12).astype(np.int64)[()]


def radius_m(
    range_error_m: npt.ArrayLike,
    range_error_probability: npt.ArrayLike,
    speed_relative_mps: npt.ArrayLike,
    reaction_s: npt.ArrayLike,
    trials: npt.ArrayLike,
) -> Floats:
    """(40): radius S (m) of the zone under imperfect ranging, by `zone_radius_m`.

    Parameters
    ----------
    range_error_m, range_error_probability : array_like
        delta and P(delta) of (31).
    speed_relative_mps, reaction_s : array_like
        Largest relative speed and t_r, as in (30).
    trials : array_like
        n_d of (37), >= 1.
    """
    arguments = together(
        range_error_m=(range_error_m, 0.0),
        range_error_probability=(range_error_probability, *PROBABILITY),
        speed_relative_mps=(speed_relative_mps, 0.0),
        reaction_s=(reaction_s, 0.0),
        trials=(trials, 1.0),
    )
    # Flat copies: one type of argument, so the kernel is compiled once.
    return zone_radius_m(*(a.flatten() for a in arguments)).reshape(arguments[0].shape)[()]


def pair_radius_m(radius_i_m: npt.ArrayLike, radius_j_m: npt.ArrayLike) -> Floats:
    """S_ij of two aircraft whose zones differ: the smaller one (Sec. VII)."""
    return np.minimum(*together(radius_i_m=(radius_i_m, 0.0), radius_j_m=(radius_j_m, 0.0)))
