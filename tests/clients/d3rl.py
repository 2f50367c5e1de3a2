"""d3rlpy: a data set collected with a random policy, and offline learning from it."""

import d3rlpy
import gymnasium as gym

import rss_gym  # noqa: F401

env = gym.make("rss_gym/Encounter-v0")
buffer = d3rlpy.dataset.create_fifo_replay_buffer(limit=2000, env=env)
policy = d3rlpy.algos.RandomPolicyConfig().create()
policy.collect(env, buffer, n_steps=600, show_progress=False)
assert buffer.transition_count > 500
learner = d3rlpy.algos.TD3PlusBCConfig(batch_size=32).create(device=False)
learner.fit(
    buffer,
    n_steps=50,
    n_steps_per_epoch=50,
    show_progress=False,
    experiment_name="rss",
    logger_adapter=d3rlpy.logging.NoopAdapterFactory(),
)
score = d3rlpy.metrics.EnvironmentEvaluator(env, n_trials=1)(learner, dataset=None)
print(f"* TD3+BC on {buffer.transition_count} transitions; score of an episode {score:.1f}")
