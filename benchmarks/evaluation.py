"""Wall time and memory of the evaluator: python benchmarks/evaluation.py [--million]

Each size runs in a fresh process, so that its peak memory is its own. Other work on the machine counts into wall time.
"""

import argparse
import json
import resource
import subprocess
import sys
import time

SIZES = (10_000, 100_000)
POLICIES = 9


def measure(episodes: int, workers: int) -> dict[str, float]:
    """Fly `orthogonal` (and `none`, which every score needs); seconds and peak MiB of this process and of a worker."""
    from rss_gym.eval import evaluate

    evaluate("orthogonal", episodes=16)  # compiled code comes from the cache
    start = time.perf_counter()
    evaluate("orthogonal", episodes=episodes, workers=workers)
    usage = [resource.getrusage(who).ru_maxrss / 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return {"wall_s": time.perf_counter() - start, "process_mib": usage[0], "worker_mib": usage[1]}


def metrics_of_nine() -> float:
    """CPU seconds for all metrics and intervals of nine policies at 10,000 episodes."""
    from rss_gym.eval import evaluate
    from rss_gym.eval.evaluate import score

    result = evaluate("orthogonal", episodes=10_000)
    scored = result.policies
    start = time.process_time()
    entries, tables = [s.entry for s in scored], [s.table for s in scored]
    for _ in range(POLICIES // len(entries) + 1):
        score(result.suite, result.seed, entries, tables, entries[-1].name, official=False)
    return (time.process_time() - start) * POLICIES / (len(entries) * (POLICIES // len(entries) + 1))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--million", action="store_true", help="also 1,000,000 episodes")
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(options.one, options.workers)))
        return
    sizes = (*SIZES, 1_000_000) if options.million else SIZES
    print(f"{'episodes':>10} {'wall s':>8} {'us/episode':>11} {'process MiB':>12} {'worker MiB':>11}")
    for episodes in sizes:
        command = [sys.executable, __file__, "--one", str(episodes), "--workers", str(options.workers)]
        found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        print(
            f"{episodes:>10} {found['wall_s']:8.1f} {found['wall_s'] / episodes * 1e6:11.0f} "
            f"{found['process_mib']:12.0f} {found['worker_mib']:11.0f}"
        )
    print(f"target: 100,000 episodes of `orthogonal` under 60 s and 1 GiB a process; {options.workers} workers used")
    print(
        f"metrics and intervals of {POLICIES} policies at 10,000 episodes: {metrics_of_nine():.2f} CPU s (target: 5 s)"
    )


if __name__ == "__main__":
    main()
