"""Flies a policy over numbered episodes and fills the episode table."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rss_gym.core import SPLITS, Batch, NotFiniteError, decode
from rss_gym.eval.table import TABLE
from rss_gym.params import Params
from rss_gym.physics.random import uniform
from rss_gym.streams import STREAM_SAMPLE

COLUMNS_OF_EPISODE = (
    "family channel approach_s collision snmac zone zone_severity min_separation_m closest_s deviation_mean_m "
    "deviation_max_m flown_m cost_m warned_s false_alerts"
).split()


class PolicyError(RuntimeError):
    """A policy raised, or returned something that is not a batch of actions."""


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


def start(params: Params, block: Block) -> Batch:
    """A batch on the first decision of the block's episodes."""
    batch, everything = Batch(params, block.count), np.ones(block.count, bool)
    batch.seed(np.full(block.count, block.seed, np.uint64))
    batch.split[:], batch.numbers[:] = SPLITS[block.split], block.numbers
    batch.reset(everything)
    return batch


def command(policy: Any, name: str, observations: np.ndarray, state: Any, first: np.ndarray) -> tuple[Any, Any]:
    """Ask the policy; its argument is a copy, so it cannot change what is scored."""
    try:
        answer = policy.predict(observations.copy(), state=state, episode_start=first, deterministic=True)
    except NotFiniteError:  # of a world that the policy looks ahead in: no fault of its own
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
    """Decoded actions (n, 3), and the rows whose action is not finite, which fly on with zero."""
    bad = np.zeros(count, bool)
    try:
        values = np.array(actions)
        if values.dtype.kind == "f" and values.ndim == 2 and len(values) == count:
            bad = ~np.isfinite(values).all(axis=1)
            values[bad] = 0.0
        return decode(values, params, count), bad
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
    watch: Callable[[Batch], None] | None = None,
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Fly every episode of the block to its end.

    Parameters
    ----------
    policy : Policy
        Anything with SB3's `predict`.
    name : str
        For error sentences.
    params : Params
        The policy's world.
    block : Block
        Which episodes.
    nominal : list of (count, 3) arrays, optional
        The agent's positions in the flights of `none`, one array a decision; None where this is `none`.
    watch : callable, optional
        Called with the batch after the reset and after every decision.

    Returns
    -------
    table : (count,) array of TABLE
    positions : list of (count, 3) arrays
        The agent's positions after each decision, held once an episode has ended.

    Raises
    ------
    PolicyError
        When the policy raises or returns actions of the wrong shape or type.
    NotFiniteError
        When a state of the world is not finite.
    """
    batch = start(params, block)
    episode, count = batch.episode, block.count
    table = np.zeros(count, TABLE)
    sampled = sample_decisions(episode, params)
    done, state = np.zeros(count, bool), None
    positions: list[np.ndarray] = []
    if watch:
        watch(batch)
    while not done.all():
        step = len(positions)
        take = ~done & (sampled == step)
        aircraft = batch.state.aircraft["position_m"]
        table["sample_separation_m"][take] = np.linalg.norm(aircraft[take, 1] - aircraft[take, 0], axis=1)
        table["sample_range_m"][take] = batch.state.links["range_m"][take, 0]
        try:
            actions, state = command(policy, name, batch.observations, state, np.full(count, step == 0))
            decoded, bad = checked(actions, name, params, count)
        except PolicyError as error:
            raise PolicyError(f"{error}; at decision {step} of {block}; nothing was scored") from error.__cause__
        table["fault"] |= bad & ~done
        batch.step(decoded, ~done)
        here = batch.state.aircraft["position_m"][:, 0].copy()
        if nominal is not None:
            # Where `none` ended in a collision its position is held; only encounters it survives are ever judged.
            apart = np.linalg.norm(here - nominal[min(step, len(nominal) - 1)], axis=1)
            np.maximum(table["manoeuvre_m"], np.where(done, 0.0, apart), out=table["manoeuvre_m"])
        positions.append(here)
        if watch:
            watch(batch)
        done = episode["terminated"] | episode["truncated"]
    for column in COLUMNS_OF_EPISODE:
        table[column] = episode[column]
    table["episode"], table["missed_ticks"] = block.numbers, episode["missed"]
    table["duration_s"] = episode["ticks"] * params.clock.tick_s
    table["flown_s"] = episode["tick"] * params.clock.tick_s
    table["deviation_end_m"] = episode["deviation_m"]
    speed = np.linalg.norm(batch.state.aircraft["planned_mps"][:, 0], axis=1)
    table["planned_m"] = speed * table["flown_s"]
    return table, positions
