"""Train an agent in minutes and score it beside rules: python examples/train_in_minutes.py [--steps N].

It is what `rss-gym train ppo-short` does, from Python. Needs the extra `train`.
"""

import argparse

from rss_gym.eval import evaluate, text
from rss_gym.train import recipe, run


def main() -> None:
    """Train, then fly the agent and the rules over the same encounters."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=3_000_000, help="decisions")
    parser.add_argument("--set", nargs="*", default=[], metavar="KEY=VALUE", help="other changes of the recipe")
    parser.add_argument("--episodes", type=int, default=5000, help="encounters of the scores")
    parser.add_argument("--out", default="runs/minutes", help="new folder for the run")
    options = parser.parse_args()
    changes = {**recipe.parse_changes(options.set), "recipe.steps": options.steps}
    agent = run.start(recipe.load("ppo-short", changes), options.out)
    # The agent is a folder of numbers: it runs without PyTorch, here and by `rss-gym eval --policy FOLDER`.
    policies = {"agent": str(agent), "orthogonal": "orthogonal:radius_m=40", "orca": "orca:radius_m=20"}
    print(text.table(evaluate(policies, episodes=options.episodes)))


if __name__ == "__main__":
    main()
