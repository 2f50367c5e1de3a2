"""`rss-gym study`: fly what the documents claim and show, and write their pages."""

from __future__ import annotations

import argparse

KEPT = "the page has what was flown before, if it was asked for"
HELP = "fly again what the documents claim, and write their tables and figures"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "name", metavar="NAME", help="study: world, opponents, learning, roads, paper, calibration or readme"
    )
    parser.add_argument(
        "arguments", nargs=argparse.REMAINDER, metavar="...", help="options of the study; see rss-gym study NAME --help"
    )


def run(options: argparse.Namespace) -> None:
    """Run the study, which reads its own options."""
    from rss_gym.eval import studies

    studies.run(options.name, options.arguments)
