"""Flights of a policy with everything that their gradient needs, and that gradient.

Notation: x_n is the agent's state before step n, a_n the action, K_n = da_n/dx_n through the observation, J the cost.

    dJ/da_n = dc_n/da_n + B_n^T l_(n+1),        l_n = dc_n/dx_n + A_n^T l_(n+1) + K_n^T dJ/da_n

with A_n and B_n the derivatives of x_(n+1) by x_n and a_n, and c_n the part of the cost that step n makes: deviation
over the length of the flight, and the smooth prices of the least margins that are reached in this step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from stable_baselines3.common.policies import BasePolicy

from rss_gym.core import Batch
from rss_gym.sensitivity import EVENTS, StepRecorder, StepSensitivity, observation_sensitivity
from rss_gym.train.pathwise.linearised_actor import LinearisedActor
from rss_gym.train.pathwise.price import SmoothPrice


@dataclass(frozen=True)
class Decision:
    """One decision of the rows that were still flying.

    Attributes
    ----------
    rows : (m,) int array
    observations : (m, d) float32 array
        As the actor saw them.
    actions : (m, A) array
        Mean actions, not clipped.
    feedback : (m, A, S) array
        K: derivative of the clipped action by the agent's state.
    step : StepSensitivity
        The derivatives of the step, for these rows.
    std_m : (m,) array
        Standard deviation of the tracked position on an axis, of the least certain track.
    """

    rows: np.ndarray
    observations: np.ndarray
    actions: np.ndarray
    feedback: np.ndarray
    step: StepSensitivity
    std_m: np.ndarray


@dataclass(frozen=True)
class Margins:
    """The least margins of n flights, by `EVENTS`.

    Attributes
    ----------
    least_m : (n, 3) array
    decision : (n, 3) int array
        Number of the decision in whose step it is reached.
    std_m : (n, 3) array
        Standard deviation of the track at that decision.
    """

    least_m: np.ndarray
    decision: np.ndarray
    std_m: np.ndarray


def fly(batch: Batch, policy: BasePolicy, kept: np.ndarray) -> list[Decision]:
    """Fly the episode that every row has just begun to its end, by mean actions, and through collisions.

    A flight that a collision ended would not show how deep it went, and its least margin would hang on the tick.

    Parameters
    ----------
    batch : Batch
    policy : ActorCriticPolicy
    kept : (d,) float32 array
        One for the fields that the actor sees, zero for the others.
    """
    batch.state.config["collision_m"] = 0.0
    try:
        return _flown(batch, policy, kept)
    finally:
        batch.state.config["collision_m"] = batch.params.zone.collision_m


def _flown(batch: Batch, policy: BasePolicy, kept: np.ndarray) -> list[Decision]:
    everything, axes = np.ones(batch.n, bool), 2 if batch.params.encounter.planar else 3
    recorder, flying, decisions = StepRecorder(batch), everything.copy(), list[Decision]()
    actor = LinearisedActor(policy)
    while flying.any():
        rows = np.flatnonzero(flying)
        seen = batch.observations[rows] * kept
        means, jacobian = actor(seen)
        slopes = observation_sensitivity(batch, rows) * kept
        feedback = (jacobian @ slopes.transpose(0, 2, 1)).astype(np.float64)
        wanted = means.astype(np.float64)
        feedback[np.abs(wanted) > 1.0] = 0.0
        actions = np.zeros((batch.n, 3))
        actions[rows, :axes] = np.clip(wanted, -1.0, 1.0)
        recorder.remember()
        std_m = _std_m(batch, rows)
        batch.step(actions, flying)
        decisions.append(Decision(rows, seen, wanted, feedback, recorder.differentiate(actions, rows), std_m))
        flying &= ~(batch.episode["terminated"] | batch.episode["truncated"])
    return decisions


def _std_m(batch: Batch, rows: np.ndarray) -> np.ndarray:
    tracks = batch.state.tracks[rows]
    variance = np.where(tracks["valid"], (tracks["xx"] + tracks["yy"]) / 2.0, 0.0)
    return np.sqrt(variance.max(axis=1))


def gradient(
    batch: Batch, decisions: list[Decision], margins: Margins, price: SmoothPrice, limit_m: float, weights: np.ndarray
) -> tuple[torch.Tensor, torch.Tensor]:
    """Observations (N, d) of all decisions and dJ/da (N, A), m, of the flights that `fly` has returned.

    `limit_m` bounds the length of each decision's gradient, and ten times as much that of l; `weights` (n,) are those
    of the flights.
    """
    size = decisions[0].step.state.shape[1]
    slope, length = price.slope(margins.least_m, margins.std_m), batch.episode["ticks"].astype(np.float64)
    forward = np.zeros((batch.n, size))  # l of the next step
    observations, gradients = [], []
    for number in range(len(decisions) - 1, -1, -1):
        now = decisions[number]
        rows, step = now.rows, now.step
        weight = batch.params.reward.deviation_price / length[rows, None]
        near = np.where(margins.decision[rows] == number, slope[rows], 0.0)
        total = weight * step.deviation_slope + np.einsum("ne,nie->ni", near, step.least_slope)
        total += np.einsum("nij,nj->ni", step.state_slope, forward[rows])
        by_action = bounded(total[:, size:], limit_m)
        beyond = np.abs(now.actions) > 1.0  # only a way back changes anything
        by_action[beyond & (np.sign(now.actions) == -np.sign(by_action))] = 0.0
        back = total[:, :size] + np.einsum("nas,na->ns", now.feedback, total[:, size:])
        forward[rows] = bounded(back, 10.0 * limit_m)
        observations.append(now.observations)
        gradients.append((by_action * weights[rows, None]).astype(np.float32))
    return torch.from_numpy(np.concatenate(observations)), torch.from_numpy(np.concatenate(gradients))


def least_margins(n: int, decisions: list[Decision]) -> Margins:
    """Those of n flights."""
    shape = n, len(EVENTS)
    found = Margins(np.full(shape, np.inf), np.zeros(shape, np.int64), np.zeros(shape))
    for number, decision in enumerate(decisions):
        rows, least_m = decision.rows, decision.step.least_m
        less = least_m < found.least_m[rows]
        found.decision[rows] = np.where(less, number, found.decision[rows])
        found.std_m[rows] = np.where(less, decision.std_m[:, None], found.std_m[rows])
        found.least_m[rows] = np.where(less, least_m, found.least_m[rows])
    return found


def bounded(vectors: np.ndarray, limit: float) -> np.ndarray:
    """Vectors (n, k), the longer ones shortened to `limit`."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors * np.minimum(1.0, limit / np.maximum(lengths, 1e-12))
