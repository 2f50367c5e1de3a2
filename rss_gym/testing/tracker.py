"""What every tracker must keep."""

from __future__ import annotations

from typing import Any

import numpy as np

from rss_gym.params import Params
from rss_gym.testing.flights import check_rows_alone, ended, fly_on, fresh
from rss_gym.tracking import TRACKERS

COUNT = 50
TOLERANCE = 1e-9  # of the covariance, as a share of its size


def check_tracker(name: str) -> None:
    """In the plane and in space, with one intruder and with several, on each level that it is for.

    A track is valid where a message is held; then it is finite, and its covariance is one. It is the same in every
    batch, and nothing is left of an episode in the next.
    """
    tracker = TRACKERS[name]
    assert tracker.summary.strip(), f"tracker {name!r} has no summary"
    for information in tracker.information:
        params = Params.of(information=information, tracker=name)
        check_tracks(name, params)
        check_tracks(name, Params.of(params, planar=False, intruders=3))
        check_rows_alone(params)
        check_starts_afresh(name, params)


def check_tracks(name: str, params: Params) -> None:
    """Tracks of whole flights."""
    batch, messages = fresh(params, COUNT), 0
    while not ended(batch).all():
        fly_on(batch, 1)
        valid = batch.seen.others["valid"] & batch.seen.others["present"]
        tracks = batch.state.tracks
        assert (tracks["valid"][valid]).all(), f"tracker {name!r}: no track where a message is held"
        messages += int(valid.sum())
        _check_finite(name, tracks[valid])
        assert np.isfinite(batch.state.memories).all(), f"tracker {name!r}: its memory is not finite"
    assert messages > 0


def _check_finite(name: str, tracks: Any) -> None:
    for field in ("position_m", "velocity_mps", "xx", "xy", "yy", "zz"):
        assert np.isfinite(tracks[field]).all(), f"tracker {name!r}: {field} is not finite"
    size = tracks["xx"] + tracks["yy"]
    determinant = tracks["xx"] * tracks["yy"] - tracks["xy"] ** 2
    sound = (tracks["xx"] >= 0.0) & (tracks["yy"] >= 0.0) & (tracks["zz"] >= 0.0)
    assert sound.all(), f"tracker {name!r}: a variance is negative"
    assert (determinant >= -TOLERANCE * size * size).all(), f"tracker {name!r}: xx, xy, yy are no covariance"


def check_starts_afresh(name: str, params: Params) -> None:
    """The second episode of a batch equals that episode flown first."""
    again, first = fresh(params, 1), fresh(params, 1)
    fly_on(again)
    again.reset(np.ones(1, bool))
    first.apply_options({"episode": 1}, np.ones(1, bool))
    first.reset(np.ones(1, bool))
    for _ in range(60):
        same = np.array_equal(again.observations, first.observations)
        assert same, f"tracker {name!r}: an episode depends on the one before it"
        for batch in (again, first):
            fly_on(batch, 1)
