"""Checks a record against itself and the world.

Metrics are computed again from its tables; a sample of its episodes, and of the flights that it keeps for its page, is
flown again.
"""

from __future__ import annotations

import dataclasses
import os
import secrets
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from rss_gym import baselines
from rss_gym.baselines.agent import Agent
from rss_gym.eval.episodes import Block, PolicyError, WorkerError, described
from rss_gym.eval.evaluate import BLOCK, score
from rss_gym.eval.metrics import METRICS
from rss_gym.eval.policies import Entry, entry, innermost
from rss_gym.eval.reading import Policy, Record, definition, load
from rss_gym.eval.records import versions
from rss_gym.eval.reflown import differences, kept, sampled
from rss_gym.eval.suites import SUITES, Suite, find
from rss_gym.eval.workers import NOMINAL, fly_blocks
from rss_gym.params import ParamsError
from rss_gym.progress import progress_bar

SHARE = 0.01  # of the episodes that is flown again
EPISODES_MIN = 10
LISTED_MAX = 1000  # differences of flights that are kept
SHOWN_MAX = 20  # of them printed
OUTCOMES = {"verified": 0, "differs": 1, "incomplete": 3}  # and the exit status of `rss-gym verify`; 2 is bad input
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
        The number of encounters of the record.
    metrics : int
        How many were recomputed.
    flown : dict
        Policy -> number of its episodes flown again.
    not_flown : dict
        Policy -> why it was not.
    flights : int
        How many of the flights that are kept for the page were flown again.
    seed : int
        The seed of the sample of episodes flown again; with it the same sample is drawn.
    differences : list of Difference
    versions : dict
        Package -> recorded and present version, where they differ.
    """

    folder: str
    suite: str
    episodes: int
    seed: int = 0
    metrics: int = 0
    flights: int = 0
    flown: dict[str, int] = field(default_factory=dict)
    not_flown: dict[str, str] = field(default_factory=dict)
    differences: list[Difference] = field(default_factory=list)
    versions: dict[str, list[str]] = field(default_factory=dict)

    @property
    def outcome(self) -> str:
        """One of `OUTCOMES`: `incomplete` where nothing differs but a policy was not flown again."""
        return "differs" if self.differences else "incomplete" if self.not_flown else "verified"

    @property
    def verified(self) -> bool:
        """Whether nothing differs and every policy was flown again, at least in a sample."""
        return self.outcome == "verified"

    @property
    def status(self) -> dict[str, str]:
        """Policy -> `all` or `sample` of its episodes flown again, or `not flown`."""
        flown = {name: "all" if count == self.episodes else "sample" for name, count in self.flown.items()}
        return flown | dict.fromkeys(self.not_flown, "not flown")

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON types."""
        return {"verified": self.verified, "outcome": self.outcome, "status": self.status, **dataclasses.asdict(self)}


def verify(
    folder: str | os.PathLike[str],
    every: bool = False,
    trust: bool = False,
    seed: int | None = None,
    workers: int = 1,
    progress: bool | None = None,
) -> Verdict:
    """Recompute every metric of a record from its tables, and fly some of its episodes and kept flights again.

    Parameters
    ----------
    folder : path
        The record.
    every : bool
        Fly all episodes and kept flights again, not 1 % of the ones and ten of the others.
    trust : bool
        Also build policies given as `module:attribute`, which runs code of that module.
    seed : int
        Draws the sample; default: by chance, so that nobody who writes a record can foresee it.
    workers : int
        Processes.
    progress : bool, optional
        Show a progress bar; default: when the error stream is a terminal.

    Raises
    ------
    RecordError
        If the folder does not hold an intact record.
    NotFiniteError
        When a state of the world is not finite while episodes are flown again: that is no verdict on the record.
    """
    return examine(load(folder), every, trust, seed, workers, progress)


