"""Step rates on one core, in CPU time, beside other environments in the same run: python benchmarks/speed.py

CPU time excludes waiting, but other work on the machine still costs cache and clock: read the ratios.
"""

import importlib.util
import statistics
import time
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import radio

import rss_gym  # noqa: F401  registers the ids

ROWS, ROUNDS = 1024, 5
VECTOR_BAR, RANGES_BAR, SINGLE_BAR, SINGLE_AIM = 700_000, 400_000, 70_000, 100_000


def vector_rate(env_id: str, steps: int, **keywords: Any) -> list[float]:
    """Decisions per CPU second of a vector environment under random actions, automatic resets included, by round."""
    envs = gym.make_vec(env_id, num_envs=ROWS, vectorization_mode="vector_entry_point", **keywords)
    envs.reset(seed=0)
    envs.action_space.seed(0)
    actions = [envs.action_space.sample() for _ in range(16)]

    def go() -> int:
        for step in range(steps):
            envs.step(actions[step % len(actions)])
        return steps * ROWS

    return rounds(go)


def single_rate(env_id: str, steps: int, **keywords: Any) -> list[float]:
    """Steps per CPU second of `gym.make` with its default wrappers, resets included, by round."""
    env = gym.make(env_id, **keywords)
    env.reset(seed=0)
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(16)]

    def go() -> int:
        for step in range(steps):
            _, _, terminated, truncated, _ = env.step(actions[step % len(actions)])
            if terminated or truncated:
                env.reset()
        return steps

    return rounds(go)


def rounds(go: Callable[[], int]) -> list[float]:
    """Steps per CPU second of each round, after one that is not counted."""
    go()
    rates = []
    for _ in range(ROUNDS):
        start = time.process_time()
        steps = go()
        rates.append(steps / (time.process_time() - start))
    return rates


def line(name: str, rates: list[float], unit: str = "") -> float:
    """Print best and median; returns the best."""
    best = max(rates)
    print(f"{name:<58} {best:>12,.0f} {statistics.median(rates):>12,.0f}  {unit}")
    return best


def verdict(name: str, value: float, target: float) -> None:
    """Say plainly whether a target is met."""
    print(f"{name}: {value:,.0f} against {target:,.0f}: {'met' if value >= target else 'MISSED'}")


def main() -> None:
    """Print the table, the ratios and whether the targets are met."""
    np.random.seed(0)  # noqa: NPY002  highway-env draws from the global generator
    print(f"{'per CPU second, one core':<58} {'best':>12} {'median':>12}  of {ROUNDS} rounds")
    ours = line(f"rss_gym/Encounter-v0, make_vec, {ROWS} rows", vector_rate("rss_gym/Encounter-v0", 60))
    line(f"rss_gym/Encounter3D-v0, make_vec, {ROWS} rows", vector_rate("rss_gym/Encounter3D-v0", 60))
    ranges_id = "rss_gym/EncounterRangeOnly-v0"
    ranges = line(f"{ranges_id}, make_vec, {ROWS} rows", vector_rate(ranges_id, 60))
    single = line("rss_gym/Encounter-v0, make", single_rate("rss_gym/Encounter-v0", 5000))
    cart_pole = line(f"CartPole-v1, make_vec, {ROWS} rows", vector_rate("CartPole-v1", 200))
    cart_pole_single = line("CartPole-v1, make", single_rate("CartPole-v1", 5000))
    print(f"ratio to CartPole-v1: vector {ours / cart_pole:.3f}, single {single / cart_pole_single:.3f}")
    if importlib.util.find_spec("highway_env"):
        import highway_env  # noqa: F401

        highway = line("highway-fast-v0, make", single_rate("highway-fast-v0", 10))
        print(f"ratio to highway-fast-v0: single {single / highway:,.0f}")
    else:
        print("highway-fast-v0 skipped: highway-env is not installed (extra `bench`)")
    radio.main()
    verdict("vector environment with `fused`, decisions per CPU second", ours, VECTOR_BAR)
    verdict("ranges only with `bearings`, decisions per CPU second", ranges, RANGES_BAR)
    verdict("single environment, decisions per CPU second", single, SINGLE_BAR)
    verdict("the same, aim", single, SINGLE_AIM)


if __name__ == "__main__":
    main()
