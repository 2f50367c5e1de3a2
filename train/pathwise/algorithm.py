"""The learner in the shape of Stable-Baselines3: policy, callbacks, files and `learn` are those of its algorithms."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy
from stable_baselines3.common.utils import safe_mean
from stable_baselines3.common.vec_env import VecEnvWrapper, VecFrameStack, VecNormalize

from rss_gym.baselines.masks import kept
from rss_gym.core import Batch
from rss_gym.params import ParamsError
from rss_gym.sb3 import EncounterVecEnv
from rss_gym.train import actor
from rss_gym.train.masked import Masked
from rss_gym.train.pathwise.flights import fly, gradient, least_margins
from rss_gym.train.pathwise.near_misses import NearMisses
from rss_gym.train.pathwise.price import SmoothPrice

CHUNK = 1 << 16  # observations that the network is differentiated on at a time


class Pathwise(BaseAlgorithm):
    """Adam on pathwise gradients; each update flies one episode in every row. Only the actor of the policy learns.

    Parameters
    ----------
    policy : str or type
        "MlpPolicy".
    env : VecEnv
        Rows of `rss_gym.sb3.EncounterVecEnv`, perhaps with some fields zeroed, nothing else round them that changes
        observations.
    learning_rate : float or schedule
    softness_m : float
        The standard deviation of the smooth price, see `SmoothPrice`.
    softness_sigmas : float
        What is added to it in quadrature, in standard deviations of the track.
    gradient_limit_m : float
        Greatest gradient of the cost by one decision's action.
    manoeuvre_price_m : float
        The price of a flight that leaves its path, so that it does so only where it pays.
    near_share, near_m : float
        Share of the rows that fly near misses again, and the separation of these; see `NearMisses`.
    policy_kwargs, stats_window_size, tensorboard_log, verbose, device, seed
        As in Stable-Baselines3.

    Raises
    ------
    ParamsError
        For rows of another kind.
    """

    policy_aliases: ClassVar[dict[str, type[BasePolicy]]] = {"MlpPolicy": ActorCriticPolicy}

    def __init__(
        self,
        policy: str | type[ActorCriticPolicy],
        env: Any,
        learning_rate: Any = 3e-3,
        softness_m: float = 3.5,
        softness_sigmas: float = 0.0,
        gradient_limit_m: float = 20.0,
        manoeuvre_price_m: float = 0.0,
        near_share: float = 0.0,
        near_m: float = 20.0,
        policy_kwargs: dict[str, Any] | None = None,
        stats_window_size: int = 100,
        tensorboard_log: str | None = None,
        verbose: int = 0,
        device: str = "cpu",
        seed: int | None = None,
        _init_setup_model: bool = True,
    ) -> None:
        super().__init__(
            policy,
            env,
            learning_rate,
            policy_kwargs=policy_kwargs,
            stats_window_size=stats_window_size,
            tensorboard_log=tensorboard_log,
            verbose=verbose,
            device=device,
            support_multi_env=True,
            seed=seed,
        )
        self.softness_sigmas = softness_sigmas
        self.softness_m, self.gradient_limit_m, self.manoeuvre_price_m = softness_m, gradient_limit_m, manoeuvre_price_m
        self.near_misses = NearMisses(near_share, near_m)
        if _init_setup_model:
            self._setup_model()

    def _setup_model(self) -> None:
        self._setup_lr_schedule()
        self.set_random_seed(self.seed)
        self.policy = self.policy_class(
            self.observation_space, self.action_space, self.lr_schedule, **self.policy_kwargs
        ).to(self.device)

    def _get_torch_save_params(self) -> tuple[list[str], list[str]]:
        return ["policy", "policy.optimizer"], []

    def learn(
        self,
        total_timesteps: int,
        callback: Any = None,
        log_interval: int | None = 1,
        tb_log_name: str = "Pathwise",
        reset_num_timesteps: bool = True,
        progress_bar: bool = False,
    ) -> Pathwise:
        """As in Stable-Baselines3; a step is a decision of one row."""
        until, callback = self._setup_learn(total_timesteps, callback, reset_num_timesteps, tb_log_name, progress_bar)
        callback.on_training_start(locals(), globals())
        while self.num_timesteps < until:
            callback.on_rollout_start()
            batch, fields = self._rows()
            self.near_misses.reset(batch, np.random.default_rng((self.seed or 0, self._n_updates)))
            decisions = fly(batch, self.policy, fields)
            self.num_timesteps += sum(len(decision.rows) for decision in decisions)
            price = SmoothPrice.of(batch.params, self.softness_m, self.manoeuvre_price_m, self.softness_sigmas)
            margins = least_margins(batch.n, decisions)
            least_m = margins.least_m[:, 1]  # of a collision
            weights = self.near_misses.weigh(batch, least_m)
            self._record(batch, least_m < batch.params.zone.collision_m)
            callback.update_locals(locals())
            if not callback.on_step():
                break
            callback.on_rollout_end()
            self._update_current_progress_remaining(self.num_timesteps, until)
            self._update_learning_rate(self.policy.optimizer)
            self._update(batch.n, *gradient(batch, decisions, margins, price, self.gradient_limit_m, weights))
            if log_interval is not None and self._n_updates % log_interval == 0:
                self.dump_logs()
        callback.on_training_end()
        return self

    def dump_logs(self, iteration: int = 0) -> None:
        """Write what has been recorded since the last call, as Stable-Baselines3's own learners do."""
        recent = self.ep_info_buffer or ()
        if recent:
            self.logger.record("rollout/ep_rew_mean", safe_mean([episode["r"] for episode in recent]))
            self.logger.record("rollout/ep_len_mean", safe_mean([episode["l"] for episode in recent]))
        self.logger.record("time/total_timesteps", self.num_timesteps, exclude="tensorboard")
        self.logger.dump(step=self.num_timesteps)

    def _rows(self) -> tuple[Batch, np.ndarray]:
        """The batch under the wrappers, and one for each field that the policy sees, zero for the others."""
        venv: Any = self.env
        fields: np.ndarray | None = None
        while not isinstance(venv, EncounterVecEnv):
            if isinstance(venv, Masked):
                fields = venv.kept
            is_other = isinstance(venv, VecFrameStack) or (isinstance(venv, VecNormalize) and venv.norm_obs)
            if is_other or not isinstance(venv, VecEnvWrapper):
                raise ParamsError(
                    "pathwise learns on the rows of rss_gym.sb3.make_vec_env as they are: without VecFrameStack and "
                    "without VecNormalize of the observations"
                )
            venv = venv.venv
        batch = venv.batch
        assert isinstance(batch, Batch)
        return batch, kept("nothing", batch.params) if fields is None else fields

    def _record(self, batch: Batch, collided: np.ndarray) -> None:
        """The episodes that have ended, as a monitor tells of them; `collided` (n,) did not end them."""
        assert self.ep_info_buffer is not None
        for e, collision in zip(batch.episode, collided, strict=True):
            self.ep_info_buffer.append(
                {
                    "r": -float(e["cost_m"] + collision * batch.params.reward.collision_price_m),
                    "l": int(e["tick"]) // batch.params.clock.ticks_per_decision,
                    "t": 0.0,
                    "collision": bool(collision),
                    "deviation_m": float(e["deviation_mean_m"]),
                }
            )

    def _update(self, flights: int, observations: torch.Tensor, gradients: torch.Tensor) -> None:
        """One step of Adam along the mean gradient of the cost of a flight."""
        optimizer = self.policy.optimizer
        optimizer.zero_grad()
        for seen, wanted in zip(observations.split(CHUNK), gradients.split(CHUNK), strict=True):
            (torch.sum(actor.outputs(self.policy, seen) * wanted) / flights).backward()
        optimizer.step()
        self._n_updates += 1
