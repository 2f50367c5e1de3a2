"""Many encounters on many machines: blocks on the executor of a Dask client, or parts that any scheduler runs.

Needs the extra `cluster`: pip install -e '.[cluster]' in the clone. Without --scheduler it starts two workers here.

    python examples/cluster.py --episodes 100000 --scheduler tcp://head:8786
"""

import argparse

from distributed import Client, LocalCluster, as_completed

from rss_gym.eval import evaluate, fly, merge
from rss_gym.eval.text import table

POLICIES = ["orthogonal", "orca:radius_m=20"]


def main() -> None:
    """Fly the same encounters both ways; the scores are equal, bit for bit."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--episodes", type=int, default=100_000)
    parser.add_argument("--part", type=int, default=10_000, help="encounters of one task")
    parser.add_argument("--scheduler", help="address of a Dask scheduler; default: two workers of this machine")
    options = parser.parse_args()
    cluster = None if options.scheduler else LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with Client(options.scheduler or cluster) as client:
        # One call, when the process that makes it can stay: Dask flies a block again if its worker is lost.
        one = evaluate(POLICIES, episodes=options.episodes, block=options.part, executor=client.get_executor())

        # Parts, when tasks are submitted by other means or kept on disk (`pickle`): Ray, joblib, an array job.
        starts = range(0, options.episodes, options.part)
        ranges = [range(first, min(first + options.part, options.episodes)) for first in starts]
        tasks = [client.submit(fly, POLICIES, episodes=numbers, pure=False) for numbers in ranges]
        other = merge(task.result() for task in as_completed(tasks))
    if cluster is not None:
        cluster.close()
    print(table(one))
    print(f"parts and blocks agree: {all(one[name] == other[name] for name in ('none', *POLICIES))}")


if __name__ == "__main__":
    main()
