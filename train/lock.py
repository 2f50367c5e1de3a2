"""One process at a time: a lock of the operating system, which ends with the process that holds it, however it ends."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rss_gym.params import ParamsError

if sys.platform == "win32":
    import msvcrt

    def _take(descriptor: int) -> None:
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
else:
    import fcntl

    def _take(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold the lock of the file `path`, which is made if need be and stays.

    Raises
    ------
    ParamsError
        If another process holds it.
    """
    with open(path, "ab") as file:
        try:
            _take(file.fileno())
        except OSError as error:
            raise ParamsError(f"{str(path.parent)!r} is being trained by another process; end it first") from error
        yield  # closing the file frees it
