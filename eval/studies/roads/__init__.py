"""Drivers on roads: the tables and the picture of docs/roads.md (a quarter of an hour on two cores)."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path

from rss_gym.arguments import count
from rss_gym.eval.columns import ROAD
from rss_gym.eval.evaluate import ALL
from rss_gym.eval.policies import folder_name
from rss_gym.eval.studies.roads.learned import driver, section
from rss_gym.eval.studies.study import Job, Part, fly, made, read
from rss_gym.pages.table import Table

SUITE = "highway-v0"
COLUMNS = {name: column for name, column in ROAD.items() if column.interval}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What is driven, and how often."""
    parser.add_argument("--policy", nargs="+", default=[ALL], metavar="NAME", help="what to drive, agents' folders too")
    parser.add_argument("--episodes", type=count, default=1000, metavar="N", help="drives of each (default: 1000)")
    parser.add_argument(
        "--record", type=Path, metavar="DIR", help="a record of `rss-gym eval --suite highway-v0`, in place of driving"
    )
    parser.add_argument(
        "--learned",
        nargs="+",
        metavar="DIR",
        help="compare drivers learned on roads with the rule, and nothing else",
    )


def run(options: argparse.Namespace) -> Iterator[Part]:
    """The picture, then the table; or learned drivers beside the rule."""
    from rss_gym.eval.studies.roads.picture import picture

    if options.learned:
        yield Part(learned(options.learned, options.episodes), "docs/roads.md", mark="learned")
        return
    yield Part("picture: docs/highway.png", "docs/highway.png", picture())
    record = options.record
    if record is None:
        job = Job("roads", SUITE, tuple(options.policy), options.episodes)
        record = fly([job], options.workers, options.runs)[job.name]
    yield Part(drivers(record), "docs/roads.md", mark="road")


def learned(folders: Sequence[str], episodes: int) -> str:
    """A section for each road on which one of the drivers was trained."""
    found = [driver(folder) for folder in folders]
    sections = [
        section(road, [each for each in found if each.road == road], episodes)
        for road in dict.fromkeys(each.road for each in found)
    ]
    shown = "\n".join(part.markdown.replace("## ", "### ", 1) for part in sections)
    return f"{shown}\n{made('roads --learned', None, 'highway-env')}"


def drivers(record: Path) -> str:
    """The rows of a record in Markdown, the cheapest first."""
    rows = []
    for row in sorted(read([record]).values(), key=lambda row: row.metrics["cost_m"].value or 0.0):
        name = folder_name(row.spec) if "/" in row.spec else row.spec
        rows.append([f"`{name}`", str(row.episodes), *(row.metrics[metric] for metric in COLUMNS)])
    return f"{Table(['policy', 'episodes', *COLUMNS.values()], rows).markdown}\n\n{made('roads', None, 'highway-env')}"
