"""What every study shares: jobs that fly records, scores read back from them, and the parts of pages that it writes."""

from __future__ import annotations

import argparse
import hashlib
import json
import re
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from rss_gym import baselines
from rss_gym.baselines import policy_files
from rss_gym.eval.evaluate import evaluate
from rss_gym.eval.metrics import Estimate
from rss_gym.eval.records import SCORES, save, versions
from rss_gym.eval.suites import find
from rss_gym.files import write_bytes, write_text
from rss_gym.params import ParamsError

RUNS = Path("runs/studies")
"""Where records are kept unless the command names another folder, so that an interrupted study goes on."""


class Study(Protocol):
    """A study as a module of this package: how it is called, and its parts one after another."""

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Declare the options of `rss-gym study NAME`; `--pages` and `--workers` are those of every study."""
        ...

    def run(self, options: argparse.Namespace) -> Iterator[Part]:
        """Fly what is missing and yield each part when it is known.

        Raises
        ------
        ParamsError
            If an option cannot be followed.
        """
        ...


@dataclass(frozen=True)
class Part:
    """What a study has found: text for the terminal, and its place in the repository.

    Attributes
    ----------
    text : str
        Printed.
    path : str
        File it belongs to, from the root of a clone; empty if it is only printed.
    content : str or bytes, optional
        What the file gets; default: `text`.
    mark : str, optional
        Name of the marks `<!-- name -->` and `<!-- /name -->` of the file between which the content stands; without
        one it is the whole file.
    """

    text: str
    path: str = ""
    content: str | bytes | None = None
    mark: str | None = None

    def put(self, root: Path) -> None:
        """Write it into the clone at `root`.

        Raises
        ------
        ParamsError
            If the file or its marks are missing, or it cannot be written.
        """
        if not self.path:
            return
        path, content = root / self.path, self.text if self.content is None else self.content
        if isinstance(content, bytes):
            write_bytes(path, content)
            return
        if self.mark is None:
            write_text(path, content)
            return
        try:
            before = path.read_text(encoding="utf-8")
        except OSError as error:
            raise ParamsError(
                f"page {str(path)!r} cannot be read; --pages names the root of a clone: {error}"
            ) from error
        marked = rf"(<!-- {self.mark} -->\n).*?(<!-- /{self.mark} -->)"
        after, count = re.subn(marked, lambda found: f"{found[1]}{content}\n{found[2]}", before, flags=re.DOTALL)
        if count != 1:
            raise ParamsError(f"page {str(path)!r} must have the marks <!-- {self.mark} --> once, got {count} times")
        write_text(path, after)


@dataclass(frozen=True)
class Job:
    """What one record holds: policies in a suite of the air or of a road, with changes to its world."""

    name: str
    suite: str
    policies: tuple[str, ...]
    episodes: int
    seed: int = 0
    changes: dict[str, Any] = field(default_factory=dict)

    @property
    def folder(self) -> str:
        """Named by the job and by everything that defines it."""
        hashes = [find(self.suite).changed(**self.changes).hash, *(agent_digest(name) for name in self.policies)]
        content = json.dumps([hashes, self.policies, self.episodes, self.seed])
        return f"{self.name}-{hashlib.sha256(content.encode()).hexdigest()[:8]}"

    @property
    def flights(self) -> int:
        """How many it flies, those of `none` included."""
        return self.episodes * len({*self.policies, "none"})

    def fly(self, folder: Path, workers: int) -> None:
        """Fly them all and save the record."""
        settings: dict[str, Any] = {
            "suite": self.suite,
            "episodes": self.episodes,
            "seed": self.seed,
            "workers": workers,
        }
        save(evaluate(self.policies, progress=False, **settings, **self.changes), folder)


def agent_digest(name: str) -> str:
    """What a name alone does not tell of a learned policy; empty for a scripted one."""
    folder = baselines.AGENTS.get(name) or (Path(name) if baselines.is_folder(name) else None)
    return hashlib.sha256(b"".join(policy_files.read(folder))).hexdigest() if folder else ""


def fly(jobs: Sequence[Job], workers: int, runs: Path = RUNS) -> dict[str, Path]:
    """Fly the jobs that are not yet on disk, one after another; an interrupted study goes on where it stopped.

    A folder's name tells what is flown, not by which code: remove `runs` after a change of the world or of a policy.

    Returns
    -------
    dict
        Name of each job -> folder of its record.
    """
    folders = {job.name: runs / job.folder for job in jobs}
    left = [job for job in jobs if not folders[job.name].exists()]
    print(f"{len(jobs)} records, {len(jobs) - len(left)} of them flown before", flush=True)
    start, done, total = time.monotonic(), 0, sum(job.flights for job in left)
    for number, job in enumerate(left, 1):
        job.fly(folders[job.name], workers)
        done += job.flights
        minutes = (time.monotonic() - start) / 60.0
        print(
            f"{number}/{len(left)} {job.name}: {job.flights} flights; {minutes:.1f} min, "
            f"about {minutes * (total - done) / done:.0f} left",
            flush=True,
        )
    return folders


@dataclass(frozen=True)
class ScoreRow:
    """One policy's scores, read from a record."""

    spec: str
    episodes: int
    metrics: dict[str, Estimate]


def read(folders: Iterable[Path]) -> dict[str, ScoreRow]:
    """The policies of records over the same encounters."""
    rows = {}
    for folder in folders:
        scores = json.loads((folder / SCORES).read_text(encoding="utf-8"))
        for policy in scores["policies"]:
            metrics = {name: Estimate(**value) for name, value in policy["metrics"].items()}
            rows[policy["spec"]] = ScoreRow(policy["spec"], scores["episodes"], metrics)
    return rows


def made(study: str, episodes: int | None = None, *packages: str) -> str:
    """By what and with which versions, as a sentence."""
    used = ", ".join(f"{name} {number}" for name, number in versions(*packages).items())
    count = f"{episodes:,} encounters, split `suite`, seed 0" if episodes else "Split `suite`, seed 0"
    return f"{count}; 95 % intervals in brackets; made by `rss-gym study {study}` with {used}."
