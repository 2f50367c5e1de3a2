"""Scores policies on the same encounters, in one process or several, with the same result."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import numpy as np

from rss_gym.baselines import able
from rss_gym.core import SEED_LIMIT, checked_seed
from rss_gym.eval.costs import Prices
from rss_gym.eval.episodes import BLOCK, Block, described
from rss_gym.eval.metrics import Estimate, Flights, measure
from rss_gym.eval.policies import Entry, entry
from rss_gym.eval.shown import Shown
from rss_gym.eval.suites import Suite, find
from rss_gym.eval.table import TABLES
from rss_gym.eval.workers import NOMINAL, fly_blocks
from rss_gym.params import Params, ParamsError
from rss_gym.progress import progress_bar

ALL = "all"  # in place of a policy's name
NAME_MAX = 200  # characters of a policy's name
EPISODES_MAX = 10**9


@dataclass(frozen=True)
class Scored:
    """One policy's episode table and metrics."""

    entry: Entry
    table: np.ndarray
    metrics: dict[str, Estimate]


@dataclass(frozen=True, repr=False)
class Result(Shown):
    """What `evaluate` returns: the run, and its policies in the order given, `none` first if it was not.

    `episodes` is how many, and `first_episode` the number of the first of them.
    """

    suite: Suite
    seed: int
    episodes: int
    official: bool
    policies: tuple[Scored, ...]
    reference: str
    first_episode: int = 0

    def __getitem__(self, name: str) -> dict[str, Estimate]:
        """The metrics of the policy of that name."""
        return next(scored.metrics for scored in self.policies if scored.entry.name == name)


@dataclass(frozen=True, eq=False)
class Run:
    """What is to be flown: a suite as it is flown, whether that is its definition, the episodes, and the policies."""

    suite: Suite
    unchanged: bool
    seed: int
    episodes: range
    entries: list[Entry]
    named: list[bool]  # whether the specification builds it
    reference: str

    @property
    def official(self) -> bool:
        """Whether these are the suite's own encounters, and all of them."""
        return self.unchanged and (self.seed, self.episodes) == (self.suite.seed, range(self.suite.episodes))

    def score(self, tables: Sequence[np.ndarray]) -> Result:
        """The result of these episode tables."""
        return score(self.suite, self.seed, self.entries, tables, self.reference, self.official, self.episodes.start)


