"""Flies what is not yet on disk, one record after another, so that an interrupted run goes on where it stopped."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from rss_gym.eval import Result, records


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
        """How many it flies, those of `none` included."""
        ...

    def evaluate(self, workers: int) -> Result:
        """Fly it."""
        ...


def fly(jobs: Sequence[Job], workers: int) -> None:
    """Fly the jobs that are not yet in their folders."""
    left = [job for job in jobs if not job.folder.exists()]
    print(f"{len(jobs)} records, {len(jobs) - len(left)} of them flown before", flush=True)
    start, done, total = time.monotonic(), 0, sum(job.flights for job in left)
    for number, job in enumerate(left, 1):
        records.save(job.evaluate(workers), job.folder)
        done += job.flights
        minutes = (time.monotonic() - start) / 60.0
        print(
            f"{number}/{len(left)} {job.name}: {job.flights} flights; {minutes:.1f} min, "
            f"about {minutes * (total - done) / done:.0f} left",
            flush=True,
        )
