"""Scores policies on the same encounters, in one process or several, with the same result."""

from __future__ import annotations

import math
import sys
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import numpy as np
from tqdm import tqdm

from rss_gym.baselines import able
from rss_gym.core import checked_seed
from rss_gym.eval.costs import Prices
from rss_gym.eval.episodes import Block, described
from rss_gym.eval.metrics import Estimate, Flights, measure
from rss_gym.eval.policies import Entry, entry
from rss_gym.eval.suites import Suite, find
from rss_gym.eval.table import TABLE
from rss_gym.eval.workers import NOMINAL, fly_blocks
from rss_gym.params import Params, ParamsError

BLOCK = 2048  # episodes flown side by side; any value gives the same scores
ALL = "all"  # in place of a policy's name
NAME_MAX = 200  # characters of a policy's name


@dataclass(frozen=True)
class Scored:
    """One policy's episode table and metrics."""

    entry: Entry
    table: np.ndarray
    metrics: dict[str, Estimate]


@dataclass(frozen=True)
class Result:
    """What `evaluate` returns: the run, and its policies in the order given, `none` first if it was not."""

    suite: Suite
    seed: int
    episodes: int
    official: bool
    policies: tuple[Scored, ...]
    reference: str

    def __getitem__(self, name: str) -> dict[str, Estimate]:
        """The metrics of the policy of that name."""
        return next(scored.metrics for scored in self.policies if scored.entry.name == name)


def evaluate(
    policy: Any,
    suite: str | Suite = "encounter-v0",
    episodes: int | None = None,
    seed: int | None = None,
    workers: int = 1,
    reference: str | None = None,
    progress: bool | None = None,
    block: int = BLOCK,
    **changes: Any,
) -> Result:
    """Fly policies over the same encounters and compute every metric.

    Parameters
    ----------
    policy : str, object, or a list of these
        See `rss_gym.eval.policies.entry`; a loaded SB3 model will do. A dict gives names; `all` stands for every
        policy of the package that can fly in the world, at its defaults.
    suite : str or Suite
        What is flown.
    episodes, seed : int, optional
        Default: the suite's own, which make the run official.
    workers : int
        Processes. Policies given by name are built anew in each, objects are pickled.
    reference : str, optional
        Name of the policy that completed-only figures are compared with; default: the first one given.
    progress : bool, optional
        Show a progress bar; default: when the error stream is a terminal.
    block : int
        Episodes flown side by side, at most.
    **changes
        Any parameter of the world, such as `information`, `estimator`, `tracker` or `channel`; such a run is not
        official.

    Raises
    ------
    ParamsError
        For unknown names, numbers out of range, or contradictions.
    PolicyError
        When a policy raises, returns something that is not a batch of actions, or ends its process.
    NotFiniteError
        When a state of the world is not finite, in this process or a worker: it names split, seed and episode.
    """
    base = find(suite) if isinstance(suite, str) else suite
    flown = base.changed(**changes)
    given, entries, reference = _prepared(policy, flown, reference)
    count = base.episodes if episodes is None else episodes
    first_seed = base.seed if seed is None else checked_seed(seed)
    for name, value in (("episodes", count), ("workers", workers), ("block", block)):
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 1:
            raise ParamsError(f"{name} must be a whole number >= 1, got {value!r}")
    # As many blocks for each worker, all of nearly one size.
    size = math.ceil(count / (workers * math.ceil(count / (workers * block))))
    starts = range(0, count, size)
    blocks = [Block(flown.split, first_seed, range(first, min(first + size, count))) for first in starts]
    tables = [np.zeros(count, TABLE) for _ in entries]
    named = [isinstance(item, str) for _, item in given]
    show = sys.stderr.isatty() if progress is None else progress
    with (
        closing(fly_blocks(entries, named, flown.params, blocks, workers)) as flying,
        tqdm(total=count * len(entries), unit="flight", disable=not show, leave=False) as bar,
    ):
        for first, parts in zip(starts, flying, strict=True):
            for table, part in zip(tables, parts, strict=True):
                table[first : first + len(part)] = part
            bar.update(len(parts[0]) * len(entries))
    return score(flown, first_seed, entries, tables, reference, official=_official(base, flown, first_seed, count))


def check(policy: Any, suite: str, reference: str | None = None, **changes: Any) -> None:
    """Refuse the policies that `evaluate` would, without a flight; parameters as there.

    Raises
    ------
    ParamsError
    """
    _prepared(policy, find(suite).changed(**changes), reference)


def _prepared(
    policy: Any, suite: Suite, reference: str | None
) -> tuple[list[tuple[str | None, Any]], list[Entry], str]:
    """The policies as given and as entries, and which of them the others are compared with."""
    given = _given(policy, suite.params)
    entries = _entries(given, suite)
    reference = reference or entries[1 if len(entries) > 1 else 0].name
    if reference not in [item.name for item in entries]:
        raise ParamsError(f"reference {reference!r} is not among the policies flown")
    return given, entries, reference


def score(
    suite: Suite, seed: int, entries: list[Entry], tables: list[np.ndarray], reference: str, official: bool
) -> Result:
    """Every metric of every policy from the episode tables alone."""
    names = [item.name for item in entries]
    none, compared = tables[names.index(NOMINAL)], tables[names.index(reference)]
    zone = suite.params.zone
    scored = []
    for item, table in zip(entries, tables, strict=True):
        flights = Flights(
            table=table,
            none=none,
            reference=compared,
            suite_radius_m=zone.radius_m,
            trials=zone.trials,
            range_error_probability=zone.range_error_probability,
            reaction_s=zone.reaction_s,
            prices=Prices.of(suite.params),
        )
        scored.append(Scored(item, table, measure(flights)))
    return Result(suite, seed, len(none), official, tuple(scored), reference)


def _official(base: Suite, flown: Suite, seed: int, count: int) -> bool:
    return flown.hash == base.hash and (seed, count) == (base.seed, base.episodes)


def is_name(value: Any) -> bool:
    """Whether this may name a policy: short, and nothing in it that a terminal or a file could stumble over."""
    return isinstance(value, str) and bool(value.strip()) and len(value) <= NAME_MAX and value.isprintable()


def _given(policy: Any, world: Params) -> list[tuple[str | None, Any]]:
    """Names, if any, and policies in the order given, with `none` first if it is not among them."""
    given: list[tuple[str | None, Any]] = []
    if isinstance(policy, dict):
        given = list(policy.items())
    else:
        for item in policy if isinstance(policy, (list, tuple)) else [policy]:
            given += [(None, name) for name in able(world)] if isinstance(item, str) and item == ALL else [(None, item)]
    if NOMINAL not in [name or item for name, item in given if isinstance(item, str)]:
        given.insert(0, (None, NOMINAL))
    return given


def _entries(given: list[tuple[str | None, Any]], suite: Suite) -> list[Entry]:
    entries = []
    for name, item in given:
        try:
            entries.append(entry(item, suite.params, name))
        except ParamsError:
            raise
        except (Exception, SystemExit) as error:  # from the module or the function that makes the policy
            raise ParamsError(f"policy {name or item!r} cannot be made: {described(error)}") from error
    names = [item.name for item in entries]
    for item in entries:
        if not is_name(item.name):
            raise ParamsError(f"policy name {item.name!r:.220} must be 1 to {NAME_MAX} printable characters")
        if item.name == NOMINAL and item.spec != NOMINAL:
            raise ParamsError(f"the name {NOMINAL!r} belongs to doing nothing; give policy {item.spec!r} another")
        if names.count(item.name) > 1:
            raise ParamsError(f"policy {item.name!r} is given twice; give a dict to name them")
    return entries
