"""The command `rss-gym`: reads the options, runs the command, and turns errors into one sentence and an exit status."""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Iterator, Sequence
from typing import Any, NoReturn

import rss_gym
from rss_gym.commands import COMMANDS, load
from rss_gym.params import ParamsError, suggestion
from rss_gym.terminal import Terminated, guarded, of_machine, say


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Returns
    -------
    int
        0; 1 where the work failed or could not be printed, 2 for bad input, 130 after Ctrl-C, 143 after SIGTERM.
    """
    given = sys.argv[1:] if arguments is None else list(arguments)
    with guarded() as output:
        status = _run(given)
    if output.error is not None:
        reason = getattr(output.error, "strerror", None) or output.error
        say(f"the output could not be printed ({reason}); what the command writes to files is not concerned")
        return status or 1
    return status


def _run(given: list[str]) -> int:
    kept = "nothing was written"
    try:
        options = parser().parse_args(_asked(given), argparse.Namespace(given=given))
        kept = options.kept
        with _results(options):
            return int(options.run(options) or 0)
    except ParamsError as error:
        say(str(error))
        return 2
    except Terminated:
        say(f"ended by SIGTERM; {kept}")
        return 143
    except KeyboardInterrupt:
        say(f"interrupted; {kept}")
        return 130
    except Exception as error:
        from rss_gym.core import NotFiniteError
        from rss_gym.eval.episodes import PolicyError

        sentence = str(error) if isinstance(error, (NotFiniteError, PolicyError)) else of_machine(error)
        if sentence is None:
            raise
        say(sentence)
        return 1


@contextlib.contextmanager
def _results(options: argparse.Namespace) -> Iterator[None]:
    """Hold the folder of the results, in place of an older one if that was asked for."""
    from rss_gym.files import overwritten, reserved

    name = getattr(options, "results", None)
    out = getattr(options, name) if name else None
    with contextlib.ExitStack() as stack:
        if out is not None and options.overwrite:
            stack.enter_context(overwritten(out))
        if out is not None and options.hold:
            stack.enter_context(reserved(out))
        yield


def _asked(given: list[str]) -> list[str]:
    """The arguments with `help` for `--help`; a command that does not exist is refused with the nearest one."""
    if not given or given == ["help"]:
        return ["--help"]
    command, *rest = given
    if command == "help":
        command, rest = rest[0], ["--help"]
    if command not in COMMANDS and not command.startswith("-"):
        raise ParamsError(f"command {command!r} is unknown{suggestion(command, COMMANDS)}")
    return [command, *rest]


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one sentence, with the nearest option that exists."""

    given: Sequence[str] = ()

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse does; an argument that is left over is named."""
        options, left = self.parse_known_args(args, namespace)
        if left:
            name = left[0].partition("=")[0]
            known = [option for option in self.options_of(options.command) if option.startswith("--")]
            if not name.startswith("-"):
                self.error(f"{options.command} takes no argument {name!r} here; see rss-gym {options.command} --help")
            self.error(f"{options.command} has no option {name!r}{suggestion(name, known)}")
        return options

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse does; what was given is kept for its errors."""
        self.given = list(args or ())
        return super().parse_known_args(args, namespace)

    def options_of(self, command: str) -> list[str]:
        """The names of the options of a command."""
        commands = next(a for a in self._actions if isinstance(a, argparse._SubParsersAction))
        return list(commands.choices[command]._option_string_actions)

    def error(self, message: str) -> NoReturn:
        """Refuse the arguments; a mistyped option comes before one that is missing."""
        known = [name for name in self._option_string_actions if name.startswith("--")]
        names = [item.partition("=")[0] for item in self.given if item.startswith("--")]
        wrong = next((name for name in names if not any(option.startswith(name) for option in known)), None)
        if "are required" in message and wrong is not None and self.prog != "rss-gym":
            message = f"no option {wrong!r}{suggestion(wrong, known)}"
        raise ParamsError(message if self.prog == "rss-gym" else f"{self.prog.removeprefix('rss-gym ')}: {message}")


def parser() -> Parser:
    """The parser of the command line; loads nothing heavy."""
    whole = Parser(
        prog="rss-gym",
        description="UAV collision avoidance with ranges from radio signal strength.",
        epilog="rss-gym help COMMAND describes a command and its options.",
    )
    whole.add_argument(
        "--version", action="version", version=f"rss-gym {rss_gym.__version__}", help="print the version"
    )
    commands = whole.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name in COMMANDS:
        command = load(name)
        part = commands.add_parser(name, help=command.HELP, description=f"{command.HELP[0].upper()}{command.HELP[1:]}.")
        command.add(part)
        part.set_defaults(run=command.run, kept=getattr(command, "KEPT", "nothing was written"))
    return whole
