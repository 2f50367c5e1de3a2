"""The approaches that the two sides of the range-only filter predict."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from rss_gym.baselines.cbf import Cbf
from rss_gym.baselines.features.approach import AWAY_M, AXES, known_only, located
from rss_gym.baselines.features.feature_set import FeatureSet
from rss_gym.baselines.range_only import ALONG, ALONG_ALONG, PROBABILITY, RIGHT, RIGHT_RIGHT, RangeOnly
from rss_gym.params import Params

SIDES = ("left", "right")


class Sides(FeatureSet):
    """On track `range`: what `Approach` tells where positions are known, of either side of the range-only filter.

    Of `left` and `right`: its `probability`, the standard deviation of the position over 60 m (`std`), and the features
    of `Approach` in the plane; zero without a message.
    """

    needs = "they need track 'range'"

    @classmethod
    def fits(cls, world: Params) -> bool:
        """Where nobody tells a position."""
        return world.interface.track == "range"

    @property
    def columns(self) -> int:
        """Those of the filter."""
        return self._filter.columns

    def facts(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> dict[str, np.ndarray]:
        """Probability, position and standard deviation of each side."""
        sides = self._filter.sides(seen, memory)
        found: dict[str, np.ndarray] = {}
        for index, name in enumerate(SIDES):
            side = sides[..., index, :]
            found |= {
                f"{name}_probability": side[..., PROBABILITY],
                f"{name}_position_along_m": side[..., ALONG],
                f"{name}_position_right_m": side[..., RIGHT],
                f"{name}_std_m": np.sqrt(0.5 * (side[..., ALONG_ALONG] + side[..., RIGHT_RIGHT])),
            }
        return found

    def table(self, seen: Mapping[str, Any], xp: Any) -> dict[str, Any]:
        """Of every intruder."""
        found: dict[str, Any] = {}
        for name in SIDES:
            placed = {
                **seen,
                "message_age_s": 0.0 * seen["message_age_s"],  # the filter flies on to now
                "message_position_along_m": seen[f"{name}_position_along_m"],
                "message_position_right_m": seen[f"{name}_position_right_m"],
            }
            told = {"probability": seen[f"{name}_probability"], "std": seen[f"{name}_std_m"] / AWAY_M}
            told |= located(placed, AXES[:2], xp)
            found |= {f"{name}.{key}": values for key, values in told.items()}
        return known_only(seen, found, xp)

    @cached_property
    def _filter(self) -> RangeOnly:
        return RangeOnly(world=self.world, rule=Cbf(world=self.world))
