"""Worker processes that end with the process that started them, however that ends."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing.connection import Connection

from tqdm import tqdm


@contextlib.contextmanager
def process_pool(count: int) -> Iterator[ProcessPoolExecutor]:
    """So many processes; an error inside the `with` block ends them at once."""
    # A worker ends as soon as the other end of this pipe is closed, be it here or because this process was killed.
    lifeline, held = multiprocessing.Pipe(duplex=False)
    # Spawned, not forked: the same on every system, and no thread is copied in the middle of its work.
    spawn = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(count, spawn, initializer=_begin, initargs=(lifeline,))
    try:
        yield pool
    except BaseException:
        held.close()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
        held.close()
        lifeline.close()


@contextlib.contextmanager
def interrupts_held() -> Iterator[None]:
    """Hold Ctrl-C back; processes started meanwhile never see it, so that only this one decides what it ends."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin(lifeline: Connection) -> None:
    tqdm.set_lock(threading.RLock())  # its own is shared between processes, and left behind by one that ends at once
    threading.Thread(target=_end_with, args=(lifeline,), daemon=True).start()


def _end_with(lifeline: Connection) -> None:
    """End this process, at once, when the other end of the pipe is closed."""
    with contextlib.suppress(OSError):  # how Windows says that the other end is closed
        lifeline.poll(None)  # nothing is ever sent
    os._exit(1)
