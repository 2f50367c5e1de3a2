"""Checks a record against itself and against the world: metrics from the tables, and a sample of episodes flown again."""

from __future__ import annotations

import dataclasses
import hashlib
import os
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rss_gym import baselines
from rss_gym.eval.episodes import Block, PolicyError, described
from rss_gym.eval.evaluate import BLOCK, score
from rss_gym.eval.metrics import METRICS
from rss_gym.eval.policies import Entry, entry
from rss_gym.eval.reading import Policy, Record, load
from rss_gym.eval.records import versions
from rss_gym.eval.suites import SUITES, Suite, find
from rss_gym.eval.workers import fly_blocks
from rss_gym.params import ParamsError

SHARE = 0.01  # of the episodes that is flown again
EPISODES_MIN = 10
SHOWN_MAX = 20  # differences that are printed
FIELDS = ("value", "low", "high", "n", "unit")


@dataclass(frozen=True)
class Difference:
    """One value of a record that is not what it should be.

    Attributes
    ----------
    policy : str or None
        None where it is the record's own.
    what : str
        A field, a metric and its field, or a column of the table.
    recorded, found : Any
        What the record says, and what was computed or flown.
    episode : int or None
        For a column.
    """

    policy: str | None
    what: str
    recorded: Any
    found: Any
    episode: int | None = None

    def __str__(self) -> str:
        policy = "" if self.policy is None else f"policy {self.policy!r}, "
        episode = "" if self.episode is None else f"episode {self.episode}, "
        return f"{policy}{episode}{self.what}: recorded {self.recorded!r}, found {self.found!r}"


@dataclass
class Verdict:
    """What `verify` found.

    Attributes
    ----------
    folder : str
    suite : str
    episodes : int
        Of the record.
    metrics : int
        How many were recomputed.
    flown : dict
        Policy -> number of its episodes flown again.
    not_flown : dict
        Policy -> why it was not.
    differences : list of Difference
    total : int
        Their number; `differences` holds at most 20 a policy and column.
    versions : dict
        Package -> recorded and present version, where they differ.
    """

    folder: str
    suite: str
    episodes: int
    metrics: int = 0
    flown: dict[str, int] = field(default_factory=dict)
    not_flown: dict[str, str] = field(default_factory=dict)
    differences: list[Difference] = field(default_factory=list)
    total: int = 0
    versions: dict[str, list[str]] = field(default_factory=dict)

    @property
    def verified(self) -> bool:
        """Whether nothing differs."""
        return self.total == 0

    def add(self, differences: Sequence[Difference], total: int | None = None) -> None:
        """Note differences; `total` counts those that are not listed too."""
        self.differences += differences
        self.total += len(differences) if total is None else total

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON types."""
        return {"verified": self.verified, **dataclasses.asdict(self)}


def verify(
    folder: str | os.PathLike[str],
    every: bool = False,
    trust: bool = False,
    seed: int = 0,
    workers: int = 1,
    progress: bool | None = None,
) -> Verdict:
    """Recompute every metric of a record from its tables, and fly some of its episodes again.

    Parameters
    ----------
    folder : path
        The record.
    every : bool
        Fly all episodes again, not 1 %.
    trust : bool
        Also build policies given as `module:attribute`, which runs code of that module.
    seed : int
        Draws another sample. The sample of seed 0 can be foreseen by who wrote the record.
    workers : int
        Processes.
    progress : bool, optional
        Show a progress bar; default: when the error stream is a terminal.

    Raises
    ------
    RecordError
        If the folder does not hold an intact record.
    """
    record = load(folder)
    verdict = Verdict(str(folder), record.suite, record.episodes)
    present = versions()
    verdict.versions = {
        name: [text, present[name]] for name, text in record.versions.items() if present.get(name, text) != text
    }
    suite = definition(record)
    verdict.add(list(_suite_differences(record, suite)))
    found = metrics_differences(record, suite)
    verdict.metrics = sum(len(policy.metrics) for policy in record.policies)
    verdict.add(found)
    if suite.hash != record.suite_hash:
        verdict.not_flown = {
            policy.name: "the world is not the one that was recorded, so no flight can be the same"
            for policy in record.policies
        }
        return verdict
    entries = []
    for policy in record.policies:
        try:
            entries.append(_rebuilt(policy, suite, trust))
        except ParamsError as error:
            verdict.not_flown[policy.name] = str(error)
            continue
        if entries[-1].hash != policy.hash:
            verdict.add([Difference(policy.name, "hash", policy.hash, entries[-1].hash)])
    numbers = sample(record, every, seed)
    _fly_again(record, suite, entries, numbers, workers, progress, verdict)
    return verdict


def definition(record: Record) -> Suite:
    """Today's definition of the record's suite, with the record's parameters."""
    if record.suite in SUITES:
        return dataclasses.replace(find(record.suite), params=record.params)
    return Suite(record.suite, "", record.params, split=record.split)


