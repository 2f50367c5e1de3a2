"""The numbers of the paper beside what comes out: docs/paper.md and the README's summary (a minute or two)."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from rss_gym.eval import paper
from rss_gym.eval.paper import page
from rss_gym.eval.records import versions
from rss_gym.eval.studies.study import Part


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """How much is run."""
    parser.add_argument("--quick", action="store_true", help="fewer repetitions: wider intervals, in some seconds")


def run(options: argparse.Namespace) -> Iterator[Part]:
    """The reproduction."""
    result = paper.reproduce(paper.QUICK if options.quick else None)
    used = ", ".join(f"{name} {number}" for name, number in versions().items())
    made = f"Seed {result.study.seed}; made by `rss-gym study paper` with {used}."
    yield Part(f"{result.summary}\n\n{page.markdown(result.numbers)}\n\n{made}", "docs/paper.md", mark="paper")
    yield Part(result.summary, "README.md", mark="paper")
