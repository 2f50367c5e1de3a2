"""A warm start: the actor learns a scripted rule's actions before its own training begins."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.vec_env import VecNormalize

from rss_gym.baselines.policy_files import outputs
from rss_gym.train import actor
from rss_gym.train.learner import Learner

CORRELATION = 0.9  # of the disturbance from decision to decision


def _silent(_: str) -> None:
    """Show nothing."""


def imitate(learner: Learner, show: Callable[[str], object] = _silent) -> str:
    """Fit the actor to the recipe's rule, which flies the learner's own rows.

    `VecNormalize` learns from these flights as from any others; the training's episodes are those that come next.

    Returns
    -------
    str
        What was flown, and the error of the fit on the rule's actions.
    """
    start = perf_counter()
    table = learner.recipe.imitation
    inputs, actions, episodes = _flown(learner, show)
    error = _fit(learner, torch.as_tensor(inputs), torch.as_tensor(actions), show)
    found = f"{1.0 - error:.1%} alike"
    if actions.ndim > 1:
        found = f"rms error {error:.4f} of actions with a standard deviation of {actions.std(axis=0).mean():.4f}"
    return (
        f"imitated {table.policy} in {len(inputs):,} decisions of {episodes:,} encounters for "
        f"{perf_counter() - start:.0f} s: {found}"
    )


def _flown(learner: Learner, show: Callable[[str], object] = _silent) -> tuple[np.ndarray, np.ndarray, int]:
    """What the actor sees and the rule does, float32, and how many encounters ended."""
    table, teacher = learner.recipe.imitation, learner.recipe.teacher
    venv, batch = learner.venv, learner.training_env.venv.batch
    normalised = venv if isinstance(venv, VecNormalize) else None
    count, discrete = outputs(batch.params)
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
        if discrete:
            replaced = generator.random(len(wanted)) < table.disturbance
            done = np.where(replaced, generator.integers(count, size=len(wanted)), wanted)
        else:
            held = CORRELATION * disturbance * ~first[:, None]
            disturbance = held + fresh * generator.standard_normal(wanted.shape)
            done = np.clip(wanted + disturbance, -1.0, 1.0).astype(np.float32)
        seen, _, first, _ = venv.step(done)
        episodes += int(first.sum())
        show(f"imitation, {episodes:,} of {table.episodes:,} encounters")
    rows: Any = np.concatenate(inputs)
    if normalised is not None:
        rows = normalised.normalize_obs(rows)
    return rows, np.concatenate(actions), episodes


def _fit(
    learner: Learner, inputs: torch.Tensor, actions: torch.Tensor, show: Callable[[str], object] = _silent
) -> float:
    """Least squares over minibatches, of discrete actions least cross-entropy.

    The rms error of the last epoch, of discrete actions the share that the actor would choose otherwise after it.
    """
    discrete = actions.ndim == 1
    loss_of = torch.nn.functional.cross_entropy if discrete else torch.nn.functional.mse_loss
    table, policy = learner.recipe.imitation, learner.model.policy
    optimizer = torch.optim.Adam(actor.parameters(policy))
    batches = -(-len(inputs) // table.batch_size)
    cycle = torch.optim.lr_scheduler.OneCycleLR(optimizer, table.learning_rate, total_steps=table.epochs * batches)
    total = 0.0
    for epoch in range(table.epochs):
        show(f"imitation, pass {epoch + 1} of {table.epochs}")
        total = 0.0
        for chosen in torch.randperm(len(inputs)).split(table.batch_size):
            loss = loss_of(actor.outputs(policy, inputs[chosen]), actions[chosen])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            cycle.step()
            total += loss.item() * len(chosen)
    if discrete:
        with torch.no_grad():
            return float((actor.outputs(policy, inputs).argmax(dim=1) != actions).float().mean())
    return float((total / len(inputs)) ** 0.5)
