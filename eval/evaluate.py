"""Scores policies on the same encounters, in one process or several, with the same result."""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import Any

import numpy as np
from tqdm import tqdm

from rss_gym.core import checked_seed
from rss_gym.eval.episodes import Block, PolicyError, fly
from rss_gym.eval.metrics import METRICS, Estimate, Flights
from rss_gym.eval.policies import Entry, entry
from rss_gym.eval.suites import Suite, find
from rss_gym.params import ParamsError

BLOCK = 2048  # episodes flown side by side; any value gives the same scores
NOMINAL = "none"  # the denominator of every risk ratio


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
        See `rss_gym.eval.policies.entry`; a loaded SB3 model will do. A dict gives names.
    suite : str or Suite
        What is flown.
    episodes, seed : int, optional
        Default: the suite's own, which make the run official.
    workers : int
        Processes; more than one need policies given by name.
    reference : str, optional
        Name of the policy that completed-only figures are compared with; default: the first one given.
    progress : bool, optional
        Show a progress bar; default: when the error stream is a terminal.
    block : int
        Episodes flown side by side.
    **changes
        Any parameter of the world, such as `channel` or `estimator`; such a run is not official.

    Raises
    ------
    ParamsError
        For unknown names, numbers out of range, or contradictions.
    PolicyError
        When a policy raises, or returns something that is not a batch of actions.
    """
    base = find(suite) if isinstance(suite, str) else suite
    flown = base.changed(**changes)
    count = base.episodes if episodes is None else episodes
    first_seed = base.seed if seed is None else checked_seed(seed)
    for name, value in (("episodes", count), ("workers", workers), ("block", block)):
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 1:
            raise ParamsError(f"{name} must be a whole number >= 1, got {value!r}")
    entries = _entries(policy, flown)
    reference = reference or entries[1 if len(entries) > 1 else 0].name
    if reference not in [item.name for item in entries]:
        raise ParamsError(f"reference {reference!r} is not among the policies flown")
    blocks = [
        Block(flown.split, first_seed, first, min(block, count - first)) for first in range(0, count, block)
    ]
    show = sys.stderr.isatty() if progress is None else progress
    with tqdm(total=count * len(entries), unit="flight", disable=not show, leave=False) as bar:
        parts = []
        for part in _flown(entries, blocks, workers):
            parts.append(part)
            bar.update(len(part[0]) * len(entries))
    tables = [np.concatenate([part[i] for part in parts]) for i in range(len(entries))]
    return score(flown, first_seed, entries, tables, reference, official=_official(base, flown, first_seed, count))


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
        )
        scored.append(Scored(item, table, {name: metric(flights) for name, metric in METRICS.items()}))
    return Result(suite, seed, len(none), official, tuple(scored))


def _official(base: Suite, flown: Suite, seed: int, count: int) -> bool:
    return flown.hash == base.hash and (seed, count) == (base.seed, base.episodes)


def _entries(policy: Any, suite: Suite) -> list[Entry]:
    given: Iterable[tuple[str | None, Any]]
    if isinstance(policy, dict):
        given = policy.items()
    else:
        given = [(None, item) for item in (policy if isinstance(policy, (list, tuple)) else [policy])]
    entries = [entry(item, suite.params, name) for name, item in given]
    if NOMINAL not in [item.name for item in entries]:
        entries.insert(0, entry(NOMINAL, suite.params))
    names = [item.name for item in entries]
    for name in names:
        if names.count(name) > 1:
            raise ParamsError(f"policy {name!r} is given twice; give a dict to name them")
    return entries


def _flown(entries: list[Entry], blocks: list[Block], workers: int) -> Iterator[list[np.ndarray]]:
    """The tables of each block, in order."""
    if workers == 1:
        for block in blocks:
            yield fly_block(entries, block)
        return
    # Spawned, not forked: the same on every system, and no thread is copied in the middle of its work.
    pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"))
    try:
        yield from pool.map(fly_block, [entries] * len(blocks), blocks)
    except BrokenProcessPool as error:
        raise PolicyError("a worker process died; nothing was written") from error
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def fly_block(entries: list[Entry], block: Block) -> list[np.ndarray]:
    """Fly all policies over one block, `none` first, whose positions the manoeuvres of the others are measured from."""
    nominal = next(item for item in entries if item.name == NOMINAL)
    table, positions = fly(nominal.policy, nominal.name, nominal.world, block)
    return [
        table if item is nominal else fly(item.policy, item.name, item.world, block, positions)[0] for item in entries
    ]
