"""Locks between processes. They are the operating system's, so they end with the process that holds them."""

from __future__ import annotations

import errno
import sys

if sys.platform == "win32":
    import msvcrt

    def _take(descriptor: int) -> None:
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)

    def _free(descriptor: int) -> None:
        msvcrt.locking(descriptor, msvcrt.LK_UNLCK, 1)
else:
    import fcntl

    def _take(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def _free(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_UN)


_HELD = {errno.EACCES, errno.EAGAIN, errno.EDEADLK, errno.EWOULDBLOCK}


def take(descriptor: int) -> bool:
    """Take the lock of an open file; False if another process holds it.

    Raises
    ------
    OSError
        If the file system has no locks.
    """
    try:
        _take(descriptor)
    except OSError as error:
        if error.errno in _HELD:
            return False
        raise
    return True


def free(descriptor: int) -> None:
    """Give the lock back."""
    _free(descriptor)
