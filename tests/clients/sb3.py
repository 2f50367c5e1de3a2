"""Stable-Baselines3 and sb3-contrib as their documentation uses them, with both functions `make_vec_env`."""

import tempfile
from pathlib import Path

import gymnasium as gym
import numpy as np
from sb3_contrib import ARS, TQC, TRPO, RecurrentPPO
from stable_baselines3 import A2C, DQN, PPO, SAC, TD3
from stable_baselines3.common.callbacks import EvalCallback
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.env_util import make_vec_env as theirs
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.logger import configure
from stable_baselines3.common.monitor import load_results
from stable_baselines3.common.vec_env import SubprocVecEnv, VecFrameStack, VecNormalize

import rss_gym  # noqa: F401
from rss_gym.ids import IDS
from rss_gym.sb3 import make_vec_env

ID = "rss_gym/Encounter-v0"

if __name__ == "__main__":
    folder = Path(tempfile.mkdtemp())
    for name in IDS:
        check_env(gym.make(name))
    model = PPO("MlpPolicy", ID, n_steps=128, batch_size=64, device="cpu").learn(256)  # an id is enough
    for make in (make_vec_env, theirs):
        venv = make(ID, n_envs=4, seed=0, env_kwargs={"channel": "outdoor"}, monitor_dir=str(folder / make.__module__))
        model = PPO("MlpPolicy", venv, n_steps=256, batch_size=64, device="cpu")
        model.set_logger(configure(None, []))
        model.learn(3000)
        assert len(model.ep_info_buffer) > 0 and np.isfinite(model.ep_info_buffer[0]["r"])
        venv.close()
        assert len(load_results(str(folder / make.__module__))) > 0
    print("* PPO on both make_vec_env: ep_rew_mean and monitor files")

    for kind in (A2C, PPO, TRPO, RecurrentPPO):
        policy = "MlpLstmPolicy" if kind is RecurrentPPO else "MlpPolicy"
        kind(policy, make_vec_env(ID, n_envs=4, seed=0), n_steps=32, device="cpu").learn(300)
    for kind in (SAC, TD3, TQC):
        kind("MlpPolicy", make_vec_env(ID, n_envs=2, seed=0), learning_starts=50, device="cpu").learn(120)
    ARS("LinearPolicy", make_vec_env(ID, n_envs=1, seed=0, max_episode_steps=20), n_delta=2, device="cpu").learn(200)
    DQN("MlpPolicy", make_vec_env(ID, action="discrete"), learning_starts=50, device="cpu").learn(120)
    print("* A2C, PPO, TRPO, RecurrentPPO, SAC, TD3, TQC, ARS, DQN: trained")

    wrapped = make_vec_env(ID, n_envs=2, wrapper_class=gym.wrappers.FlattenObservation, max_episode_steps=9)
    model = PPO("MlpPolicy", wrapped, n_steps=32, batch_size=32, device="cpu").learn(128)
    assert wrapped.env_is_wrapped(gym.wrappers.FlattenObservation) == [True, True] and model.ep_info_buffer[0]["l"] == 9
    workers = make_vec_env(ID, n_envs=2, vec_env_cls=SubprocVecEnv, vec_env_kwargs={"start_method": "spawn"})
    workers.reset()
    workers.close()
    venv = VecNormalize(VecFrameStack(make_vec_env(ID, n_envs=4, seed=0), 2))
    callback = EvalCallback(VecNormalize(VecFrameStack(make_vec_env(ID, seed=9), 2), training=False), eval_freq=100)
    model = PPO("MlpPolicy", venv, n_steps=64, batch_size=64, device="cpu").learn(512, callback=callback)
    model.save(folder / "model")
    again = PPO.load(folder / "model", env=venv, device="cpu")
    assert np.isfinite(evaluate_policy(again, venv, n_eval_episodes=2)).all()
    print("* wrappers, SubprocVecEnv, VecNormalize, EvalCallback, save and load")
