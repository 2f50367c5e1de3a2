"""imitation 1.0.1: roll-outs of a rule, behavioural cloning, as its quick start has it."""

import numpy as np
from imitation.algorithms import bc
from imitation.data import rollout
from imitation.data.wrappers import RolloutInfoWrapper
from imitation.util.util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy

import rss_gym  # noqa: F401
from rss_gym import baselines

rng = np.random.default_rng(0)
venv = make_vec_env("rss_gym/Encounter-v0", rng=rng, n_envs=2, post_wrappers=[lambda env, _: RolloutInfoWrapper(env)])
expert = baselines.make("orca")


def rule(observations, states, dones):
    return expert.predict(observations)


trajectories = rollout.rollout(rule, venv, rollout.make_sample_until(min_episodes=4), rng=rng)
transitions = rollout.flatten_trajectories(trajectories)
trainer = bc.BC(
    observation_space=venv.observation_space, action_space=venv.action_space, demonstrations=transitions, rng=rng
)
trainer.train(n_epochs=1)
mean, _ = evaluate_policy(trainer.policy, venv, 2)
assert np.isfinite(mean)
print(f"* BC on {len(transitions)} transitions of a rule: mean return {mean:.1f}")
