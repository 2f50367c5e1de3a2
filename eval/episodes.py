"""Flies a policy over numbered episodes and fills the episode table."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rss_gym.core import SPLITS, BaseBatch, NotFiniteError
from rss_gym.domain import domain_of
from rss_gym.eval.table import TABLES
from rss_gym.params import Params
from rss_gym.physics.random import uniform
from rss_gym.streams import STREAM_SAMPLE

BLOCK = 2048  # episodes flown side by side; any value gives the same scores
# Columns of a table that are not the episode's own of the same name.
MEASURED = (
    "episode duration_s flown_s manoeuvre_m planned_m deviation_end_m missed_ticks sample_separation_m sample_range_m "
    "fault"
).split()


class PolicyError(RuntimeError):
    """A policy raised, or returned something that is not a batch of actions."""


class WorkerError(PolicyError):
    """A process that flew policies died, which says nothing of what it would have flown."""


@dataclass(frozen=True, slots=True)
class Block:
    """Episodes of one seed and split, flown side by side; `episodes` are their numbers, a range or any others."""

    split: str
    seed: int
    episodes: Sequence[int]

    @property
    def count(self) -> int:
        """How many."""
        return len(self.episodes)

    @property
    def numbers(self) -> np.ndarray:
        """Episode numbers, shape (count,)."""
        return np.array(self.episodes, dtype=np.uint64)

    def __str__(self) -> str:
        """For error sentences."""
        first, last = min(self.episodes), max(self.episodes)
        numbers = f"episode {first}" if first == last else f"{self.count} episodes in {first}..{last}"
        return f"{numbers} of seed {self.seed}, split {self.split!r}"


def start(params: Params, block: Block, is_training: bool = False) -> BaseBatch:
    """A batch on the first decision of the block's episodes."""
    batch, everything = domain_of(params).make_batch(params, block.count), np.ones(block.count, bool)
    batch.is_training = is_training
    batch.seed(np.full(block.count, block.seed, np.uint64))
    batch.split[:], batch.numbers[:] = SPLITS[block.split], block.numbers
    batch.reset(everything)
    return batch


def command(policy: Any, name: str, observations: np.ndarray, state: Any, first: np.ndarray) -> tuple[Any, Any]:
    """Ask the policy; its argument is a copy, so it cannot change what is scored."""
    try:
        answer = policy.predict(observations.copy(), state=state, episode_start=first, deterministic=True)
    except NotFiniteError:  # of a params that the policy looks ahead in: no fault of its own
        raise
    except (Exception, SystemExit) as error:
        raise PolicyError(f"policy {name!r} raised {described(error)}") from error
    if not isinstance(answer, tuple) or len(answer) != 2:
        raise PolicyError(
            f"policy {name!r} must return (actions, state) as SB3's `predict` does, got {type(answer).__name__}"
        )
    return answer


def described(error: BaseException) -> str:
    """An exception in one line: type, text, and where it was raised."""
    text = " ".join(f"{type(error).__name__}: {error}".split())
    calls = traceback.extract_tb(error.__traceback__)
    return f"{text} ({calls[-1].filename}:{calls[-1].lineno})" if calls else text


