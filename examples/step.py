"""Step the environment, one encounter and many side by side: python examples/step.py [--rows N] [--steps N]."""

import argparse

import gymnasium as gym
import numpy as np

import rss_gym  # noqa: F401  registers the ids
from rss_gym import baselines, observation


def alone() -> None:
    """Fly one encounter with the paper's rule."""
    policy = baselines.make("orthogonal:radius_m=60")
    env = gym.make("rss_gym/Encounter-v0")
    row, _ = env.reset(seed=0)
    state, done, total = None, False, 0.0
    while not done:
        action, state = policy.predict(row, state)
        row, reward, terminated, truncated, info = env.step(action)
        done, total = terminated or truncated, total + reward
    seen = observation.split(row, env.unwrapped.params)  # fields by name, in SI units
    print(
        f"one encounter: cost {info['cost_m']:.1f} m, minus the return {total:.1f}; least separation "
        f"{info['min_separation_m']:.1f} m, greatest deviation {info['deviation_max_m']:.1f} m; in the end the "
        f"intruder is estimated at {seen['range_m'][0]:.0f} m"
    )


def side_by_side(rows: int, steps: int) -> None:
    """Fly a batch with random actions; a row starts its next encounter in the step that ends one."""
    envs = gym.make_vec("rss_gym/Encounter-v0", num_envs=rows, autoreset_mode="SameStep")
    envs.reset(seed=0)  # row i is the single environment reset with seed 0 + i
    generator, ended, collisions = np.random.default_rng(0), 0, 0
    for _ in range(steps):
        actions = generator.uniform(-1.0, 1.0, envs.action_space.shape).astype(np.float32)
        _, _, terminated, truncated, infos = envs.step(actions)
        if (terminated | truncated).any():
            ended += int((terminated | truncated).sum())
            collisions += int(infos["final_info"]["collision"].sum())
    print(f"{rows} rows of {steps} decisions: {ended} encounters ended, {collisions} of them with a collision")
    envs.close()


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, default=256)
    parser.add_argument("--steps", type=int, default=500)
    options = parser.parse_args()
    alone()
    side_by_side(options.rows, options.steps)


if __name__ == "__main__":
    main()
