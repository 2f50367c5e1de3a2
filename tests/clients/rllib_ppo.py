"""RLlib: PPO, two iterations."""

import os

os.environ["RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO"] = "0"

import gymnasium as gym
import numpy as np
import ray
from ray.rllib.algorithms.ppo import PPOConfig
from ray.tune.registry import register_env


def make(config):
    import rss_gym  # noqa: F401

    return gym.make("rss_gym/Encounter-v0", **config)


if __name__ == "__main__":
    ray.init(num_cpus=1, include_dashboard=False, logging_level="ERROR")
    register_env("encounter", make)
    config = (
        PPOConfig()
        .environment("encounter", env_config={"channel": "outdoor"})
        .env_runners(num_env_runners=0, num_envs_per_env_runner=2)
        .training(train_batch_size_per_learner=600, minibatch_size=128, num_epochs=1)
    )
    algorithm = config.build_algo()
    for _ in range(2):
        result = algorithm.train()
    returned = result["env_runners"]["episode_return_mean"]
    assert np.isfinite(returned)
    algorithm.stop()
    ray.shutdown()
    print(f"* PPO, two iterations: mean return {returned:.1f}")
