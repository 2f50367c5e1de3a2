"""`rss-gym verify`: recompute the metrics of a record and fly some of its episodes again."""

from __future__ import annotations

import argparse
import json

from rss_gym.commands.shared import add_workers, see_modules_here

HELP = "recompute a record's metrics and fly some of its flights again (exit 1: it differs, 3: incomplete)"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("folder", metavar="DIR", help="folder with scores.json")
    parser.add_argument(
        "--all",
        action="store_true",
        dest="every",
        help="fly all episodes and all kept flights again, not a sample of them",
    )
    parser.add_argument("--seed", type=int, help="seed of the sample of episodes (default: a new one each time)")
    parser.add_argument(
        "--trust", action="store_true", help="also run the code of policies that are given as module:attribute"
    )
    add_workers(parser)
    parser.add_argument("--json", action="store_true", help="print the verdict as JSON")


def run(options: argparse.Namespace) -> int:
    """Print the verdict; 0: verified, 1: something differs, 3: not checked, or a policy was not flown again."""
    from rss_gym.eval import verify
    from rss_gym.eval.episodes import WorkerError
    from rss_gym.terminal import say

    if options.trust:
        see_modules_here()
    try:
        verdict = verify.verify(
            options.folder, every=options.every, trust=options.trust, seed=options.seed, workers=options.workers
        )
    except WorkerError as error:
        say(f"the record could not be checked, which says nothing about it: {error}")
        return 3
    print(json.dumps(verdict.to_dict(), indent=1) if options.json else verify.report(verdict))
    return verify.OUTCOMES[verdict.outcome]