def examine(
    record: Record,
    every: bool = False,
    trust: bool = False,
    seed: int | None = None,
    workers: int = 1,
    progress: bool | None = None,
) -> Verdict:
    """`verify` of a record that has been read."""
    seed = secrets.randbelow(2**32) if seed is None else seed
    verdict = Verdict(str(record.folder), record.suite, record.episodes, seed)
    present = versions()
    verdict.versions = {
        name: [text, present[name]] for name, text in record.versions.items() if present.get(name, text) != text
    }
    suite, flights = definition(record), kept(record)
    verdict.differences += list(_suite_differences(record, suite))
    found = metrics_differences(record, suite)
    verdict.metrics = sum(len(policy.metrics) for policy in record.policies)
    verdict.differences += found
    if suite.hash != record.suite_hash:
        verdict.not_flown = {
            policy.name: "the world is not the one that was recorded, so no flight can be the same"
            for policy in record.policies
        }
        return verdict
    entries, verdict.not_flown, claims = entries_of(record, suite, trust)
    verdict.differences += claims
    numbers = sample(record, every, seed)
    flyers = {item.name: item for item in entries}
    keys = sampled([key for key in flights if key[0] in flyers], every, seed)
    with progress_bar(progress, total=len(numbers) * len(entries) + len(keys), unit="flight") as bar:
        _fly_again(record, suite, entries, numbers, workers, verdict, bar.update)
        for name, episode in keys:
            unlike = differences(record, flyers[name], episode, flights[name, episode])
            verdict.differences += [Difference(name, *values, episode) for values in unlike]
            verdict.flights += 1
            bar.update(1)
    return verdict


def official(record: Record) -> bool:
    """Whether these are the encounters of an official run of a suite as it is defined today."""
    if record.suite not in SUITES:
        return False
    suite = find(record.suite)
    run = (record.suite_hash, record.split, record.seed, record.episodes, record.first_episode)
    return run == (suite.hash, suite.split, suite.seed, suite.episodes, 0)


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
        for name in result[policy.name]:
            if name not in policy.metrics:
                if name not in METRICS.shipped:
                    continue  # registered here, not where the record was made
                found.append(Difference(policy.name, name, None, result[policy.name][name].value))
                continue
            for part in FIELDS:
                recorded, computed = (getattr(m[name], part) for m in (policy.metrics, result[policy.name]))
                if recorded != computed:
                    found.append(Difference(policy.name, f"{name}.{part}", recorded, computed))
    return found


def entries_of(
    record: Record, suite: Suite, trust: bool = False
) -> tuple[list[Entry], dict[str, str], list[Difference]]:
    """The record's policies built again, why others cannot be, and claims that do not fit those that can."""
    entries: list[Entry] = []
    missing: dict[str, str] = {}
    found: list[Difference] = []
    for policy in record.policies:
        try:
            built = _built(record.folder, policy, suite, trust)
        except ParamsError as error:
            missing[policy.name] = str(error)
            continue
        if built.hash != policy.hash:
            found.append(Difference(policy.name, "hash", policy.hash, built.hash))
            if isinstance(built.policy, Agent):
                missing[policy.name] = f"{policy.spec!r} is not the policy that was recorded"
                continue
        entries.append(built)
        flown = built.params.interface.information
        if flown != policy.information:
            found.append(Difference(policy.name, "information", policy.information, flown))
    return entries, missing, found


def _built(folder: Path, policy: Policy, suite: Suite, trust: bool) -> Entry:
    """The policy by its name or from the files in the record; no path that the record names is ever opened."""
    inner = innermost(policy.spec)
    spec = policy.spec
    if policy.folder is not None and baselines.is_known(inner):
        raise ParamsError(f"{inner!r} is a policy of the package, and the record brings files under that name")
    if policy.folder is not None:
        spec = policy.spec.removesuffix(inner) + str((folder / policy.folder).absolute())
    elif not baselines.is_known(inner):
        if ":" not in inner or inner.endswith(baselines.PICKLED):
            raise ParamsError(f"{inner!r} is no policy of the package, and its files are not in the record")
        if not trust:
            raise ParamsError(f"{inner!r} is code, which runs only when trusted (--trust)")
    try:
        return entry(spec, suite.params, policy.name)
    except ParamsError:
        raise
    except (Exception, SystemExit) as error:  # from the code that makes the policy
        raise ParamsError(f"{policy.spec!r} cannot be made: {described(error)}") from error


def sample(record: Record, every: bool = False, seed: int = 0) -> Sequence[int]:
    """Numbers of the episodes to fly again: all, or 1 % but at least 10, drawn by a seed."""
    count = min(record.episodes, max(EPISODES_MIN, round(SHARE * record.episodes)))
    numbers = range(record.first_episode, record.first_episode + record.episodes)
    if every or count == record.episodes:
        return numbers
    generator = np.random.default_rng(seed)
    return [numbers[place] for place in sorted(generator.choice(record.episodes, count, replace=False).tolist())]


