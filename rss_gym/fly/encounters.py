"""Which encounters of a suite a page offers: mostly those in which flying on would be dangerous, of all families."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rss_gym.baselines.policy import Nothing
from rss_gym.eval.episodes import Block, fly_all
from rss_gym.eval.suites import Suite

SEARCHED = 600  # first encounters of the suite
HARMLESS = 4  # every so many one that needs no manoeuvre: otherwise one would learn to dodge without looking


@dataclass(frozen=True)
class Encounter:
    """One encounter of a suite: its number, and the family of its first intruder."""

    number: int
    family: str


def choose(suite: Suite, count: int, searched: int = SEARCHED) -> list[Encounter]:
    """The page's encounters, in the order in which it offers them.

    Of the first encounters of the suite, flown by nobody: those that come to an sNMAC, one of each family in turn, and
    every fourth one that does not.

    Parameters
    ----------
    suite : Suite
    count : int
        How many, at most.
    searched : int
        How many of the suite's encounters are looked at.
    """
    table = fly_all(Nothing(params=suite.params), "none", suite.params, Block(suite.split, suite.seed, range(searched)))
    dangerous, harmless = _in_turn(table[table["snmac"]]), _in_turn(table[~table["snmac"]])
    chosen: list[int] = []
    while len(chosen) < count and (dangerous or harmless):
        source = harmless if len(chosen) % HARMLESS == HARMLESS - 1 or not dangerous else dangerous
        chosen.append((source or dangerous).pop(0))
    families = dict(zip(table["episode"].tolist(), table["family"].tolist(), strict=True))
    return [Encounter(number, suite.families[families[number]]) for number in chosen]


def _in_turn(rows: np.ndarray) -> list[int]:
    """Numbers of the encounters of a table, one of each family after the other."""
    place = {int(family): 0 for family in np.unique(rows["family"])}
    order = []
    for number, family in zip(rows["episode"].tolist(), rows["family"].tolist(), strict=True):
        order.append((place[family], family, number))
        place[family] += 1
    return [number for _, _, number in sorted(order)]
