"""One run in parts: `fly` gives the episodes of a range, `merge` the result of all of them, bit for bit.

Each part is a task of its own for whatever runs tasks: Ray, Dask, joblib, an array job of a cluster.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from rss_gym.eval.evaluate import BLOCK, Result, Run, fly_run, prepared
from rss_gym.eval.suites import Suite
from rss_gym.eval.workers import Recipes, entries_of, recipes_of
from rss_gym.params import ParamsError


@dataclass(frozen=True, eq=False)
class Part:
    """The flights of some episodes of a run: numbers and specifications, which travel by pickle.

    Attributes
    ----------
    suite : Suite
        As it was flown.
    unchanged : bool
        Whether that is the suite's own definition.
    seed : int
    episodes : range
        Their numbers.
    policies : tuple
        How to build each policy again.
    tables : tuple of arrays of TABLE
        One of each policy, the episodes in order.
    reference : str
        The policy that completed-only figures are compared with.
    """

    suite: Suite
    unchanged: bool
    seed: int
    episodes: range
    policies: Recipes
    tables: tuple[np.ndarray, ...]
    reference: str

    @property
    def key(self) -> tuple[Any, ...]:
        """What all parts of a run have in common."""
        return self.suite.hash, self.unchanged, self.seed, self.policies, self.reference


def fly(
    policy: Any,
    suite: str | Suite = "encounter-v0",
    episodes: int | range | None = None,
    seed: int | None = None,
    reference: str | None = None,
    block: int = BLOCK,
    **changes: Any,
) -> Part:
    """Fly policies over some episodes of a run, in this process.

    Parameters and errors are those of `rss_gym.eval.evaluate`; `episodes` is usually a range.
    """
    run = prepared(policy, suite, episodes, seed, reference, **changes)
    policies = recipes_of(run.entries, run.named)
    tables = fly_run(run, block=block, progress=False)
    return Part(run.suite, run.unchanged, run.seed, run.episodes, policies, tuple(tables), run.reference)


def merge(parts: Iterable[Part]) -> Result:
    """The result of the parts of one run, which is that of `evaluate` over all their episodes.

    Parameters
    ----------
    parts : iterable of Part
        In any order; together they hold every episode of one range once.

    Raises
    ------
    ParamsError
        If they are of different runs, an episode is missing or given twice, or a policy cannot be built here.
    """
    ordered = sorted(parts, key=lambda part: part.episodes.start)
    if not ordered:
        raise ParamsError("parts must hold at least one part of a run")
    first = ordered[0]
    for before, part in itertools.pairwise(ordered):
        if part.key != first.key:
            raise ParamsError(
                f"the parts of episodes {first.episodes} and {part.episodes} are of different runs: suite, parameters, "
                "seed, policies and reference must be the same"
            )
        if part.episodes.start != before.episodes.stop:
            what = "missing" if part.episodes.start > before.episodes.stop else "given twice"
            number = min(part.episodes.start, before.episodes.stop)
            raise ParamsError(f"episode {number} is {what}: the parts must hold every episode of one range once")
    run = Run(
        suite=first.suite,
        unchanged=first.unchanged,
        seed=first.seed,
        episodes=range(first.episodes.start, ordered[-1].episodes.stop),
        entries=entries_of(first.policies, first.suite.params),
        named=[],
        reference=first.reference,
    )
    return run.score([np.concatenate(tables) for tables in zip(*(part.tables for part in ordered), strict=True)])
