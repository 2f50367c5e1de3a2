"""`rss-gym paper`: every figure and number of the paper."""

from __future__ import annotations

import argparse

from rss_gym.commands.shared import add_out

HELP = "compute every figure and number of the paper, and compare them with what it states"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_out(parser, "DIR", "new folder for paper.json and index.html")
    parser.add_argument("--seed", type=int, default=0, help="seed of everything that is drawn (default: 0)")
    parser.add_argument("--quick", action="store_true", help="fewer repetitions: wider intervals, in some seconds")


def run(options: argparse.Namespace) -> None:
    """Compute, write the page and print the summary."""
    from rss_gym.eval import paper
    from rss_gym.files import check_new, save_or_keep

    check_new(options.out)
    reproduction = paper.reproduce(paper.QUICK if options.quick else None, options.seed)
    folder = save_or_keep(lambda out: paper.write(reproduction, out), options.out)
    print(reproduction.summary)
    print(f"numbers: {folder / paper.NUMBERS}")
    print(f"page: {folder / paper.PAGE}")
