"""What a tracker is."""

import inspect
from dataclasses import dataclass
from typing import Any, Protocol

from rss_gym.errors import ParamsError


class Advance(Protocol):
    """The kernel of a tracker; a memory of zeros has seen nothing of the episode."""

    def __call__(self, own: Any, other: Any, memory: Any, track: Any, model: Any) -> None:
        """Advance by a decision, or open with the first message, and write `track`.

        Parameters
        ----------
        own, other : records
            `sensed.OWN` and one of `sensed.OTHER`.
        memory : (columns,) array
            What the tracker remembers of the intruder; rewritten.
        track : record
            One of `TRACK`; rewritten. Only `valid` means anything while that is false.
        model : record
            `model(params)[0]`.
        """


@dataclass(frozen=True, eq=False)
class Tracker:
    """A tracker.

    Parameters
    ----------
    summary : str
        One line for listings.
    advance : Advance
        A pure function, which Numba compiles; for numbers that are the same on every machine it takes `exp`, `log` and
        the like from `rss_gym.physics.elementary`.
    columns : int
        Floats that it remembers of one intruder.
    information : tuple of str
        The levels that it is for: "positions", where messages hold them, "ranges", or both.
    code : int
        The number of a branch of its own in `rss_gym.tracking.advance`; -1 for those that are compiled into a world of
        their own.
    """

    summary: str
    advance: Advance
    columns: int = 1
    information: tuple[str, ...] = ("positions",)
    code: int = -1


def check(name: str, tracker: Tracker) -> None:
    """Refuse what is no tracker, in one sentence."""
    if not isinstance(tracker, Tracker):
        raise ParamsError(f"tracker {name!r} must be a rss_gym.tracking.Tracker, got {type(tracker).__name__}")
    if not isinstance(tracker.summary, str) or not tracker.summary.strip():
        raise ParamsError(f"tracker {name!r} must have a summary, one line for listings")
    if isinstance(tracker.columns, bool) or not isinstance(tracker.columns, int) or not 1 <= tracker.columns <= 10_000:
        raise ParamsError(f"tracker {name!r}: columns must be a whole number in [1, 10000], got {tracker.columns!r}")
    levels = tracker.information
    if not isinstance(levels, tuple) or not levels or not set(levels) <= {"positions", "ranges"}:
        raise ParamsError(f"tracker {name!r}: information must hold 'positions', 'ranges' or both, got {levels!r}")
    if tracker.code != -1:
        raise ParamsError(f"tracker {name!r}: code must be -1, got {tracker.code!r}: the others are the package's")
    source = getattr(tracker.advance, "py_func", tracker.advance)
    if not inspect.isfunction(source) or len(inspect.signature(source).parameters) != 5:
        raise ParamsError(f"tracker {name!r}: advance must be a function (own, other, memory, track, model)")
