"""Tianshou 2: its vector environment and collector, with a policy that draws at random."""

import gymnasium as gym
from tianshou.algorithm.random import MARLRandomDiscreteMaskedOffPolicyAlgorithm  # noqa: F401
from tianshou.data import Collector, VectorReplayBuffer
from tianshou.env import DummyVectorEnv

import rss_gym  # noqa: F401

envs = DummyVectorEnv([lambda: gym.make("rss_gym/Encounter-v0") for _ in range(2)])
observation, info = envs.reset(seed=0)
assert observation.shape[0] == 2 and "cost_m" in info[0]
ends = 0
for _ in range(250):
    observation, reward, terminated, truncated, info = envs.step([space.sample() for space in envs.action_space])
    ended = terminated | truncated
    ends += int(ended.sum())
    if ended.any():
        envs.reset(ended.nonzero()[0])
assert ends > 0 and VectorReplayBuffer(100, 2).maxsize == 100 and Collector
print(f"* DummyVectorEnv: {ends} episodes")
