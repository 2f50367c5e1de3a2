"""Options that several commands have."""

from __future__ import annotations

import argparse
import os
import sys

from rss_gym.arguments import count

__all__ = ["add_channel", "add_out", "add_workers", "count", "see_modules_here"]


def add_out(
    parser: argparse.ArgumentParser,
    metavar: str,
    text: str,
    required: bool = True,
    name: str = "out",
    hold: bool = True,
) -> None:
    """The option of the folder for the results, `--out` or another name, and `--overwrite`.

    The command line holds the folder while the command runs, unless `hold` is false.
    """
    parser.add_argument(f"--{name}", required=required, metavar=metavar, help=text)
    parser.add_argument("--overwrite", action="store_true", help="replace an older folder of that name")
    parser.set_defaults(results=name, hold=hold)


def add_channel(parser: argparse.ArgumentParser) -> None:
    """The option `--channel`."""
    parser.add_argument(
        "--channel",
        nargs="+",
        action="extend",
        metavar="PRESET|FILE",
        help="channel of the radio, or several, of which one is drawn for each encounter",
    )


def add_workers(parser: argparse.ArgumentParser, text: str | None = None, default: int = 1) -> None:
    """The option `--workers`."""
    parser.add_argument(
        "--workers",
        type=count,
        default=default,
        metavar="N",
        help=text or f"processes that share the work (default: {default})",
    )


def see_modules_here() -> None:
    """Let `module:attribute` name a module of the working folder; an installed command does not look there."""
    here = os.getcwd()
    if here not in sys.path:
        sys.path.append(here)
