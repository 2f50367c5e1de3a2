"""Flies policies over the same encounters of split `validation`, and tells which is the best by the ranking's rules."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np

from rss_gym.baselines import able, make
from rss_gym.eval.costs import SCORE, cost_m
from rss_gym.eval.episodes import Block, fly_all
from rss_gym.eval.metrics import Estimate, Flights, measure
from rss_gym.eval.ranking import Candidate, Place, rank
from rss_gym.eval.text import cell
from rss_gym.files import write_text
from rss_gym.params import Params, ParamsError
from rss_gym.plain_files import read_json

START = "start.json"  # in the folder of a seed
RULES = ("orthogonal", "modified-orthogonal", "rule")  # the paper's: the first that flies in a world
SCRIPTED = (*RULES, "orca", "mvp", "cbf", "mpc", "qmdp")  # what an agent is compared with, where they fly
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
        The metrics that `METRICS` names.
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
        self.params, self.episodes = params, episodes

    def score(self, policy: Any, name: str) -> ValidationScore:
        """Fly `policy`, which flies in the validator's world.

        Raises
        ------
        PolicyError
            When it raises or returns no batch of actions.
        NotFiniteError
            When a state of the world is not finite.
        """
        table = self._flown(policy, name)
        flights = Flights.of(self.params, table, self._none, None)
        return ValidationScore(Candidate.of(name, table, SCORE), measure(flights, METRICS))

    @cached_property
    def _none(self) -> np.ndarray:
        return self._flown(make("none", self.params), "none")

    def _flown(self, policy: Any, name: str) -> np.ndarray:
        table = fly_all(policy, name, self.params, Block(SPLIT, SEED, range(self.episodes)), is_training=True)
        table["cost_m"] = cost_m(table["deviation_mean_m"], table["snmac"], table["collision"])
        return table


def ranked(scores: Mapping[str, ValidationScore]) -> list[Place]:
    """The order of these scores, best first; names are those of their candidates."""
    return rank(score.candidate for score in scores.values())


def keep_start(folder: Path, score: ValidationScore) -> None:
    """Write what the policy cost before its training into the folder of a seed."""
    cost = score.metrics["cost_m"]
    write_text(folder / START, json.dumps({"cost_m": cost.value, "low": cost.low, "high": cost.high}) + "\n")


def closing_sentence(folder: Path, score: ValidationScore, validator: Validator) -> str:
    """Whether the best policy of a seed's folder beats its own start, the paper's rule and the best scripted policy."""
    cost_m = score.candidate.costs.mean_m
    try:
        start = read_json(folder / START, 1000)
        high, low = score.metrics["cost_m"].high, start["low"]
        beaten = high is not None and high < low
        verb = "below" if beaten else "not clearly below" if cost_m < start["cost_m"] else "NOT below"
        first = f"{verb} the {start['cost_m']:.2f} m of its start"
    except (OSError, ParamsError, KeyError, TypeError):
        first = "its start is not known"
    rivals = _rivals(validator.params, validator.episodes)
    rule = next(name for name in RULES if name in rivals)
    best = ranked(rivals)[0].name
    against = [("the rule", rule)] + ([("the best scripted policy", best)] if best != rule else [])
    rest = " and ".join(f"{_verdict(score, rivals[name])} {what} {name}" for what, name in against)
    return f"the agent costs {cost_m:.2f} m an encounter: {first}, and it {rest}"


@cache
def _rivals(params: Params, episodes: int) -> dict[str, ValidationScore]:
    """The scripted policies that fly in a world. A study compares many runs with them."""
    validator, able_here = Validator(params, episodes), able(params)
    return {name: validator.score(make(name, params), name) for name in SCRIPTED if name in able_here}


def _verdict(score: ValidationScore, rival: ValidationScore) -> str:
    """Whether a policy costs less than a rival on the same encounters, whose cost follows."""
    places = rank([replace(score.candidate, name="the agent"), rival.candidate])
    if places[0].name != "the agent":
        verb = "does NOT beat"
    else:
        gap = places[1].difference
        clear = gap is not None and gap.low is not None and gap.low > 0.0
        verb = "beats" if clear else "does not clearly beat"
    return f"{verb} the {rival.candidate.costs.mean_m:.2f} m of"


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
