"""Where the other is and how it moves: a tracker makes one relative state with its covariance of what is sensed.

It runs once a decision for every intruder, after sensing, on `sensed.OWN` and `sensed.OTHER` alone. `latest` holds the
message, `fused` filters messages, velocities and range, `bearings` knows ranges and velocities only.
"""

from typing import Any, Final, Protocol

from rss_gym.tracking import bank
from rss_gym.tracking.models import MODEL, model
from rss_gym.tracking.record import BANK, BEARINGS, FUSED, FUSED_COLUMNS, LATEST, TRACK

TRACKERS: Final = {"latest": LATEST, "fused": FUSED, "bearings": BEARINGS}

__all__ = ["BEARINGS", "FUSED", "LATEST", "MODEL", "TRACK", "TRACKERS", "Tracker", "memory_columns", "model"]


class Tracker(Protocol):
    """A module with one kernel; a memory of zeros has seen nothing of the episode."""

    def advance(self, own: Any, other: Any, memory: Any, track: Any, model: Any) -> None:
        """Advance by a decision, or open with the first message, and write `track`.

        Parameters
        ----------
        own, other : records
            `sensed.OWN` and one of `sensed.OTHER`.
        memory : (columns,) array
            As `memory_columns` says; rewritten.
        track : record
            One of `TRACK`; rewritten. Only `valid` means anything while that is false.
        model : record
            `model(params)[0]`.
        """


def memory_columns(tracker: str) -> int:
    """Floats that a tracker remembers of one intruder."""
    if tracker == "bearings":
        return BANK + bank.SIZE
    return FUSED_COLUMNS if tracker == "fused" else 1
