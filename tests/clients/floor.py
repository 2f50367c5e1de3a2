"""Gymnasium 0.29.1, the oldest that works: its checker, its wrappers, its vector environments, and the batch."""

import gymnasium as gym
import numpy as np
from gymnasium.utils.env_checker import check_env, data_equivalence

import rss_gym  # noqa: F401
from rss_gym.ids import IDS
from rss_gym.vector import EncounterVectorEnv

for name in IDS:
    env = gym.make(name)
    check_env(env.unwrapped, skip_render_check=True)
    env = gym.wrappers.RecordEpisodeStatistics(env)
    env.reset(seed=0)
    while True:
        _, _, terminated, truncated, info = env.step(env.action_space.sample())
        if terminated or truncated:
            break
    assert info["episode"]["l"] > 0
    assert gym.make(env.spec).reset(seed=1)[0].shape == env.observation_space.shape
    print(f"* {name} checked")

theirs = gym.vector.SyncVectorEnv([lambda: gym.make("rss_gym/Encounter-v0") for _ in range(3)])
ours = EncounterVectorEnv(3)
first, (second, _) = ours.reset(seed=5)[0], theirs.reset(seed=5)
np.testing.assert_array_equal(first, second)
ours.action_space.seed(0)
for _ in range(20):
    actions = ours.action_space.sample()
    assert data_equivalence(ours.step(actions)[:4], theirs.step(actions)[:4])
theirs.close()
try:
    gym.make_vec("rss_gym/Encounter3D-v0", num_envs=2, vectorization_mode="custom")
except gym.error.Error:
    print("* make_vec in mode `custom` is refused here, as it would drop the keywords of an id")
else:
    raise AssertionError("make_vec made a world without the id's keywords")
made = gym.make_vec("rss_gym/Encounter3D-v0", num_envs=2, vectorization_mode="sync")
assert made.reset(seed=0)[0].shape[0] == 2
statistics = gym.wrappers.RecordEpisodeStatistics(EncounterVectorEnv(4, autoreset_mode="SameStep", max_episode_steps=7))
statistics.reset(seed=0)
ends = 0
for _ in range(30):
    *_, infos = statistics.step(statistics.action_space.sample())
    ends += int("episode" in infos)
assert ends >= 4
print("* vector environments checked")
