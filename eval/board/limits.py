"""Flies part of an entry in a child process with limits of time, memory and files; what dies there, dies alone."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rss_gym.eval.episodes import Block, PolicyError
from rss_gym.eval.policies import entry
from rss_gym.eval.suites import Suite, find
from rss_gym.eval.table import TABLES
from rss_gym.eval.workers import NOMINAL, fly_block
from rss_gym.params import ParamsError

MODULE = "rss_gym.eval.board.child"
START_S = 120.0  # of a child's wall and processor time, for its imports and what is compiled
WALL = 20.0  # of the clock for each second of the processor's: the machine may be busy
LINE_MAX = 2000  # bytes of a child's last sentence


@dataclass(frozen=True)
class Limits:
    """What one child may use.

    Attributes
    ----------
    episode_s : float
        Processor time of an encounter, of `none` and the policy together.
    memory_bytes : int
        Address space, of which compiled kernels take about 2 GB.
    """

    episode_s: float = 1.0
    memory_bytes: int = 6 * 2**30


LIMITS = {"air": Limits(), "road": Limits(episode_s=20.0)}  # of each domain: a drive is flown in Python


@dataclass(frozen=True)
class Job:
    """Encounters to fly: plain values, which any executor can send.

    Attributes
    ----------
    suite, suite_hash : str
    spec, name : str
        The specification of the policy, and its name.
    split : str
    seed : int
    first, count : int
        Numbers of the encounters.
    changes : tuple of (name, value)
        Parameters other than the suite's, for `rss-gym board break`.
    numbers : tuple of int
        Encounters in place of `first` and `count`.
    """

    suite: str
    suite_hash: str
    spec: str
    name: str
    split: str
    seed: int
    first: int
    count: int
    changes: tuple[tuple[str, object], ...] = ()
    numbers: tuple[int, ...] = ()

    def world(self) -> Suite:
        """The suite as it is flown.

        Raises
        ------
        ParamsError
            If it is defined otherwise here.
        """
        suite = find(self.suite)
        if suite.hash != self.suite_hash:
            raise ParamsError(f"suite {self.suite!r} is defined otherwise in this process")
        return suite.changed(**dict(self.changes))


def fly_here(job: Job) -> np.ndarray:
    """The episode table of the job, in this process; encounter by encounter the same in any other."""
    suite = job.world()
    entries = [entry(NOMINAL, suite.params, NOMINAL)]
    if job.spec != NOMINAL:
        entries.append(entry(job.spec, suite.params, job.name))
    numbers = job.numbers or range(job.first, job.first + job.count)
    return fly_block(entries, Block(job.split, job.seed, numbers))[-1]


def fly_limited(job: Job, limits: Limits | None = None) -> np.ndarray:
    """`fly_here` in a child process; what comes back are the bytes of a table and nothing that could run.

    Raises
    ------
    PolicyError
        If the child takes more than it may, dies, or says why it cannot fly.
    """
    limits = limits or LIMITS[job.world().domain.name]
    count = len(job.numbers) or job.count
    seconds = START_S + count * limits.episode_s
    with tempfile.TemporaryDirectory(prefix="rss-gym-board-") as folder:
        out = Path(folder) / "table"
        order = {"job": dataclasses.asdict(job), "limits": dataclasses.asdict(limits), "seconds": seconds}
        try:
            done = subprocess.run(
                [sys.executable, "-m", MODULE, str(out)],
                input=json.dumps(order).encode(),
                capture_output=True,
                timeout=WALL * seconds,
                env=_environment(),
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise PolicyError(
                f"entry {job.name!r} took more than {WALL * seconds:.0f} s for {count} encounters"
            ) from None
        if done.returncode != 0:
            last = done.stderr[-LINE_MAX:].decode("utf-8", "replace").strip().splitlines()
            why = last[-1] if last else f"its process ended with {done.returncode}: too much memory or time"
            raise PolicyError(f"entry {job.name!r} on {job.suite}: {why}")
        dtype = TABLES[job.world().domain.name]
        data = out.read_bytes()
        if len(data) != count * dtype.itemsize:
            raise PolicyError(f"entry {job.name!r} on {job.suite}: {len(data)} bytes came back for {count} encounters")
        return np.frombuffer(data, dtype).copy()


def _environment() -> dict[str, str]:
    """The child's environment: one thread, and this package wherever it is imported from."""
    root = str(Path(__file__).resolve().parents[2])
    here = os.pathsep.join(filter(None, [*(p for p in sys.path if p), root if Path(root, "rss_gym").exists() else ""]))
    names = ("PATH", "HOME", "TMPDIR", "LANG", "NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "SYSTEMROOT")
    kept = {name: os.environ[name] for name in names if name in os.environ}
    return kept | {"PYTHONPATH": here, "OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1", "PYTHONHASHSEED": "0"}
