"""`rss-gym list`: what there is to choose from."""

from __future__ import annotations

import argparse
import json

HELP = "list the ids, policies, channel presets, estimators, trackers, families, recipes and suites"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("--json", action="store_true", help="print the lists as JSON")


def run(options: argparse.Namespace) -> None:
    """Print the lists."""
    from rss_gym.listing import listing
    from rss_gym.pages.table import Table

    content = listing()
    if options.json:
        print(json.dumps(content, indent=1))
        return
    for title, rows in content.items():
        print(f"{title}:")
        for line in Table(["", ""], rows.items()).lines(header=False):
            print(f"  {line}")
