"""The world of the page `rss-gym page fly` beside Python's: the same flights in both, every score compared bit by bit.

    python benchmarks/fly_equality.py --encounters 1000

It needs Node or Chromium, and takes some seconds for each line.
"""

import argparse

from rss_gym.eval.suites import find
from rss_gym.fly.engines import engines
from rss_gym.fly.equality import PILOTS, compare

# Further suites, with an agent that flies there: kernels that the page's own world does not reach.
OTHERS = {"encounter3d-v0": "pathwise-space", "range-only-v0": "ppo-range"}


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--encounters", type=int, default=1000)
    options = parser.parse_args()
    numbers, differ = range(options.encounters), 0
    runs = [("encounter-v0", "pathwise-plane", engine, pilot) for engine in engines() for pilot in PILOTS]
    runs += [(suite, agent, next(iter(engines())), "agent") for suite, agent in OTHERS.items()] if engines() else []
    for suite, agent, engine, pilot in runs:
        comparison = compare(find(suite), agent, numbers, engine, pilot)
        print(comparison.summary, flush=True)
        differ += options.encounters - comparison.equal
    if not runs:
        print("neither Node nor Chromium is here: nothing was compared")
    return int(differ > 0 or not runs)


if __name__ == "__main__":
    raise SystemExit(main())
