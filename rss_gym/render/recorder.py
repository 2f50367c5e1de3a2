"""Scenes of one row of a batch: the true state for the viewer, beside it what the agent knows."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rss_gym.params import Params
from rss_gym.render.scene import Aircraft, Intruder, Scene
from rss_gym.state import State

__all__ = ["RENDER_FPS", "Recorder"]

RENDER_FPS = 10  # decisions shown a second


class Batch(Protocol):
    """What a recorder reads of `rss_gym.core.Batch`."""

    params: Params
    state: State
    seen: Any  # core.Seen


class Recorder:
    """Keeps the flown paths of one row, a sample a decision, and turns the row into scenes. It only reads.

    Call `reset` after the row's reset, `append` after each of its decisions, `scene` whenever a picture is wanted.
    """

    def __init__(self) -> None:
        self._flown: list[NDArray[np.float64]] = []  # (1 + intruders, 3) each

    def reset(self, batch: Batch, row: int) -> None:
        """Start the flown paths anew, at the row's present positions."""
        self._flown = []
        self.append(batch, row)

    def append(self, batch: Batch, row: int) -> None:
        """Add the row's present positions to the flown paths."""
        present = 1 + int(batch.state.episode[row]["intruders"])
        self._flown.append(batch.state.aircraft[row]["position_m"][:present].copy())

    def scene(self, batch: Batch, row: int) -> Scene:
        """The row's present moment, in arrays of its own.

        Parameters
        ----------
        batch : Batch
        row : int
            The row that `reset` and `append` were called for.

        Returns
        -------
        Scene
            An intruder's estimate is the agent's own solution and the track of the intruder on top of it; while there
            is no track there is none.
        """
        params, episode = batch.params, batch.state.episode[row]
        duration_s = float(episode["ticks"] * params.clock.tick_s)
        flown, own = np.array(self._flown), batch.seen.own[row]

        def seen(a: int, estimate_m: NDArray[np.float64] | None) -> dict[str, Any]:
            aircraft = batch.state.aircraft[row, a]
            return {
                "position_m": aircraft["position_m"].copy(),
                "estimate_m": estimate_m,
                "flown_m": flown[:, a],
                "predefined_m": predefined_m(aircraft, duration_s),
                "velocity_mps": aircraft["velocity_mps"] + aircraft["gust_mps"],
            }

        intruders = []
        for k in range(flown.shape[1] - 1):
            other, track = batch.seen.others[row, k], batch.state.tracks[row, k]
            estimate_m = own["position_m"] + track["position_m"] if track["valid"] else None
            intruders.append(
                Intruder(
                    **seen(1 + k, estimate_m),
                    range_m=float(other["range_m"]),
                    range_std_m=float(other["range_std_m"]),
                    zone_radius_m=float(other["radius_m"]),
                    warning=bool(other["warning"]),
                )
            )
        return Scene(
            own=Aircraft(**seen(0, own["position_m"].copy())),
            planned_m=own["planned_m"].copy(),
            way_point_m=own["way_point_m"].copy(),
            intruders=tuple(intruders),
            time_s=float(episode["tick"] * params.clock.tick_s),
            duration_s=duration_s,
            zone_radius_m=params.zone.radius_m,
            collision_radius_m=params.zone.collision_m,
            min_separation_m=float(episode["min_separation_m"]),
            planar=params.encounter.planar,
            outcome="collision" if episode["collision"] else "complete" if episode["truncated"] else "",
            playback_speed=RENDER_FPS * params.clock.decision_s,
        )


def predefined_m(aircraft: Any, duration_s: float) -> NDArray[np.float64]:
    """Way points (p, 3) of the predefined trajectory of an `AIRCRAFT` record from the start to `duration_s` [m].

    The trajectory is cut there, or its last leg drawn out to there.
    """
    count = int(aircraft["path_points"])
    points_m, times_s = aircraft["path_m"][:count], aircraft["path_s"][:count]
    last = min(max(int(np.searchsorted(times_s, duration_s)), 1), count - 1)
    share = (duration_s - times_s[last - 1]) / (times_s[last] - times_s[last - 1])
    end_m = points_m[last - 1] + share * (points_m[last] - points_m[last - 1])
    return np.concatenate([points_m[:last], end_m[None]])
