"""Flies the entries of a season, and appends a signed line for each entry and suite; goes on where it was ended."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import re
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rss_gym import baselines
from rss_gym.eval.board import chain, season, verdict
from rss_gym.eval.board.entry import ENTRY, FILES, Submission
from rss_gym.eval.board.gather import gather
from rss_gym.eval.board.limits import Job, fly_limited
from rss_gym.eval.board.names import folded
from rss_gym.eval.board.season import Flown, Season, sealed_seed
from rss_gym.eval.board.signing import private_key, public_key
from rss_gym.eval.budget import refuse_costly
from rss_gym.eval.episodes import PolicyError
from rss_gym.eval.policies import entry
from rss_gym.eval.reading.plain import RecordError
from rss_gym.eval.records import table_digest
from rss_gym.eval.suites import SUITES, Suite
from rss_gym.eval.table import TABLES
from rss_gym.eval.workers import NOMINAL
from rss_gym.files import write_bytes
from rss_gym.locking import free, take
from rss_gym.params import ParamsError

BLOCK = {"air": 5000, "road": 100}  # encounters of one child, which are flown again if a process is killed meanwhile
ENTRIES, WORK, UNPACKED, LOCK, KEY = "entries", "work", "unpacked", ".lock", "board.key"
MADDS_MAX = 4_000_000  # multiplications of a policy's network at a decision
Runner = Callable[[Job], np.ndarray]


@dataclass(frozen=True)
class Flights:
    """What `fly` has done: lines appended, lines that were there, and the entries refused, each with why."""

    appended: tuple[dict[str, Any], ...]
    before: int
    refused: tuple[str, ...]


@dataclass(frozen=True)
class Places:
    """Where the board's files are: what may be published, and what may not before the season closes.

    Attributes
    ----------
    board : Path
        Holds `board.jsonl` and the entries flown.
    private : Path
        Holds the tables of sealed encounters; beside the season's file.
    key : Path
        Signs the lines of all seasons whose files are in one folder.
    """

    board: Path
    private: Path
    key: Path

    @classmethod
    def of(cls, out: str | os.PathLike[str], season_file: str | os.PathLike[str]) -> Places:
        """Those of a season."""
        file = Path(season_file)
        return cls(Path(out), file.with_suffix(".private"), file.parent / KEY)

    @property
    def lines(self) -> Path:
        """The chain."""
        return self.board / chain.BOARD


def check_policy(submission: Submission, suite: Suite) -> None:
    """Refuse an entry whose policy cannot fly in a suite, or that costs too much there.

    Raises
    ------
    ParamsError
    """
    refuse_costly(suite.params, [submission.policy])
    policy = entry(submission.spec, suite.params, submission.name).policy
    while hasattr(policy, "base"):
        policy = policy.base
    if isinstance(policy, baselines.Agent):
        madds = sum(int(np.prod(shape)) for shape in policy.network.shapes(policy.params).values())
        if madds > MADDS_MAX:
            raise ParamsError(f"the network has {madds:,} numbers; it must have at most {MADDS_MAX:,}")


def own_entries(suite: Suite, folder: Path) -> Iterator[Submission]:
    """The policies of the package that can fly on a suite, as the board's own entries."""
    for name in baselines.able(suite.params):
        digest = hashlib.sha256(f"package {name}".encode()).hexdigest()
        text = "A policy of the package, flown as a reference."
        facts = {"author": "rss-gym", "date": "2026-11-27", "licence": "MIT", "link": "", "suite": suite.name}
        yield Submission(folder, name, policy=name, card=text, hash=digest, policy_hash=digest, **facts)


def fly(
    entries: str | os.PathLike[str] | None,
    season_file: str | os.PathLike[str],
    out: str | os.PathLike[str],
    workers: int = 1,
    executor: Executor | None = None,
    runner: Runner = fly_limited,
    references: bool = True,
    say: Callable[[str], object] = lambda sentence: None,
) -> Flights:
    """Fly all entries over the season's public and sealed encounters.

    Parameters
    ----------
    entries : path or None
        Folder of folders, see `entry`.
    season_file : path
    out : path
        Folder of the board; lines are appended to its `board.jsonl`, what is there is not flown again.
    workers : int
        Children at a time.
    executor : concurrent.futures.Executor, optional
        Where the jobs run in place of `workers` threads that each start children.
    runner : callable
        Flies a job; default: in a child process with limits.
    references : bool
        Fly the policies of the package too.
    say : callable
        Told about each line.

    Raises
    ------
    ParamsError
        If the season, the board or the folder of entries cannot be read, or another process flies it.
    """
    places, current = Places.of(out, season_file), season.load(season_file)
    secret = season.secret_of(season_file)
    for folder in (places.board, places.private):
        folder.mkdir(parents=True, exist_ok=True)
    os.chmod(places.private, 0o700)
    key = private_key(places.key)
    with held(places.board), _pool(workers, executor) as pool:
        lines = [line for line in chain.read(places.lines, public_key(key)) if line["kind"] == verdict.KIND]
        known = [(line["entry"]["name"], line["entry"]["author"], line["policy_hash"]) for line in lines]
        found = gather(entries, known, places.private / UNPACKED) if entries is not None else None
        refused = list(found.refused) if found else []
        submissions = list(found.entries) if found else []
        done = {verdict.key_of(line["season"], line["rules"], line["suite_hash"], line["entry_hash"]) for line in lines}
        counted: dict[tuple[str, str, str], set[str]] = {}  # an author's entries on a suite: one, of whatever rules
        for line in lines:
            if line["entry"]["link"]:
                owner = line["season"], line["suite"], folded(line["entry"]["author"])
                counted.setdefault(owner, set()).add(line["entry_hash"])
        appended: list[dict[str, Any]] = []
        for flown in current.suites:
            suite = flown.suite()
            members = list(own_entries(suite, places.board)) if references else []
            for one in submissions:
                if not one.flies(suite):
                    continue
                try:
                    check_policy(one, suite)
                except ParamsError as error:
                    refused.append(f"{one.folder}: {flown.name}: {error}")
                else:
                    members.append(one)
            for one in members:
                if verdict.key_of(current.name, verdict.RULES, flown.hash, one.hash) in done:
                    continue
                there = counted.get((current.name, flown.name, folded(one.author)), set())
                if one.link and there and one.hash not in there:
                    refused.append(f"{one.folder}: {one.author!r} has an entry on {flown.name} in this season already")
                    continue
                line = _flown(current, flown, one, secret, places, pool, runner)
                _keep(one, places)
                appended.append(chain.append(places.lines, line, key))
                say(_sentence(appended[-1]))
        return Flights(tuple(appended), len(lines), tuple(dict.fromkeys(refused)))


