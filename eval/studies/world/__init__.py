"""What the world promises, measured: the radio, estimators, trackers, blind flight, leaks, the reward, learning."""

from __future__ import annotations

from collections.abc import Iterator

from rss_gym.eval.studies.section import Scale, Section
from rss_gym.eval.studies.world import blind, families, leak, learning, nodes, order, radio, sensor


def run(scale: Scale) -> Iterator[Section]:
    """The sections one after another, each when it has been flown."""
    yield radio.section()
    yield from sensor.sections(scale)
    yield families.section(scale)
    yield nodes.section(scale)
    yield blind.section(scale)
    yield leak.section(scale)
    yield order.section(scale)
    yield learning.section(scale)
