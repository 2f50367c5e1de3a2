"""`rss-gym report`: draw the page of a saved record again."""

from __future__ import annotations

import argparse

HELP = "draw the page of a saved record again, from its files alone"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("folders", nargs="+", metavar="DIR", help="folders with scores.json; each gets its report.html")


def run(options: argparse.Namespace) -> None:
    """Write the pages and print their places."""
    from rss_gym.eval.redraw import redraw

    for folder in options.folders:
        print(f"report: {redraw(folder)}")
