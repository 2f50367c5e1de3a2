"""The command `rss-gym`: reads the options, runs the command, and turns errors into one sentence and an exit status."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from rss_gym.commands import COMMANDS, load


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns the exit status, 2 for bad input."""
    given = sys.argv[1:] if arguments is None else list(arguments)
    options = parser().parse_args(given, argparse.Namespace(given=given))
    from rss_gym.params import ParamsError

    try:
        status = options.run(options)
    except ParamsError as error:
        print(f"rss-gym: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("rss-gym: interrupted; nothing was written", file=sys.stderr)
        return 130
    except Exception as error:
        from rss_gym.core import NotFiniteError
        from rss_gym.eval.episodes import PolicyError

        if not isinstance(error, (NotFiniteError, PolicyError)):
            raise
        print(f"rss-gym: {error}", file=sys.stderr)
        return 1
    return int(status or 0)


def parser() -> argparse.ArgumentParser:
    """The parser of the command line; loads nothing heavy."""
    whole = argparse.ArgumentParser(
        prog="rss-gym", description="UAV collision avoidance with ranges from radio signal strength."
    )
    commands = whole.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name in COMMANDS:
        command = load(name)
        part = commands.add_parser(name, help=command.HELP)
        command.add(part)
        part.set_defaults(run=command.run)
    return whole
