"""Trainings of a study: runs that are kept, and the scores of what they learnt on encounters that chose nothing."""

from __future__ import annotations

import csv
import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rss_gym.eval.evaluate import evaluate
from rss_gym.eval.studies.world.rows import SEED, Scores
from rss_gym.train import recipe as recipes
from rss_gym.train import run as runs
from rss_gym.train.run_record import AGENT, BEST


@dataclass(frozen=True)
class Trained:
    """One seed of a run.

    Attributes
    ----------
    number : int
        The number of the seed in its run.
    folder : Path
        The folder of the policy that was kept.
    validations : list of dict
        Rows of its `validation.csv`.
    """

    number: int
    folder: Path
    validations: list[dict[str, str]]

    @property
    def cpu_s(self) -> float:
        """Of the whole training."""
        return float(self.validations[-1]["cpu_s"])

    @property
    def decisions(self) -> int:
        """Of the whole training."""
        return int(self.validations[-1]["steps"])


@dataclass(frozen=True)
class Trainer:
    """How much a study trains and flies, and where it keeps its runs.

    Attributes
    ----------
    runs : Path
    workers : int
        Processes.
    seeds : int
        Trainings of a recipe, unless the section says otherwise.
    episodes : int
        Encounters of a row.
    shrink : int
        So many times fewer decisions than the recipes say.
    """

    runs: Path
    workers: int
    seeds: int
    episodes: int
    shrink: int = 1

    def train(self, name: str, changes: Mapping[str, Any] | None = None, seeds: int | None = None) -> list[Trained]:
        """The seeds of a recipe with changes, trained now unless an earlier call has done it."""
        changes = dict(changes or {})
        if self.shrink > 1:
            steps = max(1, recipes.load(name, changes).steps // self.shrink)
            changes |= {"recipe.steps": steps, "validation.every_steps": steps, "validation.episodes": 100}
        recipe, count = recipes.load(name, changes), min(self.seeds, seeds or self.seeds)
        digest = hashlib.sha256(json.dumps([recipe.to_dict(), count]).encode()).hexdigest()[:8]
        folder = self.runs / f"learning-{name}-{digest}"
        if not folder.exists():
            runs.start(recipe, folder, count, self.workers, show=False)
        elif not (folder / AGENT).exists():
            runs.resume(folder, self.workers, show=False)
        return list(_seeds(folder, count))

    def score(self, policies: Mapping[str, Any], suite: str, **changes: Any) -> dict[str, Scores]:
        """Scores by name over the first encounters of the studies' seed; `changes` are those of the suite's world."""
        result = evaluate(dict(policies), suite, self.episodes, SEED, workers=self.workers, progress=False, **changes)
        return {name: result[name] for name in policies}


def _seeds(folder: Path, count: int) -> Iterator[Trained]:
    for number in range(count):
        path = folder / f"seed-{number}"
        with open(path / "validation.csv", encoding="utf-8", newline="") as file:
            yield Trained(number, path / BEST, list(csv.DictReader(file)))