def evaluate(
    policy: Any,
    suite: str | Suite = "encounter-v0",
    episodes: int | range | None = None,
    seed: int | None = None,
    workers: int = 1,
    reference: str | None = None,
    progress: bool | None = None,
    block: int = BLOCK,
    executor: Executor | None = None,
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
    episodes : int or range, optional
        How many from number 0 on, or their numbers; default: the suite's own.
    seed : int, optional
        Default: the suite's own. Both together make the run official.
    workers : int
        Processes. Policies given by name are built anew in each, objects are pickled. A daemon process, such as a
        worker of `multiprocessing.Pool`, may start none and flies everything itself.
    reference : str, optional
        Name of the policy that completed-only figures are compared with; default: the first one given.
    progress : bool, optional
        Show a progress bar; default: on a terminal, elsewhere a line every half a minute.
    block : int
        Episodes flown side by side, at most.
    executor : concurrent.futures.Executor, optional
        Where blocks of `block` episodes are flown, in place of `workers`: that of a Dask client, of loky, of MPI or
        of threads. It is left open.
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
    run = prepared(policy, suite, episodes, seed, reference, **changes)
    return run.score(fly_run(run, workers, block, executor, progress))


def fly_run(
    run: Run, workers: int = 1, block: int = BLOCK, executor: Executor | None = None, progress: bool | None = None
) -> list[np.ndarray]:
    """The episode table of each policy of a run; parameters and errors are those of `evaluate`."""
    for name, value in (("workers", workers), ("block", block)):
        _check_count(name, value)
    if executor is not None and (workers > 1 or not callable(getattr(executor, "submit", None))):
        raise ParamsError(
            f"executor must be a concurrent.futures.Executor, with workers left at 1, got {executor!r} and "
            f"workers = {workers}"
        )
    count = len(run.episodes)
    # As many blocks for each worker, all of nearly one size.
    size = math.ceil(count / (workers * math.ceil(count / (workers * block))))
    starts = range(0, count, size)
    blocks = [Block(run.suite.split, run.seed, run.episodes[first : first + size]) for first in starts]
    tables = [np.zeros(count, TABLES[run.suite.domain.name]) for _ in run.entries]
    with (
        closing(fly_blocks(run.entries, run.named, run.suite.params, blocks, workers, executor)) as flying,
        progress_bar(progress, total=count * len(tables), unit="flight") as bar,
    ):
        for first, parts in zip(starts, flying, strict=True):
            for table, part in zip(tables, parts, strict=True):
                table[first : first + len(part)] = part
            bar.update(len(parts[0]) * len(tables))
    return tables


def prepared(
    policy: Any,
    suite: str | Suite = "encounter-v0",
    episodes: int | range | None = None,
    seed: int | None = None,
    reference: str | None = None,
    **changes: Any,
) -> Run:
    """What `evaluate` would fly with these parameters, without a flight.

    Raises
    ------
    ParamsError
    """
    base = find(suite) if isinstance(suite, str) else suite
    flown = base.changed(**changes)
    given = _given(policy, flown.params)
    entries = _entries(given, flown)
    reference = reference or entries[1 if len(entries) > 1 else 0].name
    if reference not in [item.name for item in entries]:
        raise ParamsError(f"reference {reference!r} is not among the policies flown")
    return Run(
        suite=flown,
        unchanged=flown.hash == base.hash,
        seed=base.seed if seed is None else checked_seed(seed),
        episodes=_numbers(base.episodes if episodes is None else episodes),
        entries=entries,
        named=[isinstance(item, str) for _, item in given],
        reference=reference,
    )


def _numbers(episodes: Any) -> range:
    """The numbers of the episodes."""
    if isinstance(episodes, range):
        if not (len(episodes) and episodes.step == 1 and 0 <= episodes.start and episodes.stop <= SEED_LIMIT):
            raise ParamsError(f"episodes must be a range of step 1 within [0, 2**63) that is not empty, got {episodes}")
        return episodes
    _check_count("episodes", episodes)
    if episodes > EPISODES_MAX:
        raise ParamsError(f"episodes must be {EPISODES_MAX:,} at most, got {episodes}")
    return range(int(episodes))


def _check_count(name: str, value: Any) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 1:
        raise ParamsError(f"{name} must be a whole number >= 1, got {value!r}")


def check(policy: Any, suite: str, reference: str | None = None, **changes: Any) -> None:
    """Refuse the policies that `evaluate` would, without a flight; parameters as there.

    Raises
    ------
    ParamsError
    """
    prepared(policy, suite, reference=reference, **changes)


def score(
    suite: Suite,
    seed: int,
    entries: Sequence[Entry],
    tables: Sequence[np.ndarray],
    reference: str,
    official: bool,
    first_episode: int = 0,
) -> Result:
    """Every metric of every policy from the episode tables alone."""
    names = [item.name for item in entries]
    none, compared = tables[names.index(NOMINAL)], tables[names.index(reference)]
    scored = []
    for item, table in zip(entries, tables, strict=True):
        flights = Flights.of(suite.params, table, none, compared, Prices.of(suite.params))
        scored.append(Scored(item, table, measure(flights)))
    return Result(suite, seed, len(none), official, tuple(scored), reference, first_episode)


def is_name(value: Any) -> bool:
    """Whether this may name a policy: short, and nothing in it that a terminal or a file could stumble over."""
    return isinstance(value, str) and bool(value.strip()) and len(value) <= NAME_MAX and value.isprintable()


def _given(policy: Any, params: Params) -> list[tuple[str | None, Any]]:
    """Names, if any, and policies in the order given, with `none` first if it is not among them."""
    given: list[tuple[str | None, Any]] = []
    if isinstance(policy, dict):
        given = list(policy.items())
    else:
        for item in policy if isinstance(policy, (list, tuple)) else [policy]:
            is_all = isinstance(item, str) and item == ALL
            given += [(None, name) for name in able(params)] if is_all else [(None, item)]
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
