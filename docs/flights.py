"""Flies what is not yet on disk, one record after another, so that an interrupted run goes on where it stopped."""

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

from rss_gym.eval import Result, records
from rss_gym.files import write_text


class Job(Protocol):
    """What one record holds, and how to fly it."""

    @property
    def name(self) -> str:
        """For the lines printed."""
        ...

    @property
    def folder(self) -> Path:
        """Named by everything that defines the job."""
        ...

    @property
    def flights(self) -> int:
        """With those of `none`."""
        ...

    @property
    def cost(self) -> float:
        """Time that it takes, in flights of a cheap rule."""
        ...

    def evaluate(self) -> Result:
        """Fly it."""
        ...


def fly(jobs: Sequence[Job], beside: Mapping[str, str] | None = None) -> None:
    """Fly the jobs that are not yet in their folders, and write the files `beside`, text by name, into these."""

    def write(_: Result, folder: Path) -> None:
        for name, text in (beside or {}).items():
            write_text(folder / name, text)

    left = [job for job in jobs if not job.folder.exists()]
    print(f"{len(jobs)} jobs, {len(jobs) - len(left)} of them flown before", flush=True)
    start, done, total = time.monotonic(), 0.0, sum(job.cost for job in left)
    for number, job in enumerate(left, 1):
        begun = time.monotonic()
        records.save(job.evaluate(), job.folder, page=write)
        now, done = time.monotonic(), done + job.cost
        minutes = (now - start) / 60.0
        print(
            f"{number}/{len(left)} {job.name}: {job.flights} flights, {job.flights / (now - begun):.0f} a second; "
            f"{minutes:.1f} min, about {minutes * (total - done) / done:.0f} left",
            flush=True,
        )
