"""The path loss factor from known distances by the damped Gauss-Newton iteration, (22)-(28).

(25) misprints its step; Theorem 1 and the appendix have Theta = [J^T J]^-1 J^T e with J = dF / dgamma = -10 log10 d,
used here. F is linear in gamma, so the minimum also has a closed form; each step multiplies gamma's error by 1 - theta.

The distances must not come from a filter that holds gamma: RSS shows only the product gamma log10 d, and gamma fitted
to the filter's own ranges drifts. Take them from GNSS, known geometry or integrated velocity.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rss_gym.jit import kernel
from rss_gym.params import Channel, ParamsError

GAMMA_LIMITS = tuple(Channel.__dataclass_fields__["path_loss_factor"].metadata[end] for end in ("low", "high"))


@dataclass(frozen=True)
class PathLossFactor:
    """Result of (25)-(28).

    Attributes
    ----------
    value : float
        gamma.
    iterations : int
        Steps of (25) taken.
    stopped : str
        "tolerance": (28) holds; "iterations": it did not within the number allowed.
    error_db2 : float
        e^T e of (23) at `value`, dB^2.
    history : numpy.ndarray
        gamma^(s), shape (iterations + 1,).
    """

    value: float
    iterations: int
    stopped: str
    error_db2: float
    history: np.ndarray


@kernel
def squared_error(gamma, log_distance, phi_db):
    """(23): e^T e with e = phi + 10 gamma log10 d of (22), dB^2."""
    total = 0.0
    for n in range(len(phi_db)):
        e = phi_db[n] + 10.0 * gamma * log_distance[n]
        total += e * e
    return total


@kernel
def step(gamma, log_distance, phi_db):
    """Theta of (25): [J^T J]^-1 J^T e, J = -10 log10 d; 0 where J is 0 and gamma cannot be seen."""
    jj, je = 0.0, 0.0
    for n in range(len(phi_db)):
        j = -10.0 * log_distance[n]
        jj, je = jj + j * j, je + j * (phi_db[n] - gamma * j)
    return je / jj if jj > 0.0 else 0.0


@kernel
def iterate(history, log_distance, phi_db, theta, mu_db2):
    """(25) from `history[0]` on until (28); fills `history`, returns steps taken, e^T e, and whether (28) holds."""
    error = squared_error(history[0], log_distance, phi_db)
    for s in range(len(history) - 1):
        before = error
        history[s + 1] = history[s] + theta * step(history[s], log_distance, phi_db)
        error = squared_error(history[s + 1], log_distance, phi_db)
        if abs(error - before) <= mu_db2:
            return s + 1, error, True
    return len(history) - 1, error, False


@kernel
def slide(log_distance, phi_db, window, initial, theta, mu_db2, iterations, low, high, out):
    """`iterate` at every sample over the last `window` complete ones, from the gamma of the sample before."""
    lengths, phis = np.empty(len(phi_db)), np.empty(len(phi_db))  # the complete samples so far
    history = np.empty(iterations + 1)
    gamma, end = initial, 0
    for n in range(len(phi_db)):
        if not (np.isnan(phi_db[n]) or np.isnan(log_distance[n])):
            lengths[end], phis[end] = log_distance[n], phi_db[n]
            end += 1
            first = max(end - window, 0)
            history[0] = gamma
            steps, _, _ = iterate(history, lengths[first:end], phis[first:end], theta, mu_db2)
            gamma = min(max(history[steps], low), high)
        out[n] = gamma


def closed_form(distance_m: ArrayLike, phi_db: ArrayLike) -> float:
    """The minimum of (24): gamma = -sum(phi log10 d) / (10 sum (log10 d)^2). Arguments as in the iteration."""
    length, phi = _complete(distance_m, phi_db)
    return float(-np.sum(phi * length) / (10.0 * np.sum(length * length)))


def estimate_path_loss_factor(
    distance_m: ArrayLike,
    phi_db: ArrayLike,
    initial: float = 2.0,
    theta: float = 0.5,
    mu_db2: float = 1e-9,
    iterations: int = 100,
) -> PathLossFactor:
    """Path loss factor of one window of samples by (22)-(28).

    Parameters
    ----------
    distance_m : array_like
        Distances known independently of the RSS, m, > 0. Shape (M,).
    phi_db : array_like
        RSS minus the offset P_t + 10 log10 K, dB. Shape (M,). Samples that are NaN here or there are left out.
    initial : float
        gamma^(0).
    theta : float
        Adjustment factor in (0, 2): Theorem 1 holds there, and the iteration diverges outside.
    mu_db2 : float
        Tolerance of (28) on the change of e^T e, dB^2.
    iterations : int
        The most steps to take, >= 1.

    Raises
    ------
    ParamsError
        For wrong types, shapes or ranges, or distances that are all 1 m, where the RSS does not depend on gamma.
    """
    _check_iteration(initial, theta, mu_db2, iterations)
    length, phi = _complete(distance_m, phi_db)
    history = np.full(iterations + 1, float(initial))
    steps, error, within = iterate(history, length, phi, float(theta), float(mu_db2))
    taken = history[: steps + 1].copy()
    return PathLossFactor(float(taken[-1]), int(steps), "tolerance" if within else "iterations", float(error), taken)


def adaptive(
    distance_m: ArrayLike,
    rss_dbm: ArrayLike,
    offset_dbm: float,
    window: int,
    initial: float = 2.0,
    theta: float = 0.5,
    mu_db2: float = 1e-6,
    iterations: int = 50,
    limits: tuple[float, float] = GAMMA_LIMITS,
) -> np.ndarray:
    """Path loss factor along a record, gamma(n), each from the last M samples and started at gamma(n-1).

    Parameters
    ----------
    distance_m, rss_dbm : array_like
        Independent distances (m, > 0) and RSS (dBm). Shape (n,). Where either is NaN, gamma is held.
    offset_dbm : float
        P_t + 10 log10 K, the RSS at 1 m.
    window : int
        M, complete samples; fewer are used as long as there are no more.
    initial, theta, mu_db2, iterations
        As in `estimate_path_loss_factor`; `initial` is gamma before the first sample.
    limits : (float, float)
        gamma is held within these, so that a few samples near 1 m cannot carry it away. Default: those of `Channel`.

    Returns
    -------
    numpy.ndarray
        Shape (n,).

    Raises
    ------
    ParamsError
        For wrong types, shapes or ranges.
    """
    _check_iteration(initial, theta, mu_db2, iterations)
    _check_whole("window", window)
    if not _is_number(offset_dbm):
        raise ParamsError(f"offset_dbm must be a finite number, got {offset_dbm!r}")
    if len(limits) != 2 or not all(_is_number(end) for end in limits) or not limits[0] < limits[1]:
        raise ParamsError(f"limits must be two increasing numbers, got {limits!r}")
    length, rss = _pair(distance_m, "rss_dbm", rss_dbm)
    out = np.empty(len(rss))
    low, high = (float(end) for end in limits)
    phi = rss - offset_dbm
    slide(length, phi, window, float(initial), float(theta), float(mu_db2), iterations, low, high, out)
    return out


def _pair(distance_m: Any, name: str, values: Any) -> tuple[np.ndarray, np.ndarray]:
    """log10 of the distances and the values, float64 (n,), NaN kept."""
    arrays = []
    for label, given in (("distance_m", distance_m), (name, values)):
        try:
            arrays.append(np.array(given, dtype=np.float64))
        except (TypeError, ValueError) as error:
            raise ParamsError(f"{label} must be an array of numbers, got {type(given).__name__}: {error}") from error
        if np.isinf(arrays[-1]).any():
            raise ParamsError(f"{label} must be finite or NaN, got an infinite value")
    if arrays[0].ndim != 1 or arrays[0].shape != arrays[1].shape:
        raise ParamsError(
            f"distance_m and {name} must have one shape (n,), got {arrays[0].shape} and {arrays[1].shape}"
        )
    if np.any(arrays[0] <= 0.0):
        raise ParamsError(f"distance_m must be above 0 m, got {np.nanmin(arrays[0]):g}")
    return np.log10(arrays[0]), arrays[1]


def _complete(distance_m: Any, phi_db: Any) -> tuple[np.ndarray, np.ndarray]:
    length, phi = _pair(distance_m, "phi_db", phi_db)
    kept = ~(np.isnan(length) | np.isnan(phi))
    if not np.any(length[kept] != 0.0):
        raise ParamsError("distance_m must hold at least one sample that is not at 1 m, where gamma has no effect")
    return length[kept], phi[kept]


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.number)) and not isinstance(value, bool) and bool(np.isfinite(value))


def _check_whole(name: str, value: Any) -> None:
    if not isinstance(value, (int, np.integer)) or isinstance(value, bool) or value < 1:
        raise ParamsError(f"{name} must be a whole number of at least 1, got {value!r}")


def _check_iteration(initial: Any, theta: Any, mu_db2: Any, iterations: Any) -> None:
    if not _is_number(initial):
        raise ParamsError(f"initial must be a finite number, got {initial!r}")
    if not _is_number(theta) or not 0.0 < theta < 2.0:
        raise ParamsError(f"theta must be between 0 and 2, both excluded (Theorem 1), got {theta!r}")
    if not _is_number(mu_db2) or mu_db2 < 0.0:
        raise ParamsError(f"mu_db2 must be a number of at least 0, got {mu_db2!r}")
    _check_whole("iterations", iterations)
