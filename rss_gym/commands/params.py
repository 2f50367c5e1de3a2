"""`rss-gym params`: every parameter of the world."""

from __future__ import annotations

import argparse
import json

HELP = "list every parameter of the world with its default, unit, range and meaning"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "filter",
        nargs="?",
        default="",
        metavar="FILTER",
        help="list only parameters with this text in their name, group or meaning",
    )
    parser.add_argument("--json", action="store_true", help="print the parameters as JSON")


def run(options: argparse.Namespace) -> None:
    """Print the table.

    Raises
    ------
    ParamsError
        If no parameter has the text, with the nearest name.
    """
    from rss_gym.listing import parameters
    from rss_gym.meanings import MEANINGS
    from rss_gym.pages.table import Table
    from rss_gym.params import ParamsError, suggestion

    rows = parameters(options.filter)
    if not rows:
        raise ParamsError(f"no parameter has {options.filter!r} in it{suggestion(options.filter, MEANINGS)}")
    if options.json:
        print(json.dumps(rows, indent=1))
        return
    group = ""
    keys = ("name", "default", "unit", "range", "meaning")
    lines = Table([""] * len(keys), ([_shown(row[key]) for key in keys] for row in rows)).lines(header=False)
    for row, line in zip(rows, lines, strict=True):
        if row["group"] != group:
            group = row["group"]
            print(f"{group}: (keys of a channel)" if group == "channel" else f"{group}:")
        print(f"  {line}")


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, (int, float)) else str(value)
