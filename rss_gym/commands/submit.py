"""`rss-gym submit`: make, check and pack an entry for a board."""

from __future__ import annotations

import argparse

from rss_gym.commands.shared import count

HELP = "make, check and pack an entry for a board"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the actions and their options."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION", help="each has its own --help")
    init = actions.add_parser("init", help="write the folder of an entry")
    init.add_argument("folder", metavar="DIR", help="new folder for the entry")
    init.add_argument(
        "--policy", required=True, metavar="NAME|DIR", help="folder of a learned policy or its run, or a policy's name"
    )
    init.add_argument("--name", default="my-agent", help="name of the entry (default: my-agent)")
    init.add_argument("--author", default="your name", help="author of the entry")
    init.add_argument("--link", default="https://example.org/my-agent", metavar="URL", help="address of the code")
    init.add_argument("--suite", default="encounter-v0", help="suite to be scored on, or all (default: encounter-v0)")
    check = actions.add_parser("check", help="check and fly the entry as the board does, without the sealed encounters")
    check.add_argument("folder", metavar="DIR", help="folder of the entry")
    check.add_argument("--episodes", type=count, metavar="N", help="public encounters of each suite (default: 200)")
    pack = actions.add_parser("pack", help="write the entry as one file")
    pack.add_argument("folder", metavar="DIR", help="folder of the entry")
    pack.add_argument("--to", metavar="FILE", help="file to write (default: DIR.zip)")


def run(options: argparse.Namespace) -> None:
    """Carry the action out and print what comes of it."""
    import os

    from rss_gym.eval.board import submit
    from rss_gym.eval.board.entry import ENTRY
    from rss_gym.eval.board.pack import PACKED, pack

    if options.action == "init":
        fields = {name: getattr(options, name) for name in ("name", "author", "link", "suite")}
        folder = submit.init(options.folder, options.policy, **fields)
        print(f"entry: {folder / ENTRY}; change what is in it, then run rss-gym submit check {options.folder}")
    elif options.action == "check":
        submit.check(options.folder, options.episodes or submit.EPISODES)
        print("checked: the board would fly it")
    else:
        print(f"packed: {pack(options.folder, options.to or os.fspath(options.folder).rstrip(os.sep) + PACKED)}")
