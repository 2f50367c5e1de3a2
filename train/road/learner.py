"""Trains one seed on a road, validates it on the way, and keeps the best."""

from __future__ import annotations

import csv
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import configure
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor

from rss_gym.baselines.road import World
from rss_gym.eval.episodes import Block
from rss_gym.eval.road.drives import drive
from rss_gym.files import replaced_folder
from rss_gym.train import actor
from rss_gym.train.loop import SEED_STRIDE
from rss_gym.train.road.export import agent, export
from rss_gym.train.road.imitation import imitate
from rss_gym.train.road.recipe import RoadRecipe
from rss_gym.train.run_record import BEST
from rss_gym.train.sb3_arguments import arguments, network

VALIDATION = "validation.csv"


@dataclass(frozen=True)
class Score:
    """What a validation found: means over its episodes."""

    steps: int
    episodes: int
    collision_rate: float
    snmac_rate: float
    deviation_m: float
    cost_m: float  # by which the best is chosen

    def __str__(self) -> str:
        return (
            f"collides in {self.collision_rate:.3f} of {self.episodes}, {self.deviation_m:.1f} m from plan, "
            f"cost {self.cost_m:.1f} m"
        )


def train_seed(recipe: RoadRecipe, folder: Path, index: int, record: dict[str, Any]) -> Score:
    """Train seed number `index` of a recipe; its best driver is then in `folder`/best.

    Parameters
    ----------
    recipe : RoadRecipe
    folder : path
        Made; `progress.csv`, `validation.csv` and `best` go there.
    index : int
        The seed is `index` * 2**20.
    record : dict
        Of the run, for the driver's file.

    Returns
    -------
    Score
        Of the best.
    """
    torch.set_num_threads(1)
    folder.mkdir(parents=True)
    seed, began = index * SEED_STRIDE, perf_counter()
    venv = VecMonitor(DummyVecEnv([recipe.environment] * recipe.head.n_envs))
    table = recipe.hyperparameters
    model = PPO("MlpPolicy", venv, policy_kwargs=network(recipe.policy), seed=seed, device="cpu", **arguments(table))
    model.set_logger(configure(str(folder), ["csv"]))
    if recipe.imitation.episodes:
        print(f"seed {index}: {imitate(model, recipe, seed)}", flush=True)
    keeper = _Keeper(recipe, folder, {**record, "seed": seed})
    model.learn(recipe.head.steps, callback=keeper)
    model.logger.close()
    venv.close()
    assert keeper.best is not None
    spent_s = perf_counter() - began
    print(f"seed {index}: {model.num_timesteps:,} decisions in {spent_s:.0f} s; best: {keeper.best}", flush=True)
    return keeper.best


class _Keeper(BaseCallback):
    """Drives the policy on split `validation` every so many steps and at the end, and keeps the best."""

    def __init__(self, recipe: RoadRecipe, folder: Path, record: dict[str, Any]) -> None:
        super().__init__()
        self.recipe, self.folder, self.record = recipe, folder, record
        self.env = recipe.environment(reward=None)  # the prices of the scores, whatever those of the training
        self.env.reset(seed=0)
        self.world = World.of(self.env)
        self.best: Score | None = None
        self._seen = 0
        self._last: np.ndarray | None = None  # observations of the last rollout
        self._rows: list[Score] = []

    def _on_step(self) -> bool:
        return True

    def _on_rollout_start(self) -> None:
        table, every = self.recipe.imitation, self.recipe.validation.every_steps
        if self.num_timesteps // every > self._seen // every or (self.num_timesteps == 0 and table.episodes):
            self._validate()
        if table.episodes:
            actor.hold(self.model.policy, self.num_timesteps < table.critic_steps)
        self._seen = self.num_timesteps

    def _on_rollout_end(self) -> None:
        self._last = self.model.rollout_buffer.observations.copy()  # type: ignore[attr-defined]

    def _on_training_end(self) -> None:
        self._validate()

    def _validate(self) -> None:
        radio, episodes = self.recipe.radio, self.recipe.validation.episodes
        score = validate(agent(self.model, self.world, radio), self.env, episodes, self.num_timesteps)
        self._rows.append(score)
        with open(self.folder / VALIDATION, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(asdict(score)))
            writer.writeheader()
            writer.writerows(asdict(row) for row in self._rows)
        print(f"  {self.num_timesteps:,} steps: {score}", flush=True)
        if self.best is None or score.cost_m < self.best.cost_m:
            self.best = score
            rows: Any = self.model._last_obs if self._last is None else self._last
            seen = np.asarray(rows).reshape(-1, rows.shape[-1])
            with replaced_folder(self.folder / BEST) as new:
                export(self.model, self.world, radio, seen, new, {**self.record, "validation": asdict(score)})


def validate(driver: Any, env: Any, episodes: int, steps: int) -> Score:
    """Drive `episodes` of split `validation`, seed 0."""
    rows = np.concatenate([row for row, _, _ in drive(driver, "agent", env, Block("validation", 0, range(episodes)))])
    means = (float(np.mean(rows[name])) for name in ("collision", "snmac", "deviation_mean_m", "cost_m"))
    return Score(steps, episodes, *means)
