"""Flies blocks of episodes in this process, in several, or on an executor, in order, with the same result."""

from __future__ import annotations

import functools
import multiprocessing
import pickle
from collections import deque
from collections.abc import Generator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future

import numpy as np

from rss_gym import registry
from rss_gym.eval.episodes import Block, PolicyError, WorkerError, described, fly_episodes
from rss_gym.eval.policies import Entry, entry
from rss_gym.eval.processes import interrupts_held, process_pool
from rss_gym.params import Params, ParamsError

NOMINAL = "none"  # the denominator of every risk ratio

# Name, specification and hash to build a policy by, or a pickled `Entry`
Recipe = tuple[str, str, str] | bytes
Recipes = tuple[Recipe, ...]


def fly_block(entries: Sequence[Entry], block: Block) -> list[np.ndarray]:
    """Fly all policies over one block, `none` first, whose positions the manoeuvres of the others are measured from."""
    nominal = next(item for item in entries if item.name == NOMINAL)
    table, positions = fly_episodes(nominal.policy, nominal.name, nominal.params, block)
    return [
        table if item is nominal else fly_episodes(item.policy, item.name, item.params, block, positions)[0]
        for item in entries
    ]


def fly_blocks(
    entries: Sequence[Entry],
    named: Sequence[bool],
    params: Params,
    blocks: Sequence[Block],
    workers: int = 1,
    executor: Executor | None = None,
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
        Processes; one means this one, and so does a daemon process, which may start none of its own.
    executor : concurrent.futures.Executor, optional
        Where the blocks are flown in place of such processes.

    Raises
    ------
    ParamsError
        If a policy, or a part that was registered, cannot be sent to a worker.
    PolicyError
        When a policy fails, or a worker process dies.
    """
    processes = min(workers, len(blocks))
    if executor is None and (processes == 1 or multiprocessing.current_process().daemon):
        for block in blocks:
            yield fly_block(entries, block)
        return
    recipes = recipes_of(entries, named)
    if executor is not None:
        yield from _submitted(executor, recipes, params, blocks)
        return
    with process_pool(processes) as pool:
        yield from _submitted(pool, recipes, params, blocks)


def _submitted(
    executor: Executor, recipes: Recipes, params: Params, blocks: Sequence[Block]
) -> Generator[list[np.ndarray]]:
    """The tables of the blocks in order, each let go of as soon as it has been taken."""
    sent = registry.added()
    waiting: deque[Future[list[np.ndarray]]] = deque()
    try:
        with interrupts_held():
            for block in blocks:
                waiting.append(executor.submit(fly_sent, sent, recipes, params, block))
        while waiting:
            yield waiting.popleft().result()
    except BrokenExecutor as error:
        raise WorkerError(
            "a worker process died (out of memory, killed, or ended by a policy; or the script that calls `evaluate` "
            "lacks `if __name__ == '__main__':`); nothing was scored"
        ) from error
    finally:
        for future in waiting:
            future.cancel()


def recipes_of(entries: Sequence[Entry], named: Sequence[bool]) -> Recipes:
    """What another process builds the policies by.

    Raises
    ------
    ParamsError
        If an object cannot be pickled.
    """
    return tuple(_recipe(*pair) for pair in zip(entries, named, strict=True))


def _recipe(item: Entry, named: bool) -> Recipe:
    if named:
        return item.name, item.spec, item.hash
    try:
        return pickle.dumps(item)
    except Exception as error:  # __reduce__ may raise anything
        raise ParamsError(
            f"policy {item.name!r} is an object that cannot be sent to worker processes ({described(error)}); "
            "give it as module:attribute, or use workers=1"
        ) from error


# In the worker


def fly_sent(sent: bytes, recipes: Recipes, params: Params, block: Block) -> list[np.ndarray]:
    """`fly_block` with the policies of these recipes, in whatever process; `sent` is what `registry.added` gave."""
    registry.restore(sent)
    return fly_block(entries_of(recipes, params), block)


@functools.lru_cache(maxsize=1)
def entries_of(recipes: Recipes, params: Params) -> list[Entry]:
    """The policies, built at the first block, where an error travels back as itself, and kept for the next ones."""
    return [_loaded(recipe) if isinstance(recipe, bytes) else _built(*recipe, params) for recipe in recipes]


def _built(name: str, spec: str, hashed: str, params: Params) -> Entry:
    built = entry(spec, params, name)
    if built.hash != hashed:
        raise PolicyError(
            f"policy {name!r}: {spec!r} is another policy in the worker process; each must find the same files"
        )
    return built


def _loaded(pickled: bytes) -> Entry:
    try:
        loaded: Entry = pickle.loads(pickled)
        return loaded
    except Exception as error:
        raise PolicyError(
            f"a policy given as an object cannot be loaded in a worker process ({described(error)}); "
            "give it as module:attribute, or use workers=1"
        ) from error
