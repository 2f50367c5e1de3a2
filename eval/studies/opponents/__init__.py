"""The policies on the same encounters: docs/opponents.md with its chart, and the README's table.

It takes half an hour on two cores. Each job is a record of its own in the folder of runs, so that an interrupted run
goes on where it stopped.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from rss_gym.arguments import count
from rss_gym.eval.studies.opponents import page
from rss_gym.eval.studies.opponents.jobs import AGENTS, RADII, SUITE, agents, families, planned
from rss_gym.eval.studies.study import Part, fly, made, read

PAGE, CHART = "docs/opponents.md", "docs/opponents.svg"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """How much is flown, and which tables."""
    parser.add_argument("--shrink", type=count, default=1, metavar="N", help="N times fewer encounters, for a test")
    parser.add_argument("--readme", action="store_true", help="fly and write the README's table alone (some minutes)")


def run(options: argparse.Namespace) -> Iterator[Part]:
    """Fly what is missing; the README's table, then the page and its chart."""
    todo = [job for job in planned(options.shrink) if not options.readme or job.name.startswith("readme")]
    flown = fly(todo, options.workers, options.runs)
    table = f"{page.short(of(flown, 'readme'))}\n\n{made('opponents', todo[0].episodes)}"
    yield Part(table, "README.md", mark="scores")
    if not options.readme:
        yield Part(tables(flown), PAGE, mark="tables")
        yield Part(f"chart: {CHART}", CHART, chart(flown))


def of(flown: dict[str, Path], name: str) -> list[Path]:
    """The records of a job and of the agents over its encounters."""
    return [folder for job, folder in flown.items() if job in (name, f"{name}{AGENTS}")]


def tables(flown: dict[str, Path]) -> str:
    """The tables of docs/opponents.md."""
    text = [f"## Information `{level}`\n\n{page.ranked(of(flown, level))}" for level in RADII]
    text.append(f"## In space, information `positions`\n\n{page.ranked(of(flown, 'space'))}")
    rows = {name: read(of(flown, name)) for name in families()}
    text.append(f"## Cost by family, information `positions`\n\n{page.by_family(rows)}")
    return "\n\n".join([*text, made("opponents")])


def chart(flown: dict[str, Path]) -> str:
    """The curves of the rules over their radii, and the agents as points."""
    found = {level: read(of(flown, level)) for level in RADII}
    curves = {
        level: {
            rule: [found[level][f"{rule}:radius_m={radius:g}"] for radius in radii]
            for rule, radii in RADII[level].items()
        }
        for level in RADII
    }
    single = {level: [found[level][name] for name in agents(SUITE, information=level)] for level in RADII}
    return page.chart(curves, {level: found[level]["none"] for level in RADII}, single)
