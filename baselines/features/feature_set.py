"""The base of all sets of features, and the empty one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rss_gym.params import Params


@dataclass(frozen=True)
class FeatureSet:
    """Features of a world's observations.

    They are functions of the observations of one episode up to now. A row must have the same bits in every batch and on
    every machine: +, -, *, /, square roots, comparisons, and the kernels of this package.

    Parameters
    ----------
    world : Params
    """

    world: Params

    @property
    def columns(self) -> int:
        """Width of what is remembered of a row's episode."""
        return 0

    def facts(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> dict[str, np.ndarray]:
        """What memory adds to `seen`, each (n, K) in SI units; memory (n, columns) is changed in place.

        Positions are relative to the own solution, in the axes of the leg; their names hold `position`.
        """
        return {}

    def table(self, seen: Mapping[str, Any], xp: Any) -> dict[str, Any]:
        """Feature -> values (n, K) of every intruder, in order.

        Parameters
        ----------
        seen : mapping
            In SI units as of `observation.split`, and the facts.
        xp : module
            Namespace of the arrays: numpy, or torch, for gradients.
        """
        raise NotImplementedError


class Nothing(FeatureSet):
    """The observation alone."""

    def table(self, seen: Mapping[str, Any], xp: Any) -> dict[str, Any]:
        """Empty."""
        return {}
