"""`rss-gym study`: fly what the documentation claims, and print it beside its criteria."""

from __future__ import annotations

import argparse

from rss_gym.commands.shared import add_workers, count

HELP = "fly what the documentation claims, and print it beside its criteria"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("name", metavar="NAME", help="world: whether the radio decides, nothing wins blind, RL learns")
    parser.add_argument(
        "--episodes",
        type=count,
        default=20_000,
        metavar="N",
        help="encounters of a row, unless its section says more (default: 20,000)",
    )
    parser.add_argument(
        "--decisions", type=count, default=3_000_000, metavar="N", help="length of each training (default: 3,000,000)"
    )
    parser.add_argument("--seeds", type=count, default=5, metavar="N", help="number of trainings (default: 5)")
    add_workers(parser, default=2)
    parser.add_argument("--out", metavar="FILE", help="write the page as Markdown too")


def run(options: argparse.Namespace) -> None:
    """Fly the study's sections and print each as soon as it is flown."""
    from rss_gym.eval import studies
    from rss_gym.files import write_text
    from rss_gym.params import ParamsError, suggestion

    if options.name not in studies.STUDIES:
        raise ParamsError(f"study {options.name!r} is unknown{suggestion(options.name, studies.STUDIES)}")
    scale = studies.Scale(options.episodes, options.workers, options.decisions, options.seeds)
    sections = []
    for section in studies.STUDIES[options.name](scale):
        print(section.text, flush=True)
        sections.append(section)
        if options.out:  # after each: an interrupted study keeps what it has flown
            write_text(options.out, studies.page(options.name, sections))
    missed = [str(criterion) for section in sections for criterion in section.criteria if not criterion.met]
    print(f"{sum(len(section.criteria) for section in sections) - len(missed)} criteria met, {len(missed)} missed")
