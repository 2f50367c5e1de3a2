"""The predicted approach, and what the control-barrier filter would command."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from rss_gym.baselines.cbf import Cbf
from rss_gym.baselines.features.approach import AWAY_M, AXES, known_only, located
from rss_gym.baselines.features.feature_set import FeatureSet
from rss_gym.baselines.range_only import ALONG_ALONG, PROBABILITY, RIGHT_RIGHT, RangeOnly

RADII_M = (15.0, 25.0, 40.0)
SIDES = ("left", "right")


class Guided(FeatureSet):
    """What `Approach` tells where positions are known, and the commands of `cbf`: a policy to follow or to leave.

    `cbf.15`, `cbf.25`, `cbf.40`, along and right, are the actions of `cbf` at these radii in metres. On track `range`
    both stand on the range-only filter (`RangeOnly`): of its `left` and `right` side `probability`, `std` of the
    position over 60 m, and what `Approach` tells of each; the commands are those on the more probable side.
    """

    @property
    def columns(self) -> int:
        """Those of the range-only filter on track `range`."""
        return self._filter.columns if self._is_ranged else 0

    def table(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> dict[str, np.ndarray]:
        """Own: the commands; of every intruder: the approach."""
        axes = AXES[:2] if self.world.encounter.planar else AXES
        if not self._is_ranged:
            return self._commands(seen) | known_only(seen, located(seen, axes))
        sides = self._filter.sides(seen, memory)
        found: dict[str, np.ndarray] = {}
        for index, name in enumerate(SIDES):
            side = sides[..., index, :]
            told = {
                "probability": side[..., PROBABILITY],
                "std": np.sqrt(0.5 * (side[..., ALONG_ALONG] + side[..., RIGHT_RIGHT])) / AWAY_M,
            } | located(self._filter.placed(seen, side), AXES[:2])
            found |= {f"{name}.{key}": values for key, values in told.items()}
        return self._commands(self._filter.placed(seen, self._filter.probable(sides))) | known_only(seen, found)

    def _commands(self, seen: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        table: dict[str, np.ndarray] = {}
        for rule in self._rules:
            actions = rule.act(seen, np.zeros((len(seen["cruise_mps"]), rule.columns)))
            table |= {f"cbf.{rule.radius_m:g}.{axis}": actions[:, index] for index, axis in enumerate(AXES[:2])}
        return table

    @property
    def _is_ranged(self) -> bool:
        return self.world.interface.track == "range"

    @cached_property
    def _rules(self) -> list[Cbf]:
        return [Cbf(world=self.world, radius_m=radius_m) for radius_m in RADII_M]

    @cached_property
    def _filter(self) -> RangeOnly:
        return RangeOnly(world=self.world, rule=self._rules[0])
