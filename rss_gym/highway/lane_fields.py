"""What the messages say of each lane: who is ahead and who is behind on it, how near, and how fast the gap closes.

All of it follows from the fields of the vehicles. A network that gets it in this form needs fewer drives than one that
has to sort six vehicles by lanes itself (docs/roads.md).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rss_gym.observation import LIMIT, Field

SIDES = {"left": -1, "own": 0, "right": 1}
ENDS = ("ahead", "behind")
# A vehicle whose announced position is within the first distance of a lane's centre counts as on it; within the second
# one, now or in a second, it may be, for two solutions of 1 m an axis do not tell lanes 4 m apart.
WITHIN_M = {"": 2.0, "perhaps_": 3.5}
SOON_S = 1.0
NEAR_M, LANE_M, LENGTH_M, CLOSING_MPS = 20.0, 4.0, 5.0, 10.0


def table() -> list[Field]:
    """The fields, in the order of `values`."""
    found = []
    for side in SIDES:
        for sure in WITHIN_M:
            for end in ENDS:
                name, who = f"on_{side}.{sure}{end}", f"who {'may be' if sure else 'is'} {end} on the {side} lane"
                nearness = f"20 m / (20 m + gap) of {who}; 0: nobody, as far as messages say"
                found.append(Field(f"{name}_nearness", "1", 1.0, 0.0, 1.0, nearness))
                closing = f"how fast the gap to {who} closes"
                found.append(Field(f"{name}_closing_mps", "m/s", CLOSING_MPS, -LIMIT, LIMIT, closing))
    return found


def values(heard: Mapping[str, np.ndarray], lane_offset_m: float) -> list[float]:
    """Raw values of the fields.

    Parameters
    ----------
    heard : mapping
        Name -> values (n,) of the vehicles' fields.
    lane_offset_m : float
        How far the agent is to the right of its lane's centre.
    """
    names = ("relative_along_m", "relative_right_m", "relative_along_mps", "relative_right_mps", "message_valid")
    vehicles = np.column_stack([heard[name] for name in names]).tolist()
    found: list[float] = []
    for side in SIDES.values():
        centre_m = side * LANE_M - lane_offset_m
        for sure, within_m in WITHIN_M.items():
            gaps_m, closing_mps = [np.inf, np.inf], [0.0, 0.0]
            for along_m, right_m, along_mps, right_mps, held in vehicles:
                beside_m = right_m - centre_m
                soon_m = beside_m + SOON_S * right_mps if sure else beside_m
                if not held or (abs(beside_m) >= within_m and abs(soon_m) >= within_m):
                    continue
                end, gap_m = int(along_m < 0.0), max(abs(along_m) - LENGTH_M, 0.0)
                if gap_m < gaps_m[end]:
                    gaps_m[end], closing_mps[end] = gap_m, along_mps if end else -along_mps
            for gap_m, speed_mps in zip(gaps_m, closing_mps, strict=True):
                found += [NEAR_M / (NEAR_M + gap_m), speed_mps]
    return found
