"""The base of all sets of features, and the empty one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from rss_gym.params import Params, ParamsError


@dataclass(frozen=True)
class FeatureSet:
    """Features of a world's observations.

    They are functions of the observations of one episode up to now. A row must have the same bits in every batch and on
    every machine: +, -, *, /, square roots, comparisons, and the kernels of this package.

    Parameters
    ----------
    world : Params

    Raises
    ------
    ParamsError
        For a world that they cannot be computed in.
    """

    world: Params

    def __post_init__(self) -> None:
        """Refuse a world that the features cannot be computed in."""
        if not self.fits(self.world):
            raise ParamsError(
                f"features {type(self).__name__.lower()!r} cannot be computed in this world: {self.needs}"
            )

    needs: ClassVar[str] = ""

    @classmethod
    def fits(cls, world: Params) -> bool:
        """Whether they can be computed in this world; `needs` says what they need."""
        return True

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
