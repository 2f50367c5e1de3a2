"""The worst public encounters of an entry, flown again beside `none`, and the page that plays them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from markupsafe import Markup

from rss_gym.eval.episodes import Block, PolicyError, fly_episodes
from rss_gym.eval.evaluate import NOMINAL
from rss_gym.eval.policies import entry
from rss_gym.eval.report import SCRIPTS, replay
from rss_gym.eval.report.flights import ReplayFlight
from rss_gym.eval.suites import Suite
from rss_gym.pages import page
from rss_gym.pages.page import Section


@dataclass(frozen=True)
class Case:
    """One encounter: its number, its row of the flights' table, and the flights of the entry and of `none`."""

    number: int
    row: np.void
    own: ReplayFlight
    beside: ReplayFlight


def cases(suite: Suite, spec: str, numbers: Sequence[int]) -> list[Case]:
    """Fly these encounters again; none of them if the policy fails in one."""
    try:
        return [_case(suite, spec, number) for number in numbers]
    except PolicyError:
        return []


def _case(suite: Suite, spec: str, number: int) -> Case:
    row, own = _flown(suite, spec, number)
    return Case(number, row, own, _flown(suite, NOMINAL, number)[1])


def _flown(suite: Suite, spec: str, number: int) -> tuple[np.void, ReplayFlight]:
    flight, built = ReplayFlight(), entry(spec, suite.params, "entry")
    block = Block(suite.split, suite.seed, [number])
    table, _ = fly_episodes(built.policy, "entry", built.params, block, watch=flight)
    return table[0], flight


def player(suite: Suite, name: str, found: Sequence[Case]) -> dict[str, Any]:
    """What the player shows of an entry, see `rss_gym.eval.report.replay.player`."""
    shown = [
        {
            "episode": case.number,
            "family": suite.families[case.row["family"]],
            "least_m": round(float(case.row["min_separation_m"]), 2),
            "closest_s": round(float(case.row["closest_s"]), 1),
            "flight": 2 * index,
            "beside": 2 * index + 1,
        }
        for index, case in enumerate(found)
    ]
    flights = [
        {"name": flyer, "same": True, **flight.to_dict()}
        for case in found
        for flyer, flight in ((name, case.own), (NOMINAL, case.beside))
    ]
    return replay.described(suite, [{"name": name, "cases": shown}], flights, NOMINAL)


def page_of(suite: Suite, line: Mapping[str, Any], found: Sequence[Case]) -> Markup:
    """The page of an entry's replays on a suite."""
    name = line["entry"]["name"]
    data = player(suite, name, found)
    lead = Markup(  # what comes from outside is escaped by `format`
        '<a href="{}.html">Entry {}</a>, season {}.'
    ).format(line["entry_hash"][:16], name, line["season"])
    shown = replay.markup(data, "The public encounters that cost the entry most")
    return page.render(f"{name} on {suite.name}", lead, [Section("Replays", shown, data)], SCRIPTS)
