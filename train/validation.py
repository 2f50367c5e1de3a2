"""Flies policies over the same encounters of split `validation`, and tells which is the best by the ranking's rules."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from rss_gym.baselines import make
from rss_gym.eval.episodes import Block, fly
from rss_gym.eval.evaluate import BLOCK
from rss_gym.eval.metrics import Estimate, Flights, measure
from rss_gym.eval.ranking import Candidate, Place, rank
from rss_gym.eval.text import cell
from rss_gym.params import Params

SPLIT, SEED = "validation", 0
METRICS = ("collision_rate", "path_deviation_mean_m", "risk_ratio_upper")


@dataclass(frozen=True, eq=False)
class Score:
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
        return int(np.count_nonzero(self.candidate.collision))

    def __str__(self) -> str:
        """Rate of collisions with its interval, and mean deviation."""
        rate = cell(self.metrics["collision_rate"], 1.0, ".2e")
        return (
            f"collisions {self.collisions} of {len(self.candidate.collision)}, {rate}, "
            f"deviation {self.candidate.path_deviation_mean_m:.2f} m"
        )

    def to_dict(self) -> dict[str, Any]:
        """One row of `validation.csv`."""
        rate = self.metrics["collision_rate"]
        return {
            "episodes": len(self.candidate.collision),
            "faults": self.candidate.faults,
            "collisions": self.collisions,
            "collision_rate": rate.value,
            "collision_rate_low": rate.low,
            "collision_rate_high": rate.high,
            "risk_ratio_upper": self.candidate.risk_ratio_upper,
            "path_deviation_mean_m": self.candidate.path_deviation_mean_m,
        }


class Validator:
    """The encounters, the same for every policy.

    Parameters
    ----------
    world : Params
    episodes : int
        How many.
    """

    def __init__(self, world: Params, episodes: int) -> None:
        self.world = world
        self._blocks = [
            Block(SPLIT, SEED, range(first, min(first + BLOCK, episodes))) for first in range(0, episodes, BLOCK)
        ]

    def score(self, policy: Any, name: str) -> Score:
        """Fly `policy`, which flies in the validator's world.

        Raises
        ------
        PolicyError
            When it raises or returns no batch of actions.
        """
        zone = self.world.zone
        flights = Flights(
            table=self._flown(policy, name),
            none=self._none,
            reference=None,
            suite_radius_m=zone.radius_m,
            trials=zone.trials,
            range_error_probability=zone.range_error_probability,
            reaction_s=zone.reaction_s,
        )
        return Score(Candidate.of(name, flights), measure(flights, METRICS))

    @cached_property
    def _none(self) -> np.ndarray:
        return self._flown(make("none", self.world), "none")

    def _flown(self, policy: Any, name: str) -> np.ndarray:
        return np.concatenate([fly(policy, name, self.world, block)[0] for block in self._blocks])


def ranked(scores: Mapping[str, Score]) -> list[Place]:
    """The order of these scores, best first; names are those of their candidates."""
    return rank(score.candidate for score in scores.values())


class Choice:
    """Which of the policies that come one after the other is kept.

    A new one takes the place of the best if the ranking puts it first among itself, the best and the safest of all so
    far. Against the best alone, one that is a little less safe but nearer the path could win again and again, each time
    within the error of the test, and the policy become worse and worse.

    Parameters
    ----------
    best : Score, optional
        The policy that is kept.
    safest : Candidate, optional
        The safest of all, if that is not the best.
    """

    def __init__(self, best: Score | None = None, safest: Candidate | None = None) -> None:
        self.best, self.safest = best, safest

    def takes(self, score: Score) -> bool:
        """Whether `score` is now the best."""
        new = replace(score.candidate, name="new")
        best = None if self.best is None else replace(self.best.candidate, name="best")
        entries = [entry for entry in (new, best, self.safest) if entry is not None]
        taken = best is None or rank(entries)[0].name == "new"
        safest = min(entries, key=lambda entry: (entry.faults, entry.safety))
        self.safest = None if safest is (new if taken else best) else replace(safest, name="safest")
        if taken:
            self.best = score
        return taken

    def safest_to_dict(self) -> dict[str, Any] | None:
        """The safest, if it is not the best, in plain JSON types."""
        if self.safest is None:
            return None
        table = {field.name: getattr(self.safest, field.name) for field in fields(Candidate)}
        return table | {
            "episode": len(self.safest.episode),
            "collision": np.flatnonzero(self.safest.collision).tolist(),
        }


def safest_from_dict(table: Mapping[str, Any] | None) -> Candidate | None:
    """What `Choice.safest_to_dict` wrote."""
    if table is None:
        return None
    episode = np.arange(table["episode"], dtype=np.uint64)
    return Candidate(**{**table, "episode": episode, "collision": np.isin(episode, table["collision"])})
