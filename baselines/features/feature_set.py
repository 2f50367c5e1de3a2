"""The base of all sets of features, and the empty one."""

from __future__ import annotations

from dataclasses import dataclass

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

    def table(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> dict[str, np.ndarray]:
        """Feature -> values, own (n,) and of each intruder (n, K); `seen` in SI units as of `observation.split`."""
        raise NotImplementedError


class Nothing(FeatureSet):
    """The observation alone."""

    def table(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> dict[str, np.ndarray]:
        """Empty."""
        return {}
