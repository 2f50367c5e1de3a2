"""The training of one seed: learn, look at the policy from time to time, keep the best, save what has been reached."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import torch
from stable_baselines3.common import logger
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import KVWriter, Logger, TensorBoardOutputFormat
from stable_baselines3.common.utils import safe_mean
from tqdm import tqdm

from rss_gym.baselines.agent import load
from rss_gym.files import replaced_folder, tidy
from rss_gym.progress import progress_bar
from rss_gym.train.imitation import imitate
from rss_gym.train.learner import RECENT, STATE, Learner
from rss_gym.train.lock import locked
from rss_gym.train.recipe import Recipe
from rss_gym.train.run_record import BEST
from rss_gym.train.table import Table
from rss_gym.train.validation import BestTracker, Validator, keep_start

CHECKPOINT, BEST_MODEL = "checkpoint", "best.zip"
PROGRESS, VALIDATION, TENSORBOARD = "progress.csv", "validation.csv", "tensorboard"
LOCK = "lock"
STEPS = "time/total_timesteps"  # SB3's name
LOGS = 1000  # rows of progress in a whole training, at most
SEED_STRIDE = 2**20


@dataclass
class Times:
    """Wall time of one process, and what of it went where."""

    decisions: int = 0
    total_s: float = 0.0
    environment_s: float = 0.0
    policy_s: float = 0.0
    learner_s: float = 0.0
    validation_s: float = 0.0

    def __str__(self) -> str:
        """Decisions a second, and the shares."""
        if not self.decisions:
            return "nothing was left to train"
        parts = {
            "environment": self.environment_s,
            "policy": self.policy_s,
            "learner": self.learner_s,
            "validation": self.validation_s,
        }
        parts["rest"] = self.total_s - sum(parts.values())
        shares = ", ".join(f"{name} {spent_s / self.total_s:.1%}" for name, spent_s in parts.items())
        trained_s = self.total_s - self.validation_s
        return (
            f"{self.decisions / self.total_s:,.0f} decisions a second of wall time "
            f"({self.decisions / trained_s:,.0f} without validation): {shares}"
        )


def train_seed(
    recipe: Recipe, folder: Path, index: int, record: dict[str, Any], show: bool | None = False, position: int = 0
) -> Times:
    """Train one seed to the recipe's number of steps, from its checkpoint if there is one.

    Parameters
    ----------
    recipe : Recipe
    folder : Path
        Of this seed.
    index : int
        k of the k-th seed, which is k * 2**20.
    record : dict
        What the training record of each exported policy begins with.
    show : bool, optional
        As `rss_gym.progress.progress_bar` takes it.
    position : int
        Its line.
    """
    torch.set_num_threads(1)
    with locked(folder / LOCK):
        tidy(folder, CHECKPOINT, BEST, BEST_MODEL, PROGRESS, VALIDATION)
        checkpoint, seed = folder / CHECKPOINT, index * SEED_STRIDE
        resumed = (checkpoint / STATE).exists()
        learner = Learner.saved(recipe, seed, checkpoint) if resumed else Learner.new(recipe, seed)
        done, imitates = learner.model.num_timesteps, not resumed and recipe.imitation.episodes > 0
        callback = TrainingCallback(learner, folder, f"seed {index}", {**record, "seed": seed}, imitates)
        learner.model.set_logger(Logger(str(folder), _outputs(folder, done)))
        if done >= recipe.steps:
            return callback.times
        with progress_bar(
            show,
            total=recipe.steps,
            initial=done,
            desc=f"seed {index}",
            unit="step",
            unit_scale=True,
            leave=True,
            position=position,
        ) as callback.bar:
            model: Any = learner.model
            model.learn(recipe.steps - done, callback, log_interval=None, reset_num_timesteps=not resumed)
        for output in learner.model.logger.output_formats:
            output.close()
        return callback.times


class TrainingCallback(BaseCallback):
    """What happens between the updates of the learner. All of it sees a model that has learnt from all steps so far.

    Parameters
    ----------
    learner : Learner
    folder : Path
    name : str
        For lines that are printed.
    record : dict
        The record of the training.
    imitates : bool
        Whether the training begins with the imitation of a rule.
    """

    bar: tqdm

    def __init__(
        self, learner: Learner, folder: Path, name: str, record: dict[str, Any], imitates: bool = False
    ) -> None:
        super().__init__()
        self.learner, self.folder, self.name, self.record, self.imitates = learner, folder, name, record, imitates
        recipe, self.first = learner.recipe, learner.model.num_timesteps
        self.validator = Validator(recipe.params, recipe.validation.episodes)
        self.validations = Table(folder / VALIDATION, "steps", self.first)
        self.times, self.best_tracker = Times(), BestTracker()
        rows = self.validations.rows
        self._cpu_s = -float(rows[-1]["cpu_s"]) if rows else 0.0  # process time not spent on this training
        self._learning_since: float | None = None
        self._stage = recipe.stage(self.first)
        # Called with the steps so far when they pass a multiple of so many.
        self._due: list[tuple[int, Callable[[], None]]] = [
            (max(1, recipe.steps // LOGS), self._log),
            (recipe.validation.every_steps, self._validate),
            (recipe.checkpoint.every_steps, self._save),
        ]
        self._seen = self.first

    def _on_training_start(self) -> None:
        if self.first == 0:
            keep_start(self.folder, self.validator.score(self.learner.agent(), "start"))
        if (self.folder / BEST).exists():
            agent = load(self.folder / BEST, self.learner.recipe.params)
            self.best_tracker.best = self.validator.score(agent, "best")
        self._cpu_s += process_time()
        if self.imitates:
            self._say(imitate(self.learner, self._show_imitation))
            self.learner.restart()
            self._save()
        self._began, self.learner.training_env.spent_s = perf_counter(), 0.0
        policy: Any = self.model.policy
        for name in ("forward", "predict", "predict_values"):  # what acts: SAC's, or the others'
            if hasattr(policy, name):
                setattr(policy, name, self._timed(getattr(policy, name)))
        if self.imitates:
            self._validate(competes=self.learner.recipe.imitation.competes)

    def _show_imitation(self, text: str) -> None:
        """What goes on before the first step."""
        self.bar.set_postfix_str(text, refresh=False)
        self.bar.refresh()

    def _timed(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **keywords: Any) -> Any:
            start = perf_counter()
            result = function(*arguments, **keywords)
            self.times.policy_s += perf_counter() - start
            return result

        return call

    def _on_step(self) -> bool:
        # SB3 finishes its last round of rows, past the number of steps.
        self.bar.update(min(self.num_timesteps, self.bar.total) - self.bar.n)
        return True

    def _on_rollout_end(self) -> None:
        self._learning_since = perf_counter()

    def _on_rollout_start(self) -> None:
        self._stop_learning()
        steps = self.model.num_timesteps
        for every, act in self._due:
            if steps // every > self._seen // every:
                act()
        self._seen = steps
        self.learner.look_at_buffer()
        self.learner.hold_actor()
        stage = self.learner.recipe.stage(steps)
        if stage != self._stage:
            self._say(f"stage {stage} of the curriculum")
            self._stage = stage
            self.learner.move(stage)

    def _on_training_end(self) -> None:
        self._stop_learning()
        for _, act in self._due:
            act()
        times = self.times
        times.decisions, times.total_s = self.model.num_timesteps - self.first, perf_counter() - self._began
        times.environment_s = self.learner.training_env.spent_s

    def _stop_learning(self) -> None:
        if self._learning_since is not None:
            self.times.learner_s += perf_counter() - self._learning_since
        self._learning_since = None

    def _log(self) -> None:
        recent: Sequence[dict[str, float]] = self.model.ep_info_buffer or ()
        # At first only collisions have ended, which says nothing of their rate.
        if len(recent) >= min(self.learner.venv.num_envs, RECENT):
            names = {"r": "reward", "collision": "collision_rate", "deviation_m": "deviation_m"}
            means = {name: float(safe_mean([episode[key] for episode in recent])) for key, name in names.items()}
            self.bar.set_postfix({name: f"{mean:.3g}" for name, mean in means.items()}, refresh=False)
            for name in ("collision_rate", "deviation_m"):
                self.logger.record(f"rollout/{name}", means[name])
        self.model.dump_logs()

    def _validate(self, competes: bool = True) -> None:
        start, steps, policy_s = perf_counter(), self.model.num_timesteps, self.times.policy_s
        cpu_s = process_time()
        score = self.validator.score(self.learner.agent(), "agent")
        better = competes and self.best_tracker.takes(score)
        row = {"steps": steps, "cpu_s": round(cpu_s - self._cpu_s, 1), **score.to_dict(), "best": int(better)}
        if better:
            self._keep(row)
        self.validations.add(row)
        for name in ("cost_m", "collision_rate", "path_deviation_mean_m"):
            self.logger.record(f"validation/{name}", row[name])
        self._say(f"{score}{', the best so far' if better else ''}")
        self._cpu_s += process_time() - cpu_s
        self.times.validation_s += perf_counter() - start
        self.times.policy_s = policy_s  # its share is that of the training

    def _keep(self, row: dict[str, Any]) -> None:
        model = self.folder / f".{BEST_MODEL}-new"
        self.learner.save_model(model)
        with replaced_folder(self.folder / BEST) as new:
            self.learner.export(new, {**self.record, "validation": row})
        model.replace(self.folder / BEST_MODEL)

    def _save(self) -> None:
        with replaced_folder(self.folder / CHECKPOINT) as new:
            self.learner.save(new)

    def _say(self, text: str) -> None:
        tqdm.write(f"{self.name}, {self.model.num_timesteps:,} steps: {text}")
        sys.stdout.flush()


class _Progress(KVWriter):
    """SB3's log as a table."""

    def __init__(self, path: Path, until: int) -> None:
        self.table = Table(path, STEPS, until)

    def write(self, key_values: dict[str, Any], key_excluded: dict[str, tuple[str, ...]], step: int = 0) -> None:
        """Add a row."""
        self.table.add(dict(sorted(key_values.items())))

    def close(self) -> None:
        """Nothing is open."""


def _outputs(folder: Path, until: int) -> list[KVWriter]:
    outputs: list[KVWriter] = [_Progress(folder / PROGRESS, until)]
    if has_tensorboard():
        outputs.append(TensorBoardOutputFormat(str(folder / TENSORBOARD)))
    return outputs


def has_tensorboard() -> bool:
    """Whether SB3 can write for it."""
    return logger.SummaryWriter is not None
