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
    from rss_gym.params import ParamsError, suggestion

    rows = parameters(options.filter)
    if not rows:
        raise ParamsError(f"no parameter has {options.filter!r} in it{suggestion(options.filter, MEANINGS)}")
    if options.json:
        print(json.dumps(rows, indent=1))
        return
    group = ""
    widths = [max(len(_shown(row[key])) for row in rows) for key in ("name", "default", "unit", "range")]
    for row in rows:
        if row["group"] != group:
            group = row["group"]
            print(f"{group}: (keys of a channel)" if group == "channel" else f"{group}:")
        cells = [_shown(row[key]) for key in ("name", "default", "unit", "range")]
        print("  " + "  ".join(f"{cell:<{width}}" for cell, width in zip(cells, widths, strict=True)), row["meaning"])


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, (int, float)) else str(value)
