"""The learner, in the form of an algorithm of Stable-Baselines3."""

from __future__ import annotations

from collections.abc import Iterator
from time import perf_counter
from typing import Any

import torch
from stable_baselines3 import PPO
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

from rss_gym.params import Params
from rss_gym.train import actor, export
from rss_gym.train.course import Course
from rss_gym.train.pathwise.flights import Flights, record
from rss_gym.train.pathwise.surrogate import Surrogate

STEEPEST = 0.61  # of exp(-x^2 / 2)
CUT = 3.0  # an encounter's gradient is cut to so many times what one of its own near misses can be


class Pathwise(PPO):
    """Descends the mean over encounters of mean deviation + `miss_cost_m` exp(-(separation / `miss_m`)^2 / 2).

    The gradient is that of the recorded flights, through the agent's motion: no reward, no value, no noise of
    exploration. A round flies one encounter in every row, then goes over them `n_epochs` times. Network and files are
    those of `PPO`, whose critic stays idle.

    Parameters
    ----------
    policy, env, learning_rate, batch_size, n_epochs, max_grad_norm, and the last seven
        As of `PPO`; a batch is of encounters.
    miss_cost_m : float
        What an encounter that meets at zero separation costs, in metres of mean deviation.
    miss_m : float
        Separation at which that has fallen to 61 %.
    window : int
        Decisions of an encounter, from the first message on, that are flown again.
    gradient_decay : float
        Factor on the gradient a decision further back.
    """

    def __init__(
        self,
        policy: Any,
        env: Any,
        learning_rate: Any = 1e-3,
        batch_size: int = 1000,
        n_epochs: int = 2,
        max_grad_norm: float = 10.0,
        miss_cost_m: float = 1000.0,
        miss_m: float = 8.0,
        window: int = 130,
        gradient_decay: float = 0.95,
        stats_window_size: int = 100,
        tensorboard_log: str | None = None,
        policy_kwargs: dict[str, Any] | None = None,
        verbose: int = 0,
        seed: int | None = None,
        device: Any = "auto",
        _init_setup_model: bool = True,
    ) -> None:
        self.miss_cost_m, self.miss_m = miss_cost_m, miss_m
        self.window, self.gradient_decay = window, gradient_decay
        super().__init__(
            policy,
            env,
            learning_rate=learning_rate,
            n_steps=2,  # its buffer is not used
            batch_size=batch_size,
            n_epochs=n_epochs,
            max_grad_norm=max_grad_norm,
            stats_window_size=stats_window_size,
            tensorboard_log=tensorboard_log,
            policy_kwargs=policy_kwargs,
            verbose=verbose,
            seed=seed,
            device=device,
            _init_setup_model=_init_setup_model,
        )
        self.flights: Flights | None = None
        self.skipped = 0  # batches whose gradient was not finite

    def fly_in(self, world: Params, inputs: export.Inputs) -> None:
        """Tell the rows' world and what of their observations the network is given; a recipe checks both."""
        self.world, self.inputs = world, inputs
        self.surrogate = Surrogate(world, inputs.features, inputs.zeroed)

    def collect_rollouts(
        self, env: VecEnv, callback: BaseCallback, rollout_buffer: RolloutBuffer, n_rollout_steps: int
    ) -> bool:
        """Fly an encounter in every row."""
        callback.on_rollout_start()
        course, start = _course(env), perf_counter()
        self.flights, episodes = record(course.venv.batch, export.agent(self, self.world, self.inputs), self.window)
        course.spent_s += perf_counter() - start
        self.num_timesteps += int(sum(episode["l"] for episode in episodes))
        self.ep_info_buffer.extend(episodes)  # type: ignore[union-attr]
        callback.update_locals(locals())
        go_on = callback.on_step()
        callback.on_rollout_end()
        return go_on

    def train(self) -> None:
        """Follow the gradient."""
        self.policy.set_training_mode(True)
        self._update_learning_rate(self.policy.optimizer)
        torch.set_flush_denormal(True)  # far misses have gradients of next to nothing, and such numbers are slow
        try:
            self._descend()
        finally:
            torch.set_flush_denormal(False)

    def _descend(self) -> None:
        for chosen in self._batches():
            cost, separation, deviation = self._cost(chosen)
            self.policy.optimizer.zero_grad()
            cost.backward()
            norm = torch.nn.utils.clip_grad_norm_(self.policy.parameters(), self.max_grad_norm)
            if not torch.isfinite(norm):  # a vector of no length has no direction
                self.skipped += 1
                continue
            self.policy.optimizer.step()
            self._n_updates += 1
            near = (separation < self.miss_m).float().mean()
            told = {"cost_m": cost, "deviation_m": deviation.mean(), "gradient": norm, "near_misses": near}
            for name, value in told.items():
                self.logger.record_mean(f"train/{name}", float(value.detach()))
        self.logger.record("train/skipped", self.skipped)

    def _batches(self) -> Iterator[Flights]:
        flights = self.flights
        assert flights is not None
        for _ in range(self.n_epochs):
            for chosen in torch.randperm(len(flights)).split(self.batch_size):
                if 2 * len(chosen) >= self.batch_size:  # a few left over would count as much as a batch
                    yield flights.of(chosen)

    def _cost(self, flights: Flights) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        policy: Any = self.policy
        largest = CUT * STEEPEST * self.miss_cost_m / self.miss_m / len(flights)
        separation, deviation = self.surrogate.fly(
            flights,
            lambda rows: actor.outputs(policy, rows),
            self.gradient_decay,
            largest,
        )
        missed = torch.exp(-0.5 * (separation / self.miss_m) ** 2)
        return deviation.mean() + self.miss_cost_m * missed.mean(), separation, deviation

    def _excluded_save_params(self) -> list[str]:
        return [*super()._excluded_save_params(), "flights", "surrogate", "world", "inputs"]


def _course(env: Any) -> Course:
    while not isinstance(env, Course):
        env = env.venv
    return env
