"""What an estimator of range is: functions of a filter, of which its runs over records and in the world are made."""

import functools
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from rss_gym.errors import ParamsError
from rss_gym.jit import compiled, guarded, kernel
from rss_gym.physics.elementary import exp
from rss_gym.ranging import filters
from rss_gym.ranging.batch import filter_records

# Codes in the records of those that `rss_gym.links` has loops of its own for.
COLOURED: Final = 0
WHITE: Final = 1
LEAST_SQUARES: Final = 2
WHITE_R: Final = 3


@dataclass(frozen=True, eq=False)
class Filter:
    """The functions of a filter, pure and scalar; Numba compiles them.

    A state is a tuple of five floats (x, phi, p_xx, p_xp, p_pp): x the range in m (or its natural logarithm, see
    `Estimator`), phi the coloured noise in dB (0 in a filter without it), then their covariance. `setting` is a
    `rss_gym.ranging.batch.Setting`: the channel, the prior of the range and its limits. For numbers that are the same
    on every machine they take `exp`, `log` and the like from `rss_gym.physics.elementary`.

    Parameters
    ----------
    prior : callable
        (setting) -> state before the first sample.
    predict : callable
        (state, psi_m, process_noise, a, sigma_w2, setting) -> state an interval later: (16)-(17) with psi the range's
        known change (m, 0 if unknown), Var(w) over the interval (m^2, or relative), e^{lambda Delta} and the standard
        deviation of w2 of (13).
    update : callable
        (state, rss_dbm, setting) -> state after a sample that was received, (18)-(21).
    start : callable, optional
        As `update`, for the first sample; default: `update`.
    innovation : callable, optional
        (state, rss_dbm, setting) -> innovation (dB) and its variance (dB^2); default: (19)-(20) of the state.
    """

    prior: Callable[..., Any]
    predict: Callable[..., Any]
    update: Callable[..., Any]
    start: Callable[..., Any] | None = None
    innovation: Callable[..., Any] | None = None


ARGUMENTS: Final = {"prior": 1, "predict": 6, "update": 3, "start": 3, "innovation": 3}


@dataclass(frozen=True, eq=False)
class Estimator:
    """An estimator of range.

    Parameters
    ----------
    title : str
        For tables and listings.
    filter : Filter, optional
        What flies in the world, and makes the run over records if that is not given.
    run : callable, optional
        The run over records, `run(time_s, rss_dbm, rate_mps, Setting, Output)`, a kernel. Without a filter it is for
        records only.
    white_is_total : bool
        Its white variance is R + S.
    literal : bool
        d(0) is the first sample inverted, phi(0) = 0, P(0) = I.
    logarithmic : bool
        Its state is ln d, and its process noise relative.
    tuned : bool
        `rss-gym calibrate` tunes its process noise, and flies it with the logged range rate too.
    compared : bool
        `rss-gym calibrate` has it in its table.
    code : int
        The number of a loop of its own in `rss_gym.links`; -1 flies by its filter.
    """

    title: str
    filter: Filter | None = None
    run: Callable[..., None] | None = None
    white_is_total: bool = False
    literal: bool = False
    logarithmic: bool = False
    tuned: bool = True
    compared: bool = True
    code: int = -1

    @property
    def flies(self) -> bool:
        """Whether it runs in the world."""
        return self.code >= 0 or self.filter is not None

    @property
    def run_records(self) -> Callable[..., None]:
        """The run over records."""
        made = self.run if self.run is not None else _run_of(self.filter, self.logarithmic)
        return guarded(made, f"estimator {self.title!r}")


@functools.cache
def functions(filter_):
    """The compiled functions of a filter: prior, start, predict, update, innovation."""
    start = filter_.start if filter_.start is not None else filter_.update
    innovation = filter_.innovation if filter_.innovation is not None else filters.innovation
    return tuple(map(compiled, (filter_.prior, start, filter_.predict, filter_.update, innovation)))


@functools.cache
def _run_of(filter_, logarithmic):
    prior, start, predict, update, innovation = functions(filter_)
    range_of = exp if logarithmic else filters.itself

    @kernel(cache=False)
    def run(time_s, rss_dbm, rate_mps, setting, out):
        filter_records(prior, start, predict, update, innovation, range_of, time_s, rss_dbm, rate_mps, setting, out)

    return run


def check(name: str, estimator: Estimator) -> None:
    """Refuse what is no estimator, in one sentence."""
    if not isinstance(estimator, Estimator):
        raise ParamsError(f"estimator {name!r} must be a rss_gym.ranging.Estimator, got {type(estimator).__name__}")
    if not isinstance(estimator.title, str) or not estimator.title.strip():
        raise ParamsError(f"estimator {name!r} must have a title, got {estimator.title!r}")
    if estimator.code != -1:
        raise ParamsError(f"estimator {name!r}: code must be -1, got {estimator.code!r}: the others are the package's")
    if estimator.filter is None and estimator.run is None:
        raise ParamsError(f"estimator {name!r} must have a filter, or a run over records")
    if estimator.filter is not None and not isinstance(estimator.filter, Filter):
        kind = type(estimator.filter).__name__
        raise ParamsError(f"estimator {name!r}: filter must be a rss_gym.ranging.Filter, got {kind}")
    for part, count in ARGUMENTS.items() if estimator.filter is not None else ():
        function = getattr(estimator.filter, part)
        if function is not None or part not in ("start", "innovation"):
            check_function(f"estimator {name!r}: {part}", function, count)
    if estimator.run is not None:
        check_function(f"estimator {name!r}: run", estimator.run, 5)


def check_function(what: str, function: Any, count: int) -> None:
    """Refuse what is not a function of so many arguments."""
    source = getattr(function, "py_func", function)
    if not inspect.isfunction(source):
        raise ParamsError(f"{what} must be a function, got {function!r}")
    found = len(inspect.signature(source).parameters)
    if found != count:
        raise ParamsError(f"{what} must take {count} arguments, got {found}")
