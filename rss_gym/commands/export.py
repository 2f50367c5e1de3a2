"""`rss-gym export`: make a policy folder of a run or of a model of Stable-Baselines3."""

from __future__ import annotations

import argparse
import os
import sys

from rss_gym.commands.shared import add_out

HELP = "make a policy folder, which cannot run code"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("source", metavar="RUN|MODEL", help="folder of a run, or a .zip of Stable-Baselines3")
    add_out(parser, "DIR", "new folder for the policy")
    parser.add_argument(
        "--env", metavar="ID", help="environment that the .zip was trained in (default: rss_gym/Encounter-v0)"
    )
    parser.add_argument("--algorithm", help="ppo, recurrent-ppo or sac (default: found from the .zip)")
    parser.add_argument(
        "--statistics",
        metavar="FILE",
        help="file that VecNormalize.save wrote, if the model was trained on normalised observations",
    )
    parser.add_argument(
        "--set",
        nargs="+",
        action="extend",
        metavar="KEY=VALUE",
        help="parameters of the world of the .zip, such as intruders=2",
    )


def run(options: argparse.Namespace) -> None:
    """Export, and print by how much the actions differ."""
    from rss_gym.params import ParamsError
    from rss_gym.train import convert, recipe

    if os.path.isdir(options.source):
        if any(value is not None for value in (options.env, options.algorithm, options.set, options.statistics)):
            raise ParamsError("--env, --algorithm, --set and --statistics are for a .zip; a run knows its own world")
        difference = convert.export_run(options.source, options.out)
    else:
        if any(os.path.isfile(path) for path in (options.source, f"{options.source}.zip")):  # SB3 adds the ending
            print(f"Reading {options.source} runs code from it.", file=sys.stderr, flush=True)
        world = recipe.parse_changes(options.set or [])
        env = options.env or "rss_gym/Encounter-v0"
        difference = convert.export_model(
            options.source, options.out, env, options.algorithm, world, statistics=options.statistics
        )
    print(f"greatest difference from SB3's actions on 1,000 observations: {difference:.2g}")
    print(f"policy: {options.out}")
