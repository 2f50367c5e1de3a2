"""`rss-gym board`: seasons, flights, breaks and pages of a board that others enter."""

from __future__ import annotations

import argparse

from rss_gym.commands.shared import add_out, add_workers, count

HELP = "run a board that others enter: open seasons, fly entries, write pages"
KEPT = "what was flown so far is kept, and the same command goes on from there"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the actions and their options."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION", help="each has its own --help")
    new = actions.add_parser(
        "new", help="open a season: draw the secret behind its sealed seeds, and publish the hash of the secret"
    )
    new.add_argument("season", metavar="FILE", help="new file, such as season-1.json")
    new.add_argument("--name", required=True, help="name of the season, such as 2026-1")
    new.add_argument("--suites", nargs="+", required=True, metavar="NAME[:N]", help="suites to fly; N: how often")
    new.add_argument(
        "--public", type=count, default=10_000, metavar="N", help="public encounters of each suite (default: 10000)"
    )
    new.add_argument(
        "--sealed", type=count, default=10_000, metavar="N", help="sealed encounters of each suite (default: 10000)"
    )
    close = actions.add_parser("close", help="close a season: publish its secret")
    close.add_argument("season", metavar="FILE", help="file of the season")
    fly = actions.add_parser("fly", help="fly all entries, and append a signed line for each")
    fly.add_argument(
        "entries", nargs="?", metavar="ENTRIES", help="folder of entries (default: only the policies of the package)"
    )
    fly.add_argument("--season", required=True, metavar="FILE", help="file of the season")
    fly.add_argument("--board", required=True, metavar="DIR", help="folder that holds board.jsonl")
    fly.add_argument("--entries-only", action="store_true", help="leave out the policies of the package")
    add_workers(fly)
    broken = actions.add_parser("break", help="fly encounters that were sent against an entry")
    broken.add_argument(
        "file", metavar="FILE", help="encounters to fly; the page How to enter says what the file holds"
    )
    broken.add_argument("--season", required=True, metavar="FILE", help="file of the season")
    broken.add_argument("--board", required=True, metavar="DIR", help="folder that holds board.jsonl")
    check = actions.add_parser("check", help="check the order and the signatures of a board's lines")
    check.add_argument("board", metavar="DIR", help="folder that holds board.jsonl")
    check.add_argument("--key", metavar="HEX", help="public key that must have signed (default: that of line 1)")
    site = actions.add_parser("site", help="write the pages of the board")
    site.add_argument("board", metavar="DIR", help="folder that holds board.jsonl")
    site.add_argument(
        "--season", required=True, nargs="+", metavar="FILE", help="files of the seasons, the newest first"
    )
    site.add_argument(
        "--replays", type=count, default=2, metavar="N", help="worst encounters of each row to fly again (default: 2)"
    )
    add_out(site, "SITE", "new folder for the pages")


def run(options: argparse.Namespace) -> int:
    """Carry the action out; 3 where entries were refused."""
    from rss_gym.eval.board import breaks, chain, season, site
    from rss_gym.eval.board import fly as flights

    if options.action == "new":
        made = season.new(options.season, options.name, options.suites, options.public, options.sealed)
        print(f"season {made.name}: commitment {made.commitment}; keep {options.season}{season.SECRET} to yourself")
    elif options.action == "close":
        closed = season.close(options.season)
        print(f"season {closed.name} is closed; its secret is {closed.secret}")
        for one in closed.suites:
            print(f"{one.name}: sealed seed {season.sealed_seed(str(closed.secret), one.name)}")
    elif options.action == "fly":
        done = flights.fly(
            options.entries,
            options.season,
            options.board,
            options.workers,
            references=not options.entries_only,
            say=lambda sentence: print(sentence, flush=True),
        )
        for why in done.refused:
            print(f"refused: {why}")
        print(f"board: {len(done.appended)} lines appended to {done.before}")
        return 3 if done.refused else 0
    elif options.action == "break":
        line = breaks.fly(options.file, options.season, options.board)
        cost = line["cost_m"]["value"]
        print(f"{line['entry']} on {line['suite']}: cost {cost:.4g} m; " + (
            "worse than its row, and listed" if line["worse"] else "not worse than its row, and not listed"
        ))  # fmt: skip
    elif options.action == "check":
        lines = chain.read(f"{options.board}/{chain.BOARD}", options.key)
        print(f"{len(lines)} lines follow each other; the last is {chain.head(f'{options.board}/{chain.BOARD}')}")
    else:
        print(f"pages: {site.build(options.board, options.season, options.out, options.replays)}")
    return 0
