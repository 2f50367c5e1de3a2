"""Decisions a second of a training, end to end, and who spends the time: python benchmarks/training.py [--steps N]

Other work on the machine counts into wall time. Seeing the figures needs no trained agent, so few steps will do.
"""

import argparse
import tempfile
from pathlib import Path

TARGET = 15_000  # decisions a second of wall time, on two idle cores


def main() -> None:
    """Train `ppo-short` for a while in a folder that is thrown away."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recipe", default="ppo-short")
    parser.add_argument("--steps", type=int, default=1_000_000)
    options = parser.parse_args()
    from rss_gym.train import recipe, run

    with tempfile.TemporaryDirectory() as folder:
        run.start(recipe.load(options.recipe, {"recipe.steps": options.steps}), Path(folder) / "run")
    print(f"target: {TARGET:,} decisions a second of wall time on two idle cores")


if __name__ == "__main__":
    main()
