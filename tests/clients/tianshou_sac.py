"""Tianshou 2: SAC and PPO by its high-level interface, and its vector environments."""

import gymnasium as gym
import numpy as np
from tianshou.env import DummyVectorEnv, SubprocVectorEnv
from tianshou.highlevel.config import OffPolicyTrainingConfig, OnPolicyTrainingConfig
from tianshou.highlevel.env import EnvFactoryRegistered, VectorEnvType
from tianshou.highlevel.experiment import ExperimentConfig, PPOExperimentBuilder, SACExperimentBuilder
from tianshou.highlevel.params.algorithm_params import PPOParams, SACParams

import rss_gym  # noqa: F401

ID = "rss_gym/Encounter-v0"


def make():
    return gym.make(ID)


def returned(experiment):
    """Mean return of the last test of a training of two epochs."""
    result = experiment.run().trainer_result
    assert result.train_step >= 1000 and result.update_step > 0
    assert np.isfinite(result.best_reward)
    return result.best_reward


if __name__ == "__main__":
    for kind in (DummyVectorEnv, SubprocVectorEnv):
        envs = kind([make, make])
        observations, infos = envs.reset(seed=3)
        np.testing.assert_array_equal(observations, [make().reset(seed=3)[0]] * 2)
        assert "cost_m" in infos[0] and envs.get_env_attr("render_mode") == [None, None]
        envs.close()
    factory = EnvFactoryRegistered(task=ID, venv_type=VectorEnvType.DUMMY, channel="outdoor")
    setting = ExperimentConfig(persistence_enabled=False, watch=False)
    size = {"max_epochs": 2, "epoch_num_steps": 500, "num_training_envs": 2, "num_test_envs": 2}
    off = OffPolicyTrainingConfig(
        **size, batch_size=64, buffer_size=2000, collection_step_num_env_steps=100,
        update_step_num_gradient_steps_per_sample=0.2, start_timesteps=100, start_timesteps_random=True,
    )  # fmt: skip
    on = OnPolicyTrainingConfig(
        **size, batch_size=64, buffer_size=500, collection_step_num_env_steps=250, update_step_num_repetitions=2
    )
    sac = SACExperimentBuilder(factory, setting, off).with_sac_params(SACParams())
    ppo = PPOExperimentBuilder(factory, setting, on).with_ppo_params(PPOParams())
    for name, builder in (
        ("SAC", sac.with_actor_factory_default((32, 32)).with_common_critic_factory_default((32, 32))),
        ("PPO", ppo.with_actor_factory_default((32, 32)).with_critic_factory_default((32, 32))),
    ):
        best = returned(builder.build())
        print(f"* {name} by the high-level interface, two epochs: best mean return of a test {best:.1f}")
    print("* DummyVectorEnv and SubprocVectorEnv, seeded")
