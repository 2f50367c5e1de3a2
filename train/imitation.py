"""A warm start: the actor learns a scripted rule's actions before its own training begins."""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.vec_env import VecNormalize

from rss_gym.train import actor
from rss_gym.train.learner import Learner

CORRELATION = 0.9  # of the disturbance from decision to decision


def imitate(learner: Learner) -> str:
    """Fit the actor's mean to the recipe's rule, which flies the learner's own rows.

    `VecNormalize` learns from these flights as from any others; the training's episodes are those that come next.

    Returns
    -------
    str
        What was flown, and the error of the fit on the rule's actions.
    """
    start = perf_counter()
    table = learner.recipe.imitation
    inputs, actions, episodes = _flown(learner)
    error = _fit(learner, torch.as_tensor(inputs), torch.as_tensor(actions))
    spread = float(actions.std(axis=0).mean())
    return (
        f"imitated {table.policy} in {len(inputs):,} decisions of {episodes:,} encounters for "
        f"{perf_counter() - start:.0f} s: rms error {error:.4f} of actions with a standard deviation of {spread:.4f}"
    )


def _flown(learner: Learner) -> tuple[np.ndarray, np.ndarray, int]:
    """What the actor sees and the rule does, float32, and how many encounters ended."""
    table, teacher = learner.recipe.imitation, learner.recipe.teacher
    venv, batch = learner.venv, learner.training_env.venv.batch
    normalised = venv if isinstance(venv, VecNormalize) else None
    generator = np.random.default_rng(learner.seed)
    inputs: list[np.ndarray] = []
    actions: list[np.ndarray] = []
    fresh = table.disturbance * (1.0 - CORRELATION**2) ** 0.5  # keeps the standard deviation
    seen = venv.reset()
    first, state, episodes = np.ones(venv.num_envs, bool), None, 0
    disturbance = np.zeros((venv.num_envs, 1))
    while episodes < table.episodes:
        wanted, state = teacher.predict(batch.observations, state, first)
        inputs.append(np.array(seen if normalised is None else normalised.get_original_obs()))
        actions.append(wanted)
        held = CORRELATION * disturbance * ~first[:, None]
        disturbance = held + fresh * generator.standard_normal(wanted.shape)
        seen, _, first, _ = venv.step(np.clip(wanted + disturbance, -1.0, 1.0).astype(np.float32))
        episodes += int(first.sum())
    rows: Any = np.concatenate(inputs)
    if normalised is not None:
        rows = normalised.normalize_obs(rows)
    return rows, np.concatenate(actions), episodes


def _fit(learner: Learner, inputs: torch.Tensor, actions: torch.Tensor) -> float:
    """Least squares over minibatches; the rms error of the last epoch."""
    table, policy = learner.recipe.imitation, learner.model.policy
    optimizer = torch.optim.Adam(actor.parameters(policy))
    batches = -(-len(inputs) // table.batch_size)
    cycle = torch.optim.lr_scheduler.OneCycleLR(optimizer, table.learning_rate, total_steps=table.epochs * batches)
    total = 0.0
    for _ in range(table.epochs):
        total = 0.0
        for chosen in torch.randperm(len(inputs)).split(table.batch_size):
            mean = actor.outputs(policy, inputs[chosen])
            loss = torch.nn.functional.mse_loss(mean, actions[chosen])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            cycle.step()
            total += loss.item() * len(chosen)
    return float((total / len(inputs)) ** 0.5)
