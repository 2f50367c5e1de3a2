"""Flights that the checks share."""

from __future__ import annotations

from typing import Any

import numpy as np

from rss_gym.domain import domain_of
from rss_gym.params import Params


def fresh(params: Params, count: int, first: int = 0) -> Any:
    """A batch at the start of the episodes of the seeds `first`, `first` + 1, ..., in the air or on a road."""
    batch = domain_of(params).make_batch(params, count)
    batch.seed(np.arange(first, first + count, dtype=np.uint64))
    batch.reset(np.ones(count, bool))
    return batch


def ended(batch: Any) -> np.ndarray:
    """Rows whose episode is over, shape (n,)."""
    return np.asarray(batch.episode["terminated"] | batch.episode["truncated"])


def step(batch: Any, actions: Any) -> None:
    """Fly one decision in the rows whose episode goes on."""
    batch.step(domain_of(batch.params).decode(actions, batch.params, batch.n), ~ended(batch))


def fly_on(batch: Any, decisions: int = 10_000) -> None:
    """Follow the predefined trajectories to the end, or for so many decisions; nothing may become infinite."""
    still = np.zeros((batch.n, 2 if batch.params.encounter.planar else 3), np.float32)
    for _ in range(decisions):
        if ended(batch).all():
            return
        step(batch, still)
        assert np.isfinite(batch.observations).all(), "an observation is not finite"
        assert np.isfinite(batch.rewards).all(), "a reward is not finite"


def check_rows_alone(params: Params, count: int = 5, decisions: int = 60) -> None:
    """Each row of a batch equals the same episode flown alone, bit for bit."""
    together = fresh(params, count)
    alone = [fresh(params, 1, first) for first in range(count)]
    for _ in range(decisions):
        for row, single in enumerate(alone):
            assert np.array_equal(together.observations[row], single.observations[0]), (
                f"row {row} of a batch of {count} differs from the same episode alone"
            )
        for batch in (together, *alone):
            fly_on(batch, 1)
