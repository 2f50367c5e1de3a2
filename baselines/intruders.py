"""Where the intruders are by their tracks, and how sure that is: the input of the rules."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from rss_gym.baselines.policy import vectors
from rss_gym.params import Params, ParamsError


def check_radius(radius_m: float, params: Params) -> None:
    """Refuse a radius beyond the world's zone."""
    zone_m = params.zone.radius_m
    if radius_m > zone_m:
        raise ParamsError(
            f"radius_m = {radius_m:g} must be at most the zone radius {zone_m:g}: no message arrives beyond it"
        )


@dataclass(frozen=True)
class Intruders:
    """Rows of intruders as far as they are known, in the axes of the leg.

    Parameters
    ----------
    known : (n, K) bool array
        Whether they are to be obeyed.
    position_m : (n, K, 3) array
        Relative to the own aircraft.
    velocity_mps : (n, K, 3) array
        Over ground.
    std_m : (n, K) array
        Standard deviation of the position in the plane.
    """

    known: np.ndarray
    position_m: np.ndarray
    velocity_mps: np.ndarray
    std_m: np.ndarray


def intruders(seen: Mapping[str, np.ndarray]) -> Intruders:
    """The intruders by their tracks, to be obeyed while the warning is open.

    To obey a track for as long as it is valid changes nothing, as a warning closes well beyond any radius flown
    (`orthogonal` at 40 and 50 m, `orca` at 15 and 20 m, 4,000 encounters of split `validation`, seed 0: equal costs).

    Of the two standard deviations in the plane, along the bearing and across it, the root of the mean square counts.
    On the same encounters the cost of `orca` at 15 and 20 m is 8.7 and 4.7 m with it, 6.1 and 5.1 m with the larger,
    which is the one across, and 21.5 and 7.1 m with the one along.
    """
    known = (seen["track_valid"] > 0.5) & (seen["warning"] > 0.5)
    velocity = vectors(seen, "track_velocity", "mps") + vectors(seen, "velocity", "mps")[:, None]
    std = np.sqrt(0.5 * (seen["track_std_along_m"] ** 2 + seen["track_std_across_m"] ** 2))
    return Intruders(known, vectors(seen, "track_position", "m"), velocity, std)
