"""PPO of Stable-Baselines3 on the plain observations, beside two rules: python examples/sb3_ppo.py [STEPS EPISODES]."""

import sys

import torch
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecNormalize

from rss_gym.eval import evaluate, text
from rss_gym.sb3 import make_vec_env

steps, episodes = map(int, sys.argv[1:] or (3_000_000, 10_000))
torch.set_num_threads(1)
prices = {"collision_price_m": 0.0, "snmac_price_m": 0.0, "proximity_price_m": 4000.0, "comfort_m": 25.0}
env = VecNormalize(make_vec_env("rss_gym/Encounter-v0", n_envs=256, seed=0, **prices), norm_obs=False, gamma=0.95)
options = {"n_steps": 32, "batch_size": 2048, "n_epochs": 8, "gamma": 0.95, "ent_coef": 0.003}
model = PPO("MlpPolicy", env, learning_rate=lambda left: 3e-3 * left, seed=0, device="cpu", **options).learn(steps)
rules = {"rule": "orthogonal:radius_m=40", "orca": "orca:radius_m=20"}
print(text.table(evaluate({"ppo": model, **rules}, episodes=episodes)))
