"""Cost of a decision of the range-only filter: python benchmarks/range_filter.py

CPU time of `predict` alone, on recorded observations, beside the same rule on exchanged positions in the same run.
"""

import statistics
import time

import numpy as np

from rss_gym import baselines
from rss_gym.baselines.policy import Scripted
from rss_gym.core import Batch
from rss_gym.observation import split

ROWS, DECISIONS, ROUNDS, AIM = 1024, 60, 5, 20_000


def rates(policy: Scripted) -> tuple[list[float], float]:
    """Decisions per CPU second of each round, after one that is not counted, and the share with an open bank."""
    batch = Batch(policy.world, ROWS)
    batch.seed(np.arange(ROWS, dtype=np.uint64))
    batch.reset(np.ones(ROWS, bool))
    recorded = []
    for _ in range(DECISIONS):
        recorded.append(batch.observations.copy())
        batch.step(np.zeros((ROWS, 3)), np.zeros(ROWS, bool))
    out = []
    for _ in range(1 + ROUNDS):
        state, start = None, time.process_time()
        for observations in recorded:
            _, state = policy.predict(observations, state)
        out.append(DECISIONS * ROWS / (time.process_time() - start))
    told = [split(observations, policy.world)["message_valid"].mean() for observations in recorded]
    return out[1:], float(np.mean(told))


def main() -> None:
    """Print rates, their ratio and whether the aim is met."""
    with_filter, share = rates(baselines.make("orthogonal@range"))
    without, _ = rates(baselines.make("orthogonal@paper"))
    print(f"{'decisions per CPU second, one core':<40} {'best':>12} {'median':>12}  of {ROUNDS} rounds of {ROWS} rows")
    for name, found in (("orthogonal on track range", with_filter), ("orthogonal on track paper", without)):
        print(f"{name:<40} {max(found):>12,.0f} {statistics.median(found):>12,.0f}")
    print(f"a bank is open in {share:.0%} of the decisions")
    print(f"ratio {max(with_filter) / max(without):.3f}; {max(with_filter):,.0f} against {AIM:,}: ", end="")
    print("met" if max(with_filter) >= AIM else "MISSED")


if __name__ == "__main__":
    main()
