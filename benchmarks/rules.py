"""Decisions per CPU second of each scripted rule in a batch, beside RVO2's doStep: python benchmarks/rules.py

Observations are those of flights of `none`: the rules act on as many as there are conflicts in the distribution.
"""

import importlib.util
import statistics
import time
from collections.abc import Callable

import numpy as np

from rss_gym import baselines, observation
from rss_gym.baselines.intruders import intruders
from rss_gym.baselines.qmdp import Qmdp, table_of
from rss_gym.core import Batch
from rss_gym.params import Params

ROWS, DECISIONS, ROUNDS = 2048, 12, 5
EVERY = 8  # decisions between two observations that are kept
AIMS = {"orthogonal": 200_000, "orca": 200_000, "mvp": 200_000, "cbf": 200_000, "mpc": 20_000, "qmdp": 20_000}


def observations() -> list[np.ndarray]:
    """Batches along the flights."""
    batch = Batch(Params(), ROWS)
    batch.seed(np.arange(ROWS, dtype=np.uint64))
    batch.reset(np.ones(ROWS, bool))
    kept = []
    for step in range(EVERY * DECISIONS):
        if step % EVERY == 0:
            kept.append(batch.observations.copy())
        batch.step(np.zeros((ROWS, 3)), ~(batch.episode["terminated"] | batch.episode["truncated"]))
    return kept


def rates(go: Callable[[], int]) -> list[float]:
    """Decisions per CPU second of each round, after one that is not counted."""
    go()
    found = []
    for _ in range(ROUNDS):
        start = time.process_time()
        count = go()
        found.append(count / (time.process_time() - start))
    return found


def rule(name: str, batches: list[np.ndarray]) -> list[float]:
    """Of a policy's `predict`."""
    policy = baselines.make(name)

    def go() -> int:
        state = None
        for batch in batches:
            _, state = policy.predict(batch, state)
        return ROWS * len(batches)

    return rates(go)


def rvo2() -> list[float]:
    """Of `doStep` of a simulator with pairs of agents, far from other pairs; one step decides for both of each."""
    import pyrvo

    generator = np.random.default_rng(0)
    simulator = pyrvo.RVOSimulator(0.5, 200.0, 1, 10.0, 10.0, 12.5, 5.0)
    for pair in range(ROWS // 2):
        place = np.array([pair % 32, pair // 32]) * 2000.0
        for _ in range(2):
            agent = simulator.add_agent([float(value) for value in place + generator.uniform(-60.0, 60.0, 2)])
            velocity = [float(value) for value in generator.uniform(-2.8, 2.8, 2)]
            simulator.set_agent_velocity(agent, velocity)
            simulator.set_agent_pref_velocity(agent, velocity)

    def go() -> int:
        for _ in range(DECISIONS):
            simulator.do_step()
        return ROWS * DECISIONS

    return rates(go)


def main() -> None:
    """Print the table and the ratios."""
    batches, params = observations(), Params()
    baselines.make("qmdp").predict(batches[0])  # its kernels are compiled
    known = np.mean([intruders(observation.split(batch, params)).known for batch in batches])
    start = time.process_time()
    table_of.__wrapped__(params, Qmdp().drift_mps, Qmdp().flight_s)
    print(f"the table of qmdp: solved in {time.process_time() - start:.2f} CPU s")
    print(f"{ROWS} rows x {DECISIONS} observations, an intruder known in {known:.0%} of them")
    print(f"{'decisions per CPU second, one core':<40} {'best':>12} {'median':>12}")
    best = {name: rule(name, batches) for name in AIMS}
    library = rvo2() if importlib.util.find_spec("pyrvo") else None
    for name, found in {**best, **({"RVO2 doStep (pyrvo)": library} if library else {})}.items():
        print(f"{name:<40} {max(found):>12,.0f} {statistics.median(found):>12,.0f}")
    for name, aim in AIMS.items():
        ratio = f", {max(best[name]) / max(library):.2f} of RVO2's" if library else ""
        print(f"{name}: against {aim:,}: {'met' if max(best[name]) >= aim else 'MISSED'}{ratio}")


if __name__ == "__main__":
    main()
