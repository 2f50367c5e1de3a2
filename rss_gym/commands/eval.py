"""`rss-gym eval`: score policies on the same encounters."""

from __future__ import annotations

import argparse
import json
import os
import sys
from typing import Any

from rss_gym.commands.shared import add_channel, add_out, add_workers, count, see_modules_here

HELP = "score policies on the same encounters"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "--policy",
        nargs="+",
        action="extend",
        required=True,
        metavar="NAME",
        help="policies, such as none orthogonal:radius_m=60; all flies every one that can fly there",
    )
    parser.add_argument(
        "--suite",
        default="encounter-v0",
        help="suite of rss-gym list; highway-v0 and others are roads (default: encounter-v0)",
    )
    parser.add_argument("--episodes", type=count, metavar="N", help="number of encounters (default: the suite's)")
    parser.add_argument("--seed", type=int, help="seed of the encounters (default: the suite's)")
    add_channel(parser)
    parser.add_argument(
        "--information",
        nargs="+",
        action="extend",
        metavar="LEVEL",
        help="level of information: oracle, positions or ranges; several make a folder each in DIR",
    )
    parser.add_argument(
        "--estimator", metavar="NAME", help="estimator of the range, such as ekf-coloured or ls; see rss-gym list"
    )
    parser.add_argument("--tracker", metavar="NAME", help="tracker of the intruders, such as fused; see rss-gym list")
    parser.add_argument(
        "--families", nargs="+", action="extend", metavar="NAME", help="draw from these families of encounters only"
    )
    add_workers(parser)
    parser.add_argument(
        "--reference",
        metavar="NAME",
        help="policy for metrics of the flights that both it and the policy of the row completed (default: the first)",
    )
    add_out(parser, "DIR", "new folder for scores and tables")
    parser.add_argument("--csv", action="store_true", help="write the tables as CSV too")
    parser.add_argument("--json", action="store_true", help="print scores.json instead of the table")


def run(options: argparse.Namespace) -> None:
    """Fly, save and print the table."""
    from rss_gym.eval import records, report, text
    from rss_gym.eval.evaluate import check
    from rss_gym.files import check_new, new_folder
    from rss_gym.params import ParamsError

    out = check_new(options.out)
    see_modules_here()
    names = ("channel", "estimator", "tracker", "families")
    changes: dict[str, Any] = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    levels = options.information or []
    twice = next((level for level in levels if levels.count(level) > 1), None)
    if twice is not None:
        raise ParamsError(f"information {twice!r} is given twice")
    if len(levels) < 2:
        results = {"": _flown(options, options.out, **changes, **({"information": levels[0]} if levels else {}))}
    else:
        for level in levels:  # before hours are flown on the first
            check(options.policy, options.suite, options.reference, **changes, information=level)
        with new_folder(out) as folder:
            results = {level: _flown(options, folder / level, **changes, information=level) for level in levels}
    if options.json:
        scores = {level: (out / level / records.SCORES).read_text(encoding="utf-8") for level in results}
        several = {level: json.loads(content) for level, content in scores.items()}
        print(json.dumps(several, indent=1) if len(levels) > 1 else scores[""].rstrip())
        return
    for level, result in results.items():
        print(text.table(result, colour=text.coloured(sys.stdout)))
        print(f"scores: {os.path.join(options.out, level, records.SCORES)}")
        print(f"report: {os.path.join(options.out, level, report.REPORT)}")


def _flown(options: argparse.Namespace, out: str | os.PathLike[str], **changes: Any) -> Any:
    """Fly and save one record."""
    from rss_gym.eval import evaluate, records, report
    from rss_gym.files import save_or_keep

    result = evaluate(
        options.policy,
        suite=options.suite,
        episodes=options.episodes,
        seed=options.seed,
        workers=options.workers,
        reference=options.reference,
        **changes,
    )
    save_or_keep(lambda folder: records.save(result, folder, options.csv, report.write), out)
    return result
