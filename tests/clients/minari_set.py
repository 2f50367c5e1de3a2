"""Minari: collect with infos, create, load, recover the environment."""

import gymnasium as gym
import minari
import numpy as np

import rss_gym  # noqa: F401

env = minari.DataCollector(gym.make("rss_gym/Encounter-v0", channel="outdoor"), record_infos=True)
for episode in range(2):
    env.reset(seed=episode)
    while True:
        _, _, terminated, truncated, _ = env.step(env.action_space.sample())
        if terminated or truncated:
            break
name = "rss/encounter/random-v0"
if name in minari.list_local_datasets():
    minari.delete_dataset(name)
made = env.create_dataset(name, algorithm_name="random", code_permalink="none", author="none", author_email="none")
found = minari.load_dataset(name)
assert found.total_episodes == 2 and found.total_steps == made.total_steps
again = found.recover_environment()
assert again.unwrapped.params.channels[0].path_loss_factor == 2.7 or again.unwrapped.params.channels
one = next(iter(found.iterate_episodes()))
assert np.isfinite(one.rewards).all() and "cost_m" in one.infos
minari.delete_dataset(name)
print(f"* {made.total_steps} steps collected with their infos, loaded, and the environment recovered")
