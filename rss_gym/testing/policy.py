"""What every policy must keep."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Discrete

from rss_gym.domain import domain_of
from rss_gym.params import Params
from rss_gym.testing.flights import ended, fresh, step

COUNT = 5


def check_policy(policy: Any, params: Params, decisions: int = 60) -> None:
    """Actions that the world takes, the same in every batch; memory that starts afresh; arguments left alone.

    Parameters
    ----------
    policy : object
        With SB3's `predict`, made for this world.
    params : Params
        The world.
    decisions : int
        How long it is flown.
    """
    batch, lone = fresh(params, COUNT), fresh(params, COUNT)
    space = domain_of(params).spaces(params)[1]
    state = state_alone = None
    for number in range(decisions):
        first = np.full(COUNT, number == 0)
        actions, state = policy.predict(batch.observations, state, first)
        _check_actions(actions, space)
        alone, state_alone = policy.predict(lone.observations[3], state_alone, first[:1])
        assert np.array_equal(alone, actions[3]), "the action of a row depends on the other rows of the batch"
        for one in (batch, lone):
            step(one, actions)
        if ended(batch).all():
            break
    _check_memory(policy, batch.observations, state)


def _check_actions(actions: Any, space: Any) -> None:
    shape = (COUNT, *space.shape)
    assert actions.shape == shape, f"actions of {COUNT} rows must have the shape {shape}"
    if isinstance(space, Discrete):
        assert all(space.contains(action) for action in actions), f"an action is not in {space}"
        return
    assert actions.dtype == np.float32, f"actions must be float32, got {actions.dtype}"
    assert np.isfinite(actions).all(), "an action is not finite"
    assert (np.abs(actions) <= 1.0).all(), "an action is outside [-1, 1]"


def _check_memory(policy: Any, observations: np.ndarray, state: Any) -> None:
    before = observations.copy(), np.copy(state) if isinstance(state, np.ndarray) else None
    fresh_actions, _ = policy.predict(observations)
    starts = np.arange(len(observations)) % 2 == 0
    mixed, _ = policy.predict(observations, state, starts)
    assert np.array_equal(mixed[starts], fresh_actions[starts]), "memory is not cleared where an episode starts"
    assert np.array_equal(observations, before[0]), "`predict` changes the observations it is handed"
    assert before[1] is None or np.array_equal(state, before[1]), "`predict` changes the state it is handed"
