"""`rss-gym page`: pages for a browser that are no record of a run."""

from __future__ import annotations

import argparse
import os

from rss_gym.commands.shared import count

HELP = "write the page on which a person flies against a shipped agent"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("page", choices=["fly"], help="fly: a person flies the agent's part with the arrow keys")
    parser.add_argument("--out", required=True, metavar="FILE", help="new HTML file for the page")
    parser.add_argument("--overwrite", action="store_true", help="replace an older file of that name")
    parser.add_argument(
        "--agent",
        default="pathwise-plane",
        metavar="NAME",
        help="shipped agent to fly against (default: pathwise-plane)",
    )
    parser.add_argument(
        "--suite", default="encounter-v0", metavar="SUITE", help="planar suite to fly (default: encounter-v0)"
    )
    parser.add_argument(
        "--encounters", type=count, default=40, metavar="N", help="number of encounters on the page (default: 40)"
    )


def run(options: argparse.Namespace) -> None:
    """Write the page.

    Raises
    ------
    ParamsError
        For an unknown name, a suite that a page cannot fly, or a file that is there already.
    """
    from pathlib import Path

    from rss_gym.files import write_text
    from rss_gym.fly import build
    from rss_gym.params import ParamsError

    if os.path.exists(options.out) and not options.overwrite:
        raise ParamsError(f"--out {options.out!r} exists already; give another name or --overwrite")
    write_text(Path(options.out), build(options.suite, options.agent, options.encounters))
    print(f"page: {options.out}")
