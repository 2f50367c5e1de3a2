"""One process at a time: a lock of the operating system, which ends with the process that holds it, however it ends."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rss_gym.locking import take
from rss_gym.params import ParamsError


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold the lock of the file `path`, which is made if need be and stays.

    On a file system without locks it is said that there is none, and the work goes on.

    Raises
    ------
    ParamsError
        If another process holds it, or the file cannot be written.
    """
    try:
        file = open(path, "ab")
    except OSError as error:
        raise ParamsError(f"{str(path.parent)!r} cannot be written: {error.strerror or error}") from error
    with file:
        try:
            if not take(file.fileno()):
                raise ParamsError(f"{str(path.parent)!r} is being trained by another process; end it first")
        except OSError as error:
            print(
                f"rss-gym: {str(path.parent)!r} cannot be locked ({error.strerror or error}): see to it that no other "
                "process trains it",
                file=sys.stderr,
            )
        yield  # closing the file frees it