def _flown(
    current: Season, flown: Flown, one: Submission, secret: str, places: Places, pool: Executor, runner: Runner
) -> dict[str, Any]:
    """The line of one entry on one suite."""
    suite, tables = flown.suite(), []
    runs = ((suite.seed, flown.public, "public"), (sealed_seed(secret, flown.name), flown.sealed, "sealed"))
    try:
        for seed, count, part in runs:
            pair = []
            for spec, name, hashed in (
                (NOMINAL, NOMINAL, NOMINAL),
                (one.spec, one.name, _kept_by(one.policy, one.hash)),
            ):
                job = Job(suite.name, suite.hash, spec, name, suite.split, seed, 0, count)
                pair.append(_table(job, hashed, places.private / WORK / current.name / part, pool, runner))
            tables.append(tuple(pair))
    except PolicyError as error:
        return verdict.failed(current, flown, one, str(error).replace(str(runs[1][0]), "(sealed)"))
    line = verdict.verdict(current, flown, one, tables[0], tables[1])
    verdict.refuse_not_finite(line)
    return line


def _kept_by(policy: str, hashed: str) -> str:
    """What the tables of an entry are kept by: those of `none` are the same for everybody."""
    return NOMINAL if policy == NOMINAL else hashed


def _table(job: Job, hashed: str, folder: Path, pool: Executor, runner: Runner) -> np.ndarray:
    """The table of a job, block by block, each kept as soon as it is flown, so that a killed process loses one."""
    domain = job.world().domain.name
    dtype, block = TABLES[domain], BLOCK[domain]
    waiting: list[tuple[Path, int, Future[np.ndarray] | None]] = []
    for first in range(0, job.count, block):
        count = min(block, job.count - first)
        file = folder / f"{job.suite}-{job.suite_hash[:12]}-{job.seed}-{hashed[:32]}-{first}-{count}"
        is_there = file.is_file() and file.stat().st_size == count * dtype.itemsize
        part = dataclasses.replace(job, first=first, count=count)
        waiting.append((file, count, None if is_there else pool.submit(runner, part)))
    parts = []
    for file, count, future in waiting:
        if future is not None:
            table = future.result()
            if len(table) != count:
                raise PolicyError(f"entry {job.name!r}: {len(table)} encounters came back instead of {count}")
            file.parent.mkdir(parents=True, exist_ok=True)
            write_bytes(file, np.ascontiguousarray(table, dtype).tobytes())
        parts.append(np.frombuffer(file.read_bytes(), dtype))
    return np.concatenate(parts)


def tables_of(line: dict[str, Any], places: Places, seed: int, part: str) -> np.ndarray | None:
    """The table of a line, if it is still there and is the one that was signed."""
    folder = places.private / WORK / line["season"] / part
    hashed = _kept_by(line["entry"]["policy"], line["entry_hash"])[:32]
    stem = f"{line['suite']}-{line['suite_hash'][:12]}-{seed}-{hashed}-"
    if line["suite"] not in SUITES or not folder.is_dir():
        return None
    files = sorted(folder.glob(stem + "*"), key=lambda file: int(re.split("-", file.name)[-2]))
    dtype = TABLES[SUITES[line["suite"]].domain.name]
    if not files:
        return None
    table = np.concatenate([np.frombuffer(file.read_bytes(), dtype) for file in files])
    return table if table_digest(table) == line[part]["table_sha256"] else None


def _keep(one: Submission, places: Places) -> None:
    """A copy of the entry's files beside the board, by its hash."""
    target = places.board / ENTRIES / one.hash[:16]
    if not one.link or target.exists():
        return
    for name in FILES:
        if (one.folder / name).is_file():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(one.folder / name, target / name, follow_symlinks=False)
    if not (target / ENTRY).is_file():
        raise RecordError(f"{one.folder} is gone while it was flown")


def _sentence(line: dict[str, Any]) -> str:
    name = f"{line['suite']}: {line['entry']['name']}"
    if line["failed"]:
        return f"{name}: {line['failed']}"
    costs = [line[part]["metrics"]["cost_m"]["value"] for part in ("public", "sealed")]
    return f"{name}: cost {costs[0]:.4g} m public, {costs[1]:.4g} m sealed"


@contextmanager
def _pool(workers: int, executor: Executor | None) -> Iterator[Executor]:
    if executor is not None:
        yield executor
        return
    with ThreadPoolExecutor(workers) as pool:
        yield pool


@contextmanager
def held(folder: Path) -> Iterator[None]:
    """Hold the board; two processes must not append to one chain."""
    descriptor = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o600)
    try:
        if not take(descriptor):
            raise ParamsError(f"{str(folder)!r} is in use by another process that flies its entries")
        try:
            yield
        finally:
            free(descriptor)
    finally:
        os.close(descriptor)
