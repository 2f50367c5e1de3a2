"""What the recipes learn, what helps them, and what each part is worth; docs/learning.md with its chart.

Each training is a run of its own in the folder of runs, so that an interrupted study goes on where it stopped.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping

from rss_gym.arguments import count
from rss_gym.eval.studies.section import Section
from rss_gym.eval.studies.study import Part
from rss_gym.train.study import ablations, curves, radios
from rss_gym.train.study.training import Trainer

PAGE, CHART = "docs/learning.md", "docs/learning.svg"
SECTIONS = {
    "curves": curves.section,
    "changes": ablations.changes,
    "rare": ablations.rare,
    "ablations": ablations.ablations,
    "radios": radios.section,
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """How much is trained, and which sections."""
    parser.add_argument("--seeds", type=count, default=5, metavar="N", help="trainings of a recipe (default: 5)")
    parser.add_argument("--episodes", type=count, default=10_000, metavar="N", help="encounters of a row")
    parser.add_argument("--shrink", type=count, default=1, metavar="N", help="N times fewer decisions, for a test")
    parser.add_argument("--sections", nargs="+", choices=SECTIONS, default=list(SECTIONS), help="which (default: all)")


def run(options: argparse.Namespace) -> Iterator[Part]:
    """A part a section."""
    trainer = Trainer(options.runs, options.workers, options.seeds, options.episodes, options.shrink)
    found: dict[str, Section] = {}
    for name in options.sections:
        found[name] = SECTIONS[name](trainer)
        yield Part(found[name].text, PAGE, page(found))
        if name == "curves":
            yield Part(f"chart: {CHART}", CHART, curves.chart(trainer))


def page(found: Mapping[str, Section]) -> str:
    """The sections by their names as a page of Markdown."""
    chart = ["![Cost over the CPU seconds of each training](learning.svg)", ""] if "curves" in found else []
    head = [
        "# Study: learning",
        "",
        f"Made by `rss-gym study learning --sections {' '.join(found)} --pages .`, which trains and flies it all anew. "
        "CPU seconds are those of a training's process, with imitation and without validations.",
        "",
    ]
    return "\n".join([*head, *chart, *(section.markdown for section in found.values())])
