"""A warm start: the actor learns what a scripted driver chooses before PPO begins."""

from __future__ import annotations

import contextlib
from time import perf_counter
from typing import Any

import numpy as np
import torch

from rss_gym.baselines import road
from rss_gym.highway import observation
from rss_gym.train import actor
from rss_gym.train.road.recipe import RoadRecipe


def imitate(model: Any, recipe: RoadRecipe, seed: int) -> str:
    """Fit the actor to the driver of `[imitation]`, which sees the vehicles also where the actor does not.

    Returns
    -------
    str
        What was driven, and the share of its decisions that the actor makes alike.
    """
    start = perf_counter()
    rows, chosen = drives(recipe, seed)
    alike = fit(model.policy, torch.as_tensor(rows), torch.as_tensor(chosen), recipe)
    return (
        f"imitated {recipe.imitation.policy} in {len(rows):,} decisions of {recipe.imitation.episodes} episodes for "
        f"{perf_counter() - start:.0f} s: {alike:.1%} alike"
    )


def drives(recipe: RoadRecipe, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """What the actor would see, float32 (n, d), and the driver chooses, (n,); some actions are others, at random."""
    table, generator = recipe.imitation, np.random.default_rng(seed)
    rows, chosen = [], []
    with contextlib.closing(recipe.environment(radio=True)) as env:
        for episode in range(table.episodes):
            seen, _ = env.reset(seed=seed + recipe.head.n_envs, options={"episode": episode})  # no row's own seed
            world = road.World.of(env)
            teacher, state, done = road.make(table.policy, world), None, False
            while not done:
                action, state = teacher.predict(seen, state)
                rows.append(seen)
                chosen.append(int(action))
                if generator.random() < table.disturbance:
                    action = generator.integers(len(world.actions))
                seen, _, terminated, truncated, _ = env.step(int(action))
                done = terminated or truncated
        return np.stack(rows) * kept(recipe, env), np.array(chosen)


def kept(recipe: RoadRecipe, env: Any) -> np.ndarray:
    """One for each field that the actor sees, zero for the others; float32."""
    names = [field.name for field in observation.fields(env.params)]
    return np.array([recipe.radio or not name.startswith("vehicle_") for name in names], np.float32)


def fit(policy: Any, rows: torch.Tensor, chosen: torch.Tensor, recipe: RoadRecipe) -> float:
    """Least cross-entropy over minibatches; the share chosen alike at its end."""
    table = recipe.imitation
    optimizer = torch.optim.Adam(actor.parameters(policy), lr=table.learning_rate)
    for _ in range(table.epochs):
        for part in torch.randperm(len(rows)).split(table.batch_size):
            loss = torch.nn.functional.cross_entropy(actor.outputs(policy, rows[part]), chosen[part])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
    with torch.no_grad():
        return float((actor.outputs(policy, rows).argmax(dim=1) == chosen).float().mean())
