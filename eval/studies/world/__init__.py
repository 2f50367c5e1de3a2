"""What the world promises, measured: the radio, estimators, trackers, blind flight, leaks, the reward, learning."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence

from rss_gym.arguments import count
from rss_gym.eval.studies.section import Scale, Section
from rss_gym.eval.studies.study import Part
from rss_gym.eval.studies.world import blind, families, leak, learning, nodes, order, radio, sensor

PAGE = "docs/world.md"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """How much is flown and trained."""
    parser.add_argument(
        "--episodes",
        type=count,
        default=20_000,
        metavar="N",
        help="encounters of a row of the tables, unless its section says otherwise",
    )
    parser.add_argument("--decisions", type=count, default=3_000_000, metavar="N", help="decisions of each training")
    parser.add_argument("--seeds", type=count, default=5, metavar="N", help="number of trainings")


def run(options: argparse.Namespace) -> Iterator[Part]:
    """A part a section, and how many criteria are met."""
    found: list[Section] = []
    for section in sections(Scale(options.episodes, options.workers, options.decisions, options.seeds)):
        found.append(section)
        yield Part(section.text, PAGE, page(found))
    criteria = [criterion for section in found for criterion in section.criteria]
    met = sum(criterion.met for criterion in criteria)
    yield Part(f"{met} criteria met, {len(criteria) - met} missed")


def sections(scale: Scale) -> Iterator[Section]:
    """The sections one after another, each when it has been flown."""
    yield radio.section()
    yield from sensor.sections(scale)
    yield families.section(scale)
    yield nodes.section(scale)
    yield blind.section(scale)
    yield leak.section(scale)
    yield order.section(scale)
    yield learning.section(scale)


def page(found: Sequence[Section]) -> str:
    """The sections as a page of Markdown."""
    command = (
        "The claims behind the design of the world, measured. `rss-gym study world --pages .` flies all of it again "
        "and writes this page. Below each table are its criteria, each met or MISSED; one that is marked as an aim "
        "is wished for and not promised. [Concepts](concepts.md) explains the words."
    )
    return "\n".join(["# Study: world", "", command, "", *(section.markdown for section in found)])
