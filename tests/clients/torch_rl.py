"""TorchRL: `GymEnv(ID)`, `check_env_specs`, infos, a collector."""

import torch
from torchrl.collectors import Collector
from torchrl.envs import Compose, GymEnv, RewardSum, StepCounter, TransformedEnv
from torchrl.envs.utils import check_env_specs

import rss_gym  # noqa: F401

if __name__ == "__main__":
    for name in ("rss_gym/Encounter-v0", "rss_gym/Encounter3D-v0", "rss_gym/EncounterRangeOnly-v0"):
        check_env_specs(GymEnv(name))
    env = GymEnv("rss_gym/Encounter-v0", channel="outdoor").auto_register_info_dict()
    check_env_specs(env)
    rollout = env.rollout(30)
    assert rollout["next", "cost_m"].shape[0] == len(rollout)
    vector = GymEnv("rss_gym/Encounter-v0", num_envs=2)
    check_env_specs(vector)
    made = TransformedEnv(GymEnv("rss_gym/Encounter-v0"), Compose(StepCounter(), RewardSum()))
    collector = Collector(made, made.rand_action, frames_per_batch=200, total_frames=400)
    frames = sum(batch.numel() for batch in collector)
    assert frames == 400 and torch.isfinite(rollout["observation"]).all()
    print("* check_env_specs of every id, single, with infos and vectorised; 400 frames of a collector")
