"""The environment part of CleanRL's `ppo_continuous_action.py`, as that script has it, at its pin gymnasium 0.29.1."""

import gymnasium as gym
import numpy as np
import torch
from torch import nn

import rss_gym  # noqa: F401

GAMMA = 0.99


def make_env(env_id, idx, capture_video, run_name, gamma):
    def thunk():
        if capture_video and idx == 0:
            env = gym.make(env_id, render_mode="rgb_array")
            env = gym.wrappers.RecordVideo(env, f"videos/{run_name}")
        else:
            env = gym.make(env_id)
        env = gym.wrappers.FlattenObservation(env)
        env = gym.wrappers.RecordEpisodeStatistics(env)
        env = gym.wrappers.ClipAction(env)
        env = gym.wrappers.NormalizeObservation(env)
        env = gym.wrappers.TransformObservation(env, lambda obs: np.clip(obs, -10, 10))
        env = gym.wrappers.NormalizeReward(env, gamma=gamma)
        env = gym.wrappers.TransformReward(env, lambda reward: np.clip(reward, -10, 10))
        return env

    return thunk


envs = gym.vector.SyncVectorEnv([make_env("rss_gym/Encounter-v0", i, False, "x", GAMMA) for i in range(4)])
assert isinstance(envs.single_action_space, gym.spaces.Box)
actor = nn.Linear(np.prod(envs.single_observation_space.shape), np.prod(envs.single_action_space.shape))
observation, _ = envs.reset(seed=1)
ends = 0
for _ in range(400):
    with torch.no_grad():
        action = actor(torch.Tensor(observation))
    observation, reward, terminations, truncations, infos = envs.step(action.cpu().numpy())
    if "final_info" in infos:
        for info in infos["final_info"]:
            if info and "episode" in info:
                ends += 1
assert ends > 0 and np.isfinite(observation).all()
print(f"* CleanRL's loop: {ends} episodes with their statistics")
