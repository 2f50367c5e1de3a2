"""Flies policies over the same encounters of split `validation`, and tells which is the best by the ranking's rules."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from rss_gym.baselines import make
from rss_gym.eval.costs import SCORE, cost_m
from rss_gym.eval.episodes import Block, fly_episodes
from rss_gym.eval.evaluate import BLOCK
from rss_gym.eval.metrics import Estimate, Flights, measure
from rss_gym.eval.ranking import Candidate, Place, rank
from rss_gym.eval.text import cell
from rss_gym.params import Params

SPLIT, SEED = "validation", 0
METRICS = ("cost_m", "collision_rate", "snmac_rate", "path_deviation_mean_m")


@dataclass(frozen=True, eq=False)
class ValidationScore:
    """A policy's flights.

    Attributes
    ----------
    candidate : Candidate
        For the ranking.
    metrics : dict of Estimate
        Those of `METRICS`.
    """

    candidate: Candidate
    metrics: dict[str, Estimate]

    @property
    def collisions(self) -> int:
        """How many."""
        return int(np.count_nonzero(self.candidate.costs.collision))

    def __str__(self) -> str:
        """Cost and rate of collisions with their intervals, and mean deviation."""
        cost, rate = cell(self.metrics["cost_m"], 1.0, ".2f"), cell(self.metrics["collision_rate"], 1.0, ".2e")
        faults = f", {self.candidate.faults:,} FAULTS, not ranked" if self.candidate.faults else ""
        return (
            f"cost {cost} m, collisions {self.collisions} of {len(self.candidate.costs)}, {rate}, "
            f"deviation {self.metrics['path_deviation_mean_m'].value:.2f} m{faults}"
        )

    def to_dict(self) -> dict[str, Any]:
        """One row of `validation.csv`."""
        rate, cost = self.metrics["collision_rate"], self.metrics["cost_m"]
        return {
            "episodes": len(self.candidate.costs),
            "faults": self.candidate.faults,
            "cost_m": cost.value,
            "cost_low_m": cost.low,
            "cost_high_m": cost.high,
            "collisions": self.collisions,
            "collision_rate": rate.value,
            "collision_rate_low": rate.low,
            "collision_rate_high": rate.high,
            "snmac_rate": self.metrics["snmac_rate"].value,
            "path_deviation_mean_m": self.metrics["path_deviation_mean_m"].value,
        }


class Validator:
    """The encounters, the same for every policy, scored by the prices of the suites, whatever the training's are.

    Parameters
    ----------
    params : Params
    episodes : int
        How many.
    """

    def __init__(self, params: Params, episodes: int) -> None:
        self.params = params
        self._blocks = [
            Block(SPLIT, SEED, range(first, min(first + BLOCK, episodes))) for first in range(0, episodes, BLOCK)
        ]

    def score(self, policy: Any, name: str) -> ValidationScore:
        """Fly `policy`, which flies in the validator's world.

        Raises
        ------
        PolicyError
            When it raises or returns no batch of actions.
        NotFiniteError
            When a state of the world is not finite.
        """
        zone, table = self.params.zone, self._flown(policy, name)
        flights = Flights(
            table=table,
            none=self._none,
            reference=None,
            suite_radius_m=zone.radius_m,
            trials=zone.trials,
            range_error_probability=zone.range_error_probability,
            reaction_s=zone.reaction_s,
        )
        return ValidationScore(Candidate.of(name, table, SCORE), measure(flights, METRICS))

    @cached_property
    def _none(self) -> np.ndarray:
        return self._flown(make("none", self.params), "none")

    def _flown(self, policy: Any, name: str) -> np.ndarray:
        table = np.concatenate([fly_episodes(policy, name, self.params, block)[0] for block in self._blocks])
        table["cost_m"] = cost_m(table["deviation_mean_m"], table["snmac"], table["collision"])
        return table


def ranked(scores: Mapping[str, ValidationScore]) -> list[Place]:
    """The order of these scores, best first; names are those of their candidates."""
    return rank(score.candidate for score in scores.values())


class BestTracker:
    """Which of the policies that come one after the other is kept: the cheapest, the earlier one of equals.

    Parameters
    ----------
    best : ValidationScore, optional
        The policy that is kept.
    """

    def __init__(self, best: ValidationScore | None = None) -> None:
        self.best = best

    def takes(self, score: ValidationScore) -> bool:
        """Whether `score` is now the best."""
        if self.best is not None:
            entries = [replace(self.best.candidate, name="1"), replace(score.candidate, name="2")]
            if rank(entries, differences=False)[0].name == "1":
                return False
        self.best = score
        return True
