"""PPO in one file, on `gym.make_vec` and PyTorch alone: python examples/ppo_single_file.py [--steps N].

The settings of `sb3_ppo.py`, two million decisions, in two minutes of processor time.
"""

import argparse
import time
from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from torch import nn

import rss_gym  # noqa: F401  registers the ids
from rss_gym.eval import evaluate, text

# Prices of the training: only being near costs something, as collisions are too rare to learn from.
WORLD: dict[str, Any] = {
    "collision_price_m": 0.0,
    "snmac_price_m": 0.0,
    "proximity_price_m": 4000.0,
    "comfort_m": 25.0,
}
ROWS, LENGTH = 256, 32  # of a rollout
EPOCHS, MINIBATCH = 8, 2048
RATE, DISCOUNT, LAMBDA, CLIP = 3e-3, 0.95, 0.95, 0.2
LOG_STD = 0.0


class Actor(nn.Module):
    """Gaussian policy and value; `predict` is the mean action, as the evaluator wants it."""

    def __init__(self, inputs: int, axes: int) -> None:
        super().__init__()
        self.mean = self._network(inputs, axes, 0.01)
        self.value = self._network(inputs, 1, 1.0)
        self.log_std = nn.Parameter(torch.full((axes,), LOG_STD))

    @staticmethod
    def _network(inputs: int, outputs: int, gain: float) -> nn.Sequential:
        layers = [nn.Linear(inputs, 128), nn.Linear(128, 128), nn.Linear(128, outputs)]
        for layer, size in zip(layers, (2**0.5, 2**0.5, gain), strict=True):
            nn.init.orthogonal_(layer.weight, size)
            nn.init.zeros_(layer.bias)
        return nn.Sequential(layers[0], nn.Tanh(), layers[1], nn.Tanh(), layers[2])

    def distribution(self, rows: torch.Tensor) -> torch.distributions.Normal:
        """Of the actions."""
        return torch.distributions.Normal(self.mean(rows), self.log_std.exp())

    @torch.no_grad()
    def predict(
        self, rows: np.ndarray, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> Any:
        """Actions (n, axes) for observations (n, d)."""
        return self.mean(torch.as_tensor(rows)).clamp(-1.0, 1.0).numpy(), state


class Scale:
    """Divides rewards by the spread of their discounted return, counted over all steps so far."""

    def __init__(self) -> None:
        self.returns, self.count, self.mean, self.square = np.zeros(ROWS), 1e-4, 0.0, 1e-4

    def __call__(self, rewards: np.ndarray, ended: np.ndarray) -> np.ndarray:
        self.returns = DISCOUNT * self.returns + rewards
        total, shift = self.count + ROWS, self.returns.mean() - self.mean
        self.square += self.returns.var() * ROWS + shift**2 * self.count * ROWS / total
        self.mean, self.count = self.mean + shift * ROWS / total, total
        self.returns[ended] = 0.0
        return (rewards / np.sqrt(self.square / self.count)).astype(np.float32)


def train(steps: int, seed: int) -> Actor:
    """The actor after so many decisions over all rows."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    envs = gym.make_vec("rss_gym/Encounter-v0", num_envs=ROWS, autoreset_mode="SameStep", **WORLD)
    inputs, axes = envs.single_observation_space.shape[0], envs.single_action_space.shape[0]
    now = torch.from_numpy(envs.reset(seed=seed)[0])
    actor = Actor(inputs, axes)
    optimiser = torch.optim.Adam(actor.parameters(), eps=1e-5)
    rollouts = max(1, steps // (ROWS * LENGTH))
    observations, actions = torch.zeros(LENGTH, ROWS, inputs), torch.zeros(LENGTH, ROWS, axes)
    rewards, dones = torch.zeros(LENGTH, ROWS), torch.zeros(LENGTH, ROWS)
    scale, start = Scale(), time.monotonic()
    for number in range(rollouts):
        for group in optimiser.param_groups:
            group["lr"] = RATE * (1.0 - number / rollouts)
        ends = collisions = 0
        for t in range(LENGTH):
            with torch.no_grad():
                drawn = actor.distribution(now).sample()
            observations[t], actions[t] = now, drawn
            after, reward, terminated, truncated, infos = envs.step(drawn.clamp(-1.0, 1.0).numpy())
            # Nothing is paid after the clock has run out, so its end is an end, without a value beyond it.
            ended = terminated | truncated
            rewards[t], dones[t] = torch.from_numpy(scale(reward, ended)), torch.from_numpy(ended)
            now = torch.from_numpy(after)
            if ended.any():
                ends += int(ended.sum())
                collisions += int(infos["final_info"]["collision"].sum())
        learn(actor, optimiser, (observations, actions, rewards, dones), now)
        if (number + 1) % max(1, rollouts // 20) == 0:
            done = (number + 1) * ROWS * LENGTH
            print(
                f"{done:,} decisions, {done / (time.monotonic() - start):,.0f} a second: {collisions} collisions in "
                f"{ends} encounters",
                flush=True,
            )
    envs.close()
    return actor


def advantages(rewards: torch.Tensor, dones: torch.Tensor, values: torch.Tensor, last: torch.Tensor) -> torch.Tensor:
    """Generalised advantages (steps, rows), of values of the same shape and of what follows the last, (rows,)."""
    found, carried, following = torch.zeros_like(rewards), torch.zeros_like(last), last
    for t in reversed(range(len(rewards))):
        going = 1.0 - dones[t]
        error = rewards[t] + DISCOUNT * following * going - values[t]
        found[t] = carried = error + DISCOUNT * LAMBDA * going * carried
        following = values[t]
    return found


def learn(actor: Actor, optimiser: torch.optim.Adam, rollout: Sequence[torch.Tensor], last: torch.Tensor) -> None:
    """One update from a rollout (observations, actions, rewards, dones) and the observations behind it."""
    observations, actions, rewards, dones = rollout
    with torch.no_grad():
        values = actor.value(observations)[..., 0]
        log_prob = actor.distribution(observations).log_prob(actions).sum(-1)
        gains = advantages(rewards, dones, values, actor.value(last)[:, 0])
    batch = [x.flatten(0, 1) for x in (observations, actions, log_prob, gains, gains + values)]
    for _ in range(EPOCHS):
        for index in torch.randperm(ROWS * LENGTH).split(MINIBATCH):
            rows, act, old, gain, target = (x[index] for x in batch)
            gain = (gain - gain.mean()) / (gain.std() + 1e-8)
            ratio = (actor.distribution(rows).log_prob(act).sum(-1) - old).exp()
            policy = -torch.min(gain * ratio, gain * ratio.clamp(1.0 - CLIP, 1.0 + CLIP)).mean()
            value = 0.5 * (actor.value(rows)[:, 0] - target).square().mean()
            optimiser.zero_grad()
            (policy + 0.5 * value).backward()
            nn.utils.clip_grad_norm_(actor.parameters(), 0.5)
            optimiser.step()


def main() -> None:
    """Train, then score the actor beside rules on encounters that it has not seen."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=2_000_000, help="decisions over all rows")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--episodes", type=int, default=5000, help="encounters of the scores")
    options = parser.parse_args()
    actor = train(options.steps, options.seed)
    policies = {
        "ppo": actor,
        "orthogonal, 30 m": "orthogonal:radius_m=30",
        "orthogonal, 40 m": "orthogonal:radius_m=40",
    }
    print(text.table(evaluate(policies, episodes=options.episodes)))


if __name__ == "__main__":
    main()
