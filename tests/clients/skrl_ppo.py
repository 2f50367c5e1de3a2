"""skrl: its wrapper of Gymnasium's vector environments, stepped."""

import gymnasium as gym
import torch
from skrl.envs.wrappers.torch import wrap_env

import rss_gym  # noqa: F401

for made in (gym.make("rss_gym/Encounter-v0"), gym.make_vec("rss_gym/Encounter-v0", num_envs=4)):
    env = wrap_env(made)
    observation, _ = env.reset()
    ends = 0
    for _ in range(250):
        action = torch.rand(env.num_envs, *env.action_space.shape) * 2 - 1
        observation, reward, terminated, truncated, _ = env.step(action)
        ended = bool((terminated | truncated).any())
        ends += ended
        if ended and env.num_envs == 1:
            env.reset()
    assert ends > 0 and torch.isfinite(observation).all() and reward.shape == (env.num_envs, 1)
print("* wrap_env of a single and of the vector environment")
