"""Trackers: each combines what is sensed of an intruder into one relative state with its covariance.

It runs once a decision for every intruder, after sensing, on `sensed.OWN` and `sensed.OTHER` alone. `latest` holds the
message, `fused` filters messages, velocities and range, `bearings` knows ranges and velocities only. A new one is one
file and one line in `TRACKERS`, or `rss_gym.register_tracker`.
"""

from rss_gym.registry import Registry
from rss_gym.tracking import bank, bearings, fused, latest
from rss_gym.tracking.models import MODEL, model
from rss_gym.tracking.record import BANK, BEARINGS, FUSED, FUSED_COLUMNS, LATEST, TRACK
from rss_gym.tracking.tracker import Advance, Tracker, check

__all__ = ["MODEL", "TRACK", "TRACKERS", "Advance", "Tracker", "memory_columns", "model"]

_SHIPPED: dict[str, Tracker] = {
    "latest": Tracker("the message held, moved on by its age", latest.advance, code=LATEST),
    "fused": Tracker(
        "a Kalman filter over messages, velocities and the range", fused.advance, FUSED_COLUMNS, code=FUSED
    ),
    "bearings": Tracker(
        "ranges and velocities only: a bank of bearings",
        bearings.advance,
        BANK + bank.SIZE,
        information=("ranges",),
        code=BEARINGS,
    ),
}

TRACKERS: Registry[Tracker] = Registry("tracker", _SHIPPED, check, like="my-tracker")


def memory_columns(tracker: str) -> int:
    """Floats that a tracker remembers of one intruder."""
    return TRACKERS[tracker].columns
