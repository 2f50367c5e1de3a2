"""The commands of `rss-gym`, one file each.

A module defines `HELP`, one line; `add(parser)`, which declares its options; and `run(options)`, which carries the
command out and returns its exit status (None is 0); where an interrupted command has written something, `KEPT` says
what. What is heavy is imported in `run`, so that `rss-gym --help` answers at once.
"""

from __future__ import annotations

import argparse
import importlib
from typing import Protocol

# Name of the command -> module in this package, in the order of the help.
COMMANDS: dict[str, str] = {
    "list": "listing",
    "params": "params",
    "eval": "eval",
    "report": "report",
    "verify": "verify",
    "leaderboard": "leaderboard",
    "record": "record",
    "watch": "watch",
    "submit": "submit",
    "board": "board",
    "train": "train",
    "export": "export",
    "calibrate": "calibrate",
    "simulate-log": "simulate_log",
    "paper": "paper",
    "study": "study",
    "page": "page",
    "demo": "demo",
    "warm": "warm",
}


class Command(Protocol):
    """What a module of `COMMANDS` defines."""

    HELP: str

    def add(self, parser: argparse.ArgumentParser) -> None:
        """Declare the options."""

    def run(self, options: argparse.Namespace) -> int | None:
        """Carry the command out; returns the exit status, None for 0."""


def load(name: str) -> Command:
    """The module of the command `name`."""
    module: Command = importlib.import_module(f"{__name__}.{COMMANDS[name]}")
    return module