def differing(record: Record, suite: Suite, name: str, numbers: Sequence[int]) -> list[Difference]:
    """What differs where these encounters of one policy are flown again; empty too where it cannot be made."""
    entries, _, _ = entries_of(record, suite)
    chosen = [item for item in entries if item.name in (NOMINAL, name)]
    verdict = Verdict(str(record.folder), record.suite, record.episodes)
    _fly_again(record, suite, chosen, numbers, 1, verdict, lambda count: None)
    return [one for one in verdict.differences if one.policy == name]


def _fly_again(
    record: Record,
    suite: Suite,
    entries: list[Entry],
    numbers: Sequence[int],
    workers: int,
    verdict: Verdict,
    advance: Callable[[int], object],
) -> None:
    parts = [numbers[first : first + BLOCK] for first in range(0, len(numbers), BLOCK)]
    blocks = [Block(suite.split, record.seed, part) for part in parts]

    def compared(flown: list[Entry]) -> list[Difference]:
        found: list[Difference] = []
        with closing(fly_blocks(flown, [True] * len(flown), suite.params, blocks, workers)) as flying:
            for tables in flying:
                for item, table in zip(flown, tables, strict=True):
                    found += _compared(record, item.name, table)[: LISTED_MAX - len(found)]
                    advance(len(table))
        return found

    nominal = next(item for item in entries if item.name == NOMINAL)
    groups = [entries]
    while groups:
        group = groups.pop(0)
        try:
            verdict.differences += compared(group)
        except WorkerError:  # the machine's fault, not the record's
            raise
        except PolicyError as error:
            if len(group) > 2:  # once more, each beside `none`, to find out who fails
                groups = [[nominal, item] for item in group if item is not nominal]
                continue
            verdict.differences += [Difference(group[-1].name, "flights", "flown to their ends", str(error))]
        else:
            verdict.flown |= {item.name: len(numbers) for item in group}


def _compared(record: Record, name: str, flown: np.ndarray) -> list[Difference]:
    """Every column of every episode flown, bit for bit."""
    recorded = record[name].table[flown["episode"].astype(np.int64) - record.first_episode]
    found = []
    for column in flown.dtype.names or ():
        one, other = (np.ascontiguousarray(table[column]) for table in (recorded, flown))
        size = one.dtype.itemsize
        unlike = one.view((np.uint8, size)) != other.view((np.uint8, size))
        for row in np.flatnonzero(unlike.any(axis=1)):
            number = int(flown["episode"][row])
            found.append(Difference(name, column, one[row].item(), other[row].item(), number))
    return sorted(found, key=lambda difference: difference.episode or 0)


def report(verdict: Verdict) -> str:
    """The verdict for a reader."""
    lines = [
        f"{verdict.folder}: suite {verdict.suite}, {verdict.episodes} encounters",
        f"metrics: {verdict.metrics} recomputed from the tables",
    ]
    for count in sorted(set(verdict.flown.values())):
        names = ", ".join(name for name, flown in verdict.flown.items() if flown == count)
        lines.append(f"flown again: {count} encounters of each of {names} (--seed {verdict.seed})")
    if verdict.flights:
        lines.append(f"flights of the page: {verdict.flights} flown again")
    lines += [f"NOT flown again: {name}: {reason}" for name, reason in verdict.not_flown.items()]
    lines += [f"differs: {difference}" for difference in verdict.differences[:SHOWN_MAX]]
    if len(verdict.differences) > SHOWN_MAX:
        lines.append(f"... and {len(verdict.differences) - SHOWN_MAX} more (--json lists them)")
    if verdict.differences and verdict.versions:
        changed = ", ".join(f"{name} {was} (now {now})" for name, (was, now) in verdict.versions.items())
        lines.append(f"recorded with {changed}")
    if verdict.verified:
        lines.append("verified: nothing differs")
    elif not verdict.differences:
        lines.append("INCOMPLETE: nothing differs, but not every policy could be flown again, so its table is a claim")
    else:
        count = len(verdict.differences)
        lines.append(f"NOT verified: {count} value{'s' * (count > 1)} differ{'s' * (count == 1)}")
    return "\n".join(lines)
