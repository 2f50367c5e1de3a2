"""`rss-gym leaderboard`: one page of ranked tables from several records."""

from __future__ import annotations

import argparse

from rss_gym.commands.shared import add_out

HELP = "make one page of ranked tables from several records"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("folders", nargs="+", metavar="DIR", help="folders with scores.json")
    add_out(parser, "SITE", "new folder for index.html and the records")


def run(options: argparse.Namespace) -> None:
    """Write the page and print its place."""
    from rss_gym.eval import leaderboard

    site = leaderboard.build(options.folders, options.out)
    for note in site.notes:
        print(note)
    for why in site.quarantined:
        print(f"set aside: {why}")
    print(f"leaderboard: {site.page}")
