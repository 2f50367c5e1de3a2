"""Flies blocks of episodes in this process or in several, in order, with the same result."""

from __future__ import annotations

import contextlib
import functools
import multiprocessing
import os
import pickle
import signal
import threading
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import Connection

import numpy as np

from rss_gym.eval.episodes import Block, PolicyError, described, fly
from rss_gym.eval.policies import Entry, entry
from rss_gym.params import Params, ParamsError

NOMINAL = "none"  # the denominator of every risk ratio

Recipe = tuple[str, str] | bytes  # name and specification to build a policy by, or a pickled `Entry`


def fly_block(entries: Sequence[Entry], block: Block) -> list[np.ndarray]:
    """Fly all policies over one block, `none` first, whose positions the manoeuvres of the others are measured from."""
    nominal = next(item for item in entries if item.name == NOMINAL)
    table, positions = fly(nominal.policy, nominal.name, nominal.world, block)
    return [
        table if item is nominal else fly(item.policy, item.name, item.world, block, positions)[0] for item in entries
    ]


def fly_blocks(
    entries: Sequence[Entry], named: Sequence[bool], params: Params, blocks: Sequence[Block], workers: int
) -> Generator[list[np.ndarray]]:
    """The tables of each block, in order; close the iterator to stop the workers.

    Parameters
    ----------
    entries : sequence of Entry
        With `none` among them.
    named : sequence of bool
        Whether the entry's specification builds it; such policies are built anew in each worker, others are pickled.
    params : Params
        The suite's world, to build them in.
    blocks : sequence of Block
    workers : int
        Processes; one means this one.

    Raises
    ------
    ParamsError
        If a policy cannot be sent to a worker.
    PolicyError
        When a policy fails, or a worker process dies.
    """
    recipes = [_recipe(*pair) for pair in zip(entries, named, strict=True)] if workers > 1 else []
    processes = min(workers, len(blocks))
    if processes == 1:
        for block in blocks:
            yield fly_block(entries, block)
        return
    # A worker ends as soon as the other end of this pipe is closed, be it here or because this process was killed.
    lifeline, held = multiprocessing.Pipe(duplex=False)
    # Spawned, not forked: the same on every system, and no thread is copied in the middle of its work.
    spawn = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(processes, spawn, initializer=_begin, initargs=(lifeline, recipes, params))
    try:
        with interrupts_held():
            results = pool.map(_fly, blocks)
        yield from results
    except BrokenProcessPool as error:
        raise PolicyError(
            "a worker process died (out of memory, killed, or ended by a policy; or the script that calls `evaluate` "
            "lacks `if __name__ == '__main__':`); nothing was scored"
        ) from error
    except BaseException:
        held.close()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
        held.close()
        lifeline.close()


def _recipe(item: Entry, named: bool) -> Recipe:
    if named:
        return item.name, item.spec
    try:
        return pickle.dumps(item)
    except Exception as error:  # __reduce__ may raise anything
        raise ParamsError(
            f"policy {item.name!r} is an object that cannot be sent to worker processes ({described(error)}); "
            "give it as module:attribute, or use workers=1"
        ) from error


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


# In the worker

_world: Params
_recipes: list[Recipe]


def _begin(lifeline: Connection, recipes: list[Recipe], params: Params) -> None:
    global _world, _recipes
    _world, _recipes = params, recipes
    threading.Thread(target=end_with, args=(lifeline,), daemon=True).start()


def end_with(lifeline: Connection) -> None:
    """End this process, at once, when the other end of the pipe is closed."""
    with contextlib.suppress(OSError):  # how Windows says that the other end is closed
        lifeline.poll(None)  # nothing is ever sent
    os._exit(1)


@functools.cache
def _entries() -> list[Entry]:
    """Built at the first block, where an error travels back as itself; one in `_begin` would only break the pool."""
    return [
        _loaded(recipe) if isinstance(recipe, bytes) else entry(recipe[1], _world, recipe[0]) for recipe in _recipes
    ]


def _loaded(pickled: bytes) -> Entry:
    try:
        loaded: Entry = pickle.loads(pickled)
        return loaded
    except Exception as error:
        raise PolicyError(
            f"a policy given as an object cannot be loaded in a worker process ({described(error)}); "
            "give it as module:attribute, or use workers=1"
        ) from error


def _fly(block: Block) -> list[np.ndarray]:
    return fly_block(_entries(), block)
