"""The learner of a recipe: the rows, SB3's wrappers round them, its model, and what of them a checkpoint holds."""

from __future__ import annotations

import importlib
import io
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.save_util import load_from_zip_file
from stable_baselines3.common.utils import set_random_seed
from stable_baselines3.common.vec_env import VecEnv, VecFrameStack, VecNormalize

from rss_gym.baselines.agent import Agent
from rss_gym.params import ParamsError
from rss_gym.plain_files import read_json
from rss_gym.train import actor, export
from rss_gym.train.hyperparameters import ALGORITHMS, Sac
from rss_gym.train.masked import Masked
from rss_gym.train.recipe import Recipe
from rss_gym.train.sb3_arguments import arguments, network
from rss_gym.train.training_env import TrainingVecEnv

MODEL, STATE = "model.zip", "state.json"
STATE_BYTES_MAX = 1 << 26
RECENT = 1000  # episodes that the progress is averaged over
# Of a running episode or of this process; each is made anew when a training goes on.
PASSING = (
    "ep_info_buffer",
    "ep_success_buffer",
    "_last_obs",
    "_last_original_obs",
    "_last_episode_starts",
    "_last_lstm_states",
)


@dataclass
class Learner:
    """A model and its environment.

    Attributes
    ----------
    recipe : Recipe
    seed : int
        The seed of the model and of the first row.
    training_env : TrainingVecEnv
        The rows.
    venv : VecEnv
        What the model sees of them.
    model : BaseAlgorithm
    """

    recipe: Recipe
    seed: int
    training_env: TrainingVecEnv
    venv: VecEnv
    model: BaseAlgorithm

    @classmethod
    def new(cls, recipe: Recipe, seed: int) -> Learner:
        """Before its first step."""
        vec, kind = recipe.vec, ALGORITHMS[recipe.algorithm]
        training_env = TrainingVecEnv(recipe.params_of(recipe.stage(0)), vec.n_envs, seed)
        venv: VecEnv = VecFrameStack(training_env, vec.stack) if vec.stack > 1 else training_env
        if recipe.policy.zeroed != "nothing":
            venv = Masked(venv, recipe.policy.zeroed, recipe.params)
        if vec.normalise_reward or vec.normalise_observation:
            venv = VecNormalize(
                venv,
                norm_obs=vec.normalise_observation,
                norm_reward=vec.normalise_reward,
                clip_obs=vec.clip_observation,
                clip_reward=vec.clip_reward,
                gamma=getattr(recipe.hyperparameters, "gamma", 1.0),  # `pathwise` has no discount
            )
        model = getattr(importlib.import_module(kind.module), kind.name)(
            kind.policy_name,
            venv,
            policy_kwargs=network(recipe.policy),
            seed=seed,
            device="cpu",
            stats_window_size=RECENT,
            **arguments(recipe.hyperparameters),
        )
        return cls(recipe, seed, training_env, venv, model)

    @classmethod
    def saved(cls, recipe: Recipe, seed: int, folder: Path) -> Learner:
        """As `save` left it, with new episodes in all rows and an empty replay buffer. Runs no code of the file."""
        learner = cls.new(recipe, seed)
        try:
            state = read_json(folder / STATE, STATE_BYTES_MAX)
            _, weights, variables = load_from_zip_file(folder / MODEL, device="cpu", load_data=False)
            model: Any = learner.model
            model.set_parameters(weights, device="cpu")
            for name, tensor in (variables or {}).items():
                getattr(model, name).data = tensor.data
            model.num_timesteps, model._n_updates = state["steps"], state["updates"]
            if recipe.stage(model.num_timesteps) != recipe.stage(0):
                learner.training_env.move(recipe.params_of(recipe.stage(model.num_timesteps)))
            learner.training_env.begin(np.array(state["episodes"], np.uint64))
            for name, table in state["statistics"].items():
                statistics = getattr(learner.venv, name)
                statistics.mean, statistics.var = np.array(table["mean"]), np.array(table["variance"])
                statistics.count = table["count"]
        except Exception as error:  # of whatever kind a damaged file makes PyTorch raise
            said = " ".join(f"{type(error).__name__}: {error}".split())[:300]
            raise ParamsError(
                f"checkpoint {str(folder)!r} cannot be read ({said}); put it aside, and the seed begins anew"
            ) from error
        if isinstance(recipe.hyperparameters, Sac):
            model.gradient_steps = 0  # until `look_at_buffer` finds enough in it
        # Other draws than those before the end by force, which the same seed would repeat.
        set_random_seed((seed + model.num_timesteps) % 2**32)
        return learner

    def save(self, folder: Path) -> None:
        """Write the checkpoint into `folder`: SB3's file, and the rest as numbers."""
        self.save_model(folder / MODEL)
        statistics = {
            name: {"mean": values.mean.tolist(), "variance": values.var.tolist(), "count": float(values.count)}
            for name, values in self._statistics().items()
        }
        state = {
            "steps": self.model.num_timesteps,
            "updates": self.model._n_updates,
            "episodes": self.training_env.numbers.tolist(),
            "statistics": statistics,
        }
        (folder / STATE).write_text(json.dumps(state, allow_nan=False) + "\n", encoding="utf-8")

    def save_model(self, path: Path) -> None:
        """Write SB3's file, for `rss-gym export` and for SB3's own `load`."""
        content = io.BytesIO()
        self.model.save(content, exclude=PASSING)
        path.write_bytes(content.getvalue())

    def _statistics(self) -> dict[str, Any]:
        """What `VecNormalize` has learnt."""
        if not isinstance(self.venv, VecNormalize):
            return {}
        return {"ret_rms": self.venv.ret_rms} | ({"obs_rms": self.venv.obs_rms} if self.venv.norm_obs else {})

    @property
    def normalisation(self) -> export.Normalisation | None:
        """Of observations, as it is now."""
        return export.Normalisation.of(self.venv) if isinstance(self.venv, VecNormalize) else None

    @property
    def _inputs(self) -> export.Inputs:
        """What stands between the rows and the model, with the normalisation as it is now."""
        return export.Inputs(self.normalisation, self.recipe.vec.stack, self.recipe.policy.zeroed)

    def agent(self) -> Agent:
        """The policy as it is now."""
        return export.agent(self.model, self.recipe.params, self._inputs)

    def export(self, out: Path, training: dict[str, Any]) -> float:
        """Write it as a policy folder; see `rss_gym.train.export.export`."""
        return export.export(self.model, self.recipe.params, out, self._inputs, training)

    def hold_actor(self) -> None:
        """Let the actor that has imitated a rule stay as it is until the critic can judge it."""
        table = self.recipe.imitation
        if table.episodes:
            actor.hold(self.model.policy, self.model.num_timesteps < table.critic_steps)

    def look_at_buffer(self) -> None:
        """Let a model whose replay buffer was empty learn on once it holds `learning_starts` decisions of its own."""
        table, model = self.recipe.hyperparameters, cast(Any, self.model)
        if isinstance(table, Sac) and model.replay_buffer.size() * self.venv.num_envs >= table.learning_starts:
            model.gradient_steps = table.gradient_steps

    def move(self, stage: int) -> None:
        """Go on in the world of a stage of the curriculum, with new episodes in all rows."""
        self.training_env.move(self.recipe.params_of(stage))
        self.restart()

    def restart(self) -> None:
        """Let a model that is learning go on with new episodes in all rows."""
        model = cast(Any, self.model)
        model._last_obs = self.venv.reset()
        model._last_episode_starts = np.ones(self.venv.num_envs, bool)
        if isinstance(self.venv, VecNormalize):
            model._last_original_obs = self.venv.get_original_obs()
