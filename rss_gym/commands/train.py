"""`rss-gym train`: train agents by a recipe, or go on with a run."""

from __future__ import annotations

import argparse
import sys

from rss_gym.commands.shared import add_channel, add_out, add_workers, count

HELP = "train agents by a recipe, or go on with a run"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("recipe", nargs="?", metavar="RECIPE", help="name of a shipped recipe, or a TOML file")
    parser.add_argument("--env", metavar="ID", help="environment to train in (default: that of the recipe)")
    parser.add_argument(
        "--steps", type=count, metavar="N", help="decisions of one training, over all rows of its batch"
    )
    parser.add_argument(
        "--seeds", type=count, metavar="N", help="number of trainings that differ in their seed only (default: 1)"
    )
    add_workers(parser, "processes, each with one seed at a time (default: 1)")
    add_channel(parser)
    parser.add_argument("--information", metavar="LEVEL", help="level of information: oracle, positions or ranges")
    parser.add_argument("--resume", metavar="RUN", help="go on with the run in this folder from its checkpoints")
    parser.add_argument(
        "--set",
        nargs="+",
        action="extend",
        metavar="KEY=VALUE",
        help="change the recipe, such as algorithm.learning_rate=3e-4 world.comfort_m=30",
    )
    add_out(parser, "RUN", "new folder for the run", required=False, hold=False)  # the run has a lock of its own


def run(options: argparse.Namespace) -> int:
    """Train."""
    from rss_gym.params import ParamsError
    from rss_gym.train import recipe, run

    changes = recipe.parse_changes(options.set or [])
    short = {"recipe.env": options.env, "recipe.steps": options.steps}
    short |= {"world.channel": options.channel, "world.information": options.information}
    changes |= {key: value for key, value in short.items() if value is not None}
    try:
        if options.resume is None:
            if options.recipe is None or options.out is None:
                shipped = ", ".join(recipe.recipes())
                raise ParamsError(f"name a recipe and --out, or a run to --resume; shipped recipes: {shipped}")
            seeds = 1 if options.seeds is None else options.seeds
            run.start(recipe.load(options.recipe, changes), options.out, seeds, options.workers, options.given)
        else:
            if changes or any(value is not None for value in (options.recipe, options.seeds, options.out)):
                raise ParamsError("--resume goes on with a run as it was begun: give it nothing but --workers")
            run.resume(options.resume, options.workers)
    except KeyboardInterrupt:
        how = f"go on with rss-gym train --resume {options.resume or options.out}"
        print(f"rss-gym: interrupted; {how}", file=sys.stderr)
        return 130
    return 0
