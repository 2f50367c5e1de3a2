"""Scores policies on the same episodes of a road; the counterpart of `rss_gym.eval.evaluate`."""

from __future__ import annotations

import functools
import json
import multiprocessing
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

import numpy as np
from tqdm import tqdm

from rss_gym.baselines import road
from rss_gym.core import checked_seed
from rss_gym.eval.costs import Prices
from rss_gym.eval.episodes import Block
from rss_gym.eval.evaluate import Result, Scored
from rss_gym.eval.intervals import mean_t
from rss_gym.eval.metrics import METRICS, Estimate, Flights, measure
from rss_gym.eval.policies import Entry, folder_name
from rss_gym.eval.road.drives import DEVIATIONS, drive, environment
from rss_gym.eval.road.suites import SUITES, RoadSuite
from rss_gym.eval.table import TABLE
from rss_gym.eval.workers import NOMINAL
from rss_gym.params import Params, ParamsError, suggestion

ALL = "all"
AIRBORNE = ("zone_severity",)  # not on a road: how deep a zone was entered that is not one of fixed radius
NAMES = tuple(name for name in METRICS.shipped if name not in AIRBORNE)
UNITS = {"lane_deviation_m": "m", "speed_deviation_mps": "m/s"}
CHUNK = 10  # episodes that a worker is given at a time


@dataclass(frozen=True)
class RoadEntry(Entry):
    """A policy to score on a road."""

    @property
    def hash(self) -> str:
        """SHA-256 of the specification, for a learned policy of its files, and of what it is told."""
        text = json.dumps([getattr(self.policy, "digest", self.spec), self.params.interface.information])
        return sha256(text.encode()).hexdigest()


@dataclass(frozen=True, repr=False)
class RoadResult(Result):
    """As `Result`; `deviations` are the DEVIATIONS of each policy, in the order of the policies."""

    deviations: tuple[np.ndarray, ...] = ()


def check(policies: Sequence[str], suite: str, reference: str | None = None, **changes: Any) -> None:
    """Refuse what `evaluate` would, without driving.

    Raises
    ------
    ParamsError
    """
    _prepared(policies, _find(suite).changed(**changes), reference)


def evaluate(
    policies: Sequence[str],
    suite: str = "highway-v0",
    episodes: int | None = None,
    seed: int | None = None,
    workers: int = 1,
    reference: str | None = None,
    progress: bool | None = None,
    **changes: Any,
) -> RoadResult:
    """Drive policies over the same episodes of a road and compute the metrics.

    Parameters
    ----------
    policies : sequence of str
        Names as `rss_gym.baselines.road.make` takes them; `all` stands for every scripted one. `none` is added.
    suite : str
        One of `SUITES`.
    episodes, seed : int, optional
        Default: the suite's own, which make the run official.
    workers : int
        Processes.
    reference : str, optional
        Name of the policy that completed-only figures are compared with; default: the first one given.
    progress : bool, optional
        Show a progress bar; default: when the error stream is a terminal.
    **changes
        `channel`, `information` or `estimator`.

    Raises
    ------
    ParamsError
        For unknown names, numbers out of range, or a missing highway-env.
    PolicyError
        When a policy raises or returns something that is not an action.
    """
    base = _find(suite)
    driven = base.changed(**changes)
    entries, reference = _prepared(policies, driven, reference)
    count = base.episodes if episodes is None else episodes
    first = base.seed if seed is None else checked_seed(seed)
    for name, value in (("episodes", count), ("workers", workers)):
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 1:
            raise ParamsError(f"{name} must be a whole number >= 1, got {value!r}")
    blocks = [Block(driven.split, first, range(at, min(at + CHUNK, count))) for at in range(0, count, CHUNK)]
    tables = [np.zeros(count, TABLE) for _ in entries]
    deviations = [np.zeros(count, DEVIATIONS) for _ in entries]
    show = sys.stderr.isatty() if progress is None else progress
    specs = [entry.spec for entry in entries]
    with tqdm(total=count * len(entries), unit="drive", disable=not show, leave=False) as bar:
        for block, parts in zip(blocks, _driven(specs, driven, blocks, min(workers, len(blocks))), strict=True):
            here = slice(block.episodes[0], block.episodes[-1] + 1)
            for table, deviation, part in zip(tables, deviations, parts, strict=True):
                table[here], deviation[here] = part
            bar.update(block.count * len(entries))
    official = driven.hash == base.hash and (first, count) == (base.seed, base.episodes)
    return score(driven, first, entries, tables, deviations, reference, official)