def official(record: Record) -> bool:
    """Whether these are the encounters of an official run of a suite as it is defined today."""
    if record.suite not in SUITES:
        return False
    suite = find(record.suite)
    run = (record.suite_hash, record.split, record.seed, record.episodes)
    return run == (suite.hash, suite.split, suite.seed, suite.episodes)


def _suite_differences(record: Record, suite: Suite) -> Iterator[Difference]:
    if record.split != suite.split:
        yield Difference(None, "split", record.split, suite.split)
    if suite.hash != record.suite_hash:
        what = "suite_hash (its definition has changed since, or the record's parameters are not those flown)"
        yield Difference(None, what, record.suite_hash, suite.hash)
    elif record.official != official(record):
        yield Difference(None, "official", record.official, official(record))


def metrics_differences(record: Record, suite: Suite) -> list[Difference]:
    """Metrics in the record that are not exactly those of its tables."""
    entries = [Entry(policy.name, policy.spec, None, suite.params) for policy in record.policies]
    tables = [policy.table for policy in record.policies]
    result = score(suite, record.seed, entries, tables, record.reference, record.official)
    found = []
    for policy in record.policies:
        for name in METRICS:
            if name not in policy.metrics:
                found.append(Difference(policy.name, name, None, result[policy.name][name].value))
                continue
            for part in FIELDS:
                recorded, computed = (getattr(m[name], part) for m in (policy.metrics, result[policy.name]))
                if recorded != computed:
                    found.append(Difference(policy.name, f"{name}.{part}", recorded, computed))
    return found


def _rebuilt(policy: Policy, suite: Suite, trust: bool) -> Entry:
    if policy.spec.partition(":")[0] not in baselines.POLICIES and ":" in policy.spec and not trust:
        raise ParamsError(f"{policy.spec!r} is code, which runs only when trusted (--trust)")
    try:
        return entry(policy.spec, suite.params, policy.name)
    except ParamsError:
        raise
    except (Exception, SystemExit) as error:  # from the code that makes the policy
        raise ParamsError(f"{policy.spec!r} cannot be made: {described(error)}") from error


def sample(record: Record, every: bool = False, seed: int = 0) -> Sequence[int]:
    """Numbers of the episodes to fly again: all, or 1 % but at least 10, drawn by the tables' digests and a seed."""
    count = min(record.episodes, max(EPISODES_MIN, round(SHARE * record.episodes)))
    if every or count == record.episodes:
        return range(record.episodes)
    digests = ",".join([str(seed), *(policy.table_sha256 for policy in record.policies)])
    generator = np.random.default_rng(int(hashlib.sha256(digests.encode()).hexdigest(), 16))
    return sorted(generator.choice(record.episodes, count, replace=False).tolist())


def _fly_again(
    record: Record,
    suite: Suite,
    entries: list[Entry],
    numbers: Sequence[int],
    workers: int,
    progress: bool | None,
    verdict: Verdict,
) -> None:
    ...
