"""skrl: its PPO trained on a single and on the vector environment, as its examples do."""

import tempfile

import gymnasium as gym
import torch
from skrl.agents.torch.ppo import PPO, PPO_CFG
from skrl.envs.wrappers.torch import wrap_env
from skrl.memories.torch import RandomMemory
from skrl.models.torch import DeterministicMixin, GaussianMixin, Model
from skrl.resources.preprocessors.torch import RunningStandardScaler
from skrl.trainers.torch import SequentialTrainer
from skrl.utils import set_seed
from torch import nn

import rss_gym  # noqa: F401

ID = "rss_gym/Encounter-v0"


def layers(inputs, outputs):
    return nn.Sequential(nn.Linear(inputs, 32), nn.Tanh(), nn.Linear(32, outputs))


class Policy(GaussianMixin, Model):
    def __init__(self, **spaces):
        Model.__init__(self, **spaces)
        GaussianMixin.__init__(self, clip_actions=True)
        self.net = layers(self.num_observations, self.num_actions)
        self.log_std = nn.Parameter(torch.zeros(self.num_actions))

    def compute(self, inputs, role):
        return torch.tanh(self.net(inputs["observations"])), {"log_std": self.log_std}


class Value(DeterministicMixin, Model):
    def __init__(self, **spaces):
        Model.__init__(self, **spaces)
        DeterministicMixin.__init__(self)
        self.net = layers(self.num_observations, 1)

    def compute(self, inputs, role):
        return self.net(inputs["observations"]), {}


def trained(env, rounds, steps):
    """Train for `rounds` updates; the parameters change and stay finite."""
    spaces = {"observation_space": env.observation_space, "state_space": env.state_space}
    spaces |= {"action_space": env.action_space, "device": env.device}
    cfg = PPO_CFG(rollouts=steps, learning_epochs=2, mini_batches=4)
    cfg.observation_preprocessor = RunningStandardScaler
    cfg.observation_preprocessor_kwargs = {"size": env.observation_space, "device": env.device}
    cfg.experiment.directory = tempfile.mkdtemp()
    cfg.experiment.write_interval = cfg.experiment.checkpoint_interval = 0
    agent = PPO(
        models={"policy": Policy(**spaces), "value": Value(**spaces)},
        memory=RandomMemory(memory_size=steps, num_envs=env.num_envs, device=env.device),
        cfg=cfg, **spaces,
    )  # fmt: skip
    before = [parameter.clone() for parameter in agent.models["policy"].parameters()]
    trainer = SequentialTrainer(
        env=env, agents=agent, cfg={"timesteps": rounds * steps, "headless": True, "disable_progressbar": True}
    )
    trainer.train()
    after = list(agent.models["policy"].parameters())
    assert any(not torch.equal(one, two) for one, two in zip(before, after, strict=True))
    assert all(torch.isfinite(parameter).all() for parameter in after)


set_seed(1)
for made, steps in (
    (gym.make(ID), 256),
    (gym.make_vec(ID, num_envs=8), 64),
    (gym.make_vec(ID, num_envs=2, vectorization_mode="sync"), 64),
):
    trained(wrap_env(made), rounds=4, steps=steps)
print("* PPO, four updates each on a single environment, the vector environment and a SyncVectorEnv")
