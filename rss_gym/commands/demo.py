"""`rss-gym demo`: the paper's rule beside other rules and learned agents, on two channels."""

from __future__ import annotations

import argparse
import itertools
import os

from rss_gym.commands.shared import add_out, add_workers, count

HELP = "fly the rule of the paper at several radii beside other rules and learned agents, on two channels"
EPISODES = 10_000


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "--episodes",
        type=count,
        default=EPISODES,
        metavar="N",
        help=f"encounters that each policy flies (default: {EPISODES:,})",
    )
    add_workers(parser, default=2)
    add_out(parser, "DIR", "new folder (default: runs/demo, or the next free number)", required=False)


def run(options: argparse.Namespace) -> None:
    """Fly, write the page and print its place."""
    from rss_gym import demo

    print(f"report: {demo.run(options.out or _unused('runs/demo'), options.episodes, options.workers)}")


def _unused(stem: str) -> str:
    """`stem`, or the first of stem-2, stem-3, ... that does not exist."""
    names = itertools.chain([stem], (f"{stem}-{number}" for number in itertools.count(2)))
    return next(name for name in names if not os.path.exists(name))