def score(
    suite: RoadSuite,
    seed: int,
    entries: list[RoadEntry],
    tables: list[np.ndarray],
    deviations: list[np.ndarray],
    reference: str,
    official: bool,
) -> RoadResult:
    """Every metric of every policy from the tables alone."""
    names, zone = [entry.name for entry in entries], suite.params.zone
    none = tables[names.index(NOMINAL)]
    scored = []
    for entry, table, deviation in zip(entries, tables, deviations, strict=True):
        flights = Flights(
            table=table,
            none=none,
            reference=tables[names.index(reference)],
            suite_radius_m=zone.radius_m,
            trials=zone.trials,
            range_error_probability=zone.range_error_probability,
            reaction_s=zone.reaction_s,
            prices=Prices.of(suite.params),
        )
        means = {name: Estimate(*mean_t(deviation[name]), unit=unit) for name, unit in UNITS.items()}
        scored.append(Scored(entry, table, measure(flights, NAMES) | means))
    return RoadResult(suite, seed, len(none), official, tuple(scored), reference, deviations=tuple(deviations))


Part = list[tuple[np.ndarray, np.ndarray]]  # table and deviations of each policy


def _driven(specs: list[str], suite: RoadSuite, blocks: list[Block], workers: int) -> Iterator[Part]:
    """The parts of each block, in order."""
    task = functools.partial(_drive_block, specs, suite)
    if workers == 1:
        yield from map(task, blocks)
        return
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as pool:
        yield from pool.map(task, blocks)


def _drive_block(specs: list[str], suite: RoadSuite, block: Block) -> Part:
    """Drive all policies over one block, `none` first, whose positions manoeuvres are measured from."""
    found: dict[str, Part] = {}
    nominal: list[np.ndarray] | None = None
    for spec in [NOMINAL, *(spec for spec in specs if spec != NOMINAL)]:
        policy, env = _made(spec, suite)
        rows, deviations, positions = zip(*drive(policy, spec, env, block, nominal), strict=True)
        nominal = list(positions) if nominal is None else nominal
        found[spec] = [(np.concatenate(rows), np.concatenate(deviations))]
    return [found[spec][0] for spec in specs]


_MADE: dict[tuple[str, str], tuple[Any, Any]] = {}  # environments are slow to make; one of each in a process


def _made(spec: str, suite: RoadSuite) -> tuple[Any, Any]:
    if (spec, suite.hash) not in _MADE:
        policy = _policy(spec, suite)
        _MADE[spec, suite.hash] = policy, environment(suite, policy.keywords)
    return _MADE[spec, suite.hash]


def _policy(spec: str, suite: RoadSuite) -> Any:
    env = environment(suite, {})
    env.reset(seed=0)
    return road.make(spec, road.World.of(env))


def _find(name: str) -> RoadSuite:
    if name not in SUITES:
        raise ParamsError(f"road {name!r} is unknown{suggestion(name, SUITES)}")
    return SUITES[name]


def _prepared(policies: Sequence[str], suite: RoadSuite, reference: str | None) -> tuple[list[RoadEntry], str]:
    """The policies as entries, and which of them the others are compared with."""
    _MADE.clear()  # a folder may hold another driver by now
    given = [name for item in policies for name in (road.POLICIES if item == ALL else [item])]
    if NOMINAL not in given:
        given.insert(0, NOMINAL)
    entries: list[RoadEntry] = []
    for spec in given:
        policy = _made(spec, suite)[0]
        name = folder_name(spec) if getattr(policy, "digest", "") else spec
        if name in [entry.name for entry in entries]:
            raise ParamsError(f"policy {name!r} is given twice")
        told = getattr(policy, "information", None)  # who is told more is no rival
        world = Params.of(suite.params, information=told, tracker="fused") if told else suite.params
        entries.append(RoadEntry(name, spec, policy, world))
    reference = reference or entries[1 if len(entries) > 1 else 0].name
    if reference not in [entry.name for entry in entries]:
        raise ParamsError(f"reference {reference!r} is not among the policies driven")
    return entries, reference