def checked(actions: Any, name: str, params: Params, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Decoded actions, one a row, and the rows whose action is not finite, which go on with zero."""
    bad = np.zeros(count, bool)
    try:
        values = np.array(actions)
        if values.dtype.kind == "f" and values.ndim == 2 and len(values) == count:
            bad = ~np.isfinite(values).all(axis=1)
            values[bad] = 0.0
        return domain_of(params).decode(values, params, count), bad
    except Exception as error:  # of whatever kind: `actions` is anything a policy may return
        raise PolicyError(f"policy {name!r}: {' '.join(str(error).split())}") from error


def sample_decisions(episode: np.ndarray, params: Params) -> np.ndarray:
    """The decision at which each encounter's range is sampled, drawn from its key: one before its planned approach."""
    approach = np.ceil(episode["approach_s"] / params.clock.decision_s)
    decisions = np.where(approach > 0, approach, episode["ticks"] // params.clock.ticks_per_decision)
    return np.array([int(uniform(e["key"], STREAM_SAMPLE, 0) * n) for e, n in zip(episode, decisions, strict=True)])


def fly_episodes(
    policy: Any,
    name: str,
    params: Params,
    block: Block,
    nominal: list[np.ndarray] | None = None,
    watch: Callable[[BaseBatch], None] | None = None,
    is_training: bool = False,
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Fly every episode of the block to its end.

    Parameters
    ----------
    policy : Policy
        Anything with SB3's `predict`.
    name : str
        For error sentences.
    params : Params
        The policy's params.
    block : Block
        Which episodes.
    nominal : list of (count, axes) arrays, optional
        The positions in the flights of `none`, as returned; None where this is `none`.
    watch : callable, optional
        Called with the batch after the reset and after every decision.
    is_training : bool
        Of the batch, see `rss_gym.core.BaseBatch`.

    Returns
    -------
    table : (count,) array
        A table with the columns of the domain, see `rss_gym.eval.table`.
    positions : list of (count, axes) arrays
        The agents' `positions_m` after each decision, and those that stay once all episodes have ended.

    Raises
    ------
    PolicyError
        When the policy raises or returns actions of the wrong shape or type.
    NotFiniteError
        When a state of the params is not finite.
    """
    batch = start(params, block, is_training)
    episode, count = batch.episode, block.count
    table = np.zeros(count, TABLES[domain_of(params).name])
    sampled = sample_decisions(episode, params)
    done, state = np.zeros(count, bool), None
    positions: list[np.ndarray] = []
    if watch:
        watch(batch)
    while not done.all():
        step = len(positions)
        take = ~done & (sampled == step)
        if take.any():
            for column, values in zip(("sample_separation_m", "sample_range_m"), batch.sample(), strict=True):
                table[column][take] = values[take]
        try:
            actions, state = command(policy, name, batch.observations, state, np.full(count, step == 0))
            decoded, bad = checked(actions, name, params, count)
        except PolicyError as error:
            raise PolicyError(f"{error}; at decision {step} of {block}; nothing was scored") from error.__cause__
        table["fault"] |= bad & ~done
        batch.step(decoded, ~done)
        here = batch.positions_m
        if nominal is not None:
            # Where `none` ended in a collision its position is held; only encounters it survives are ever judged.
            apart_m = np.linalg.norm(here - nominal[min(step, len(nominal) - 1)], axis=1)
            np.fmax(table["manoeuvre_m"], np.where(done, 0.0, apart_m), out=table["manoeuvre_m"])
        positions.append(here)
        if watch:
            watch(batch)
        done = episode["terminated"] | episode["truncated"]
    batch.step(decoded, ~done)  # nobody moves any more
    positions.append(batch.positions_m)
    for column in table.dtype.names or ():
        if column not in MEASURED:
            table[column] = episode[column]
    table["episode"], table["missed_ticks"] = block.numbers, episode["missed"]
    table["duration_s"] = episode["ticks"] * params.clock.tick_s
    table["flown_s"] = episode["tick"] * params.clock.tick_s
    table["deviation_end_m"] = episode["deviation_m"]
    table["planned_m"] = batch.planned_mps * table["flown_s"]
    return table, positions


def fly_all(policy: Any, name: str, params: Params, episodes: Block, is_training: bool = False) -> np.ndarray:
    """The table of any number of episodes, flown `BLOCK` at a time without the flights of `none`."""
    parts = [episodes.episodes[first : first + BLOCK] for first in range(0, episodes.count, BLOCK)]
    blocks = [Block(episodes.split, episodes.seed, part) for part in parts]
    return np.concatenate([fly_episodes(policy, name, params, block, is_training=is_training)[0] for block in blocks])
