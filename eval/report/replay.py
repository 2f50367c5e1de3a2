"""Each policy's closest encounters, flown again beside a reference on the same episode, for the player of the page.

`fly` flies them once, when a record is written; `player` makes what the script of the page plays of a result and these
flights alone. They are no figures of `rss_gym.pages.figure`, because a figure stands still.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from rss_gym.eval.episodes import Block, PolicyError, fly_episodes
from rss_gym.eval.evaluate import NOMINAL, Result, Scored
from rss_gym.eval.policies import Entry
from rss_gym.eval.report import series
from rss_gym.eval.report.flights import Flown, ReplayFlight
from rss_gym.eval.suites import Suite
from rss_gym.pages.markup import renderer

render = renderer(__file__)
POLICIES, ENCOUNTERS = 12, 3  # that fit into the page
RULE = "orthogonal"
NOTHING = "The record holds no flights, so that this page has no replays."
SAME = ("collision", "min_separation_m", "flown_m", "flown_s")  # columns that a second flight must repeat


def closest(scored: Scored, count: int = ENCOUNTERS) -> list[int]:
    """Rows of the encounters in which the policy came nearest to an intruder."""
    table = scored.table
    return [int(row) for row in np.lexsort((table["episode"], table["min_separation_m"]))[:count]]


def reference_index(result: Result) -> int:
    """The policy that the others are shown beside: the result's reference or the first that is a rule, else `none`."""
    entries = [scored.entry for scored in result.policies]
    rules = [index for index, entry in enumerate(entries) if entry.spec.startswith(RULE)]
    rules.sort(
        key=lambda index: (entries[index].spec.partition(":")[0] != RULE, entries[index].name != result.reference)
    )
    return rules[0] if rules else [entry.name for entry in entries].index(NOMINAL)


def chosen(result: Result, reference: int) -> tuple[list[int], list[int]]:
    """Policies shown and left out: the reference, those that are alone, then settings of rules, evenly spread."""
    on_curve = {index for curve in series.of(result).curves for index, _ in curve.members}
    everybody = range(len(result.policies))
    first = sorted(everybody, key=lambda index: (index != reference, index in on_curve, index))[:POLICIES]
    alone = [index for index in first if index == reference or index not in on_curve]
    settings = [index for index in everybody if index in on_curve and index != reference]
    picked = np.linspace(0, len(settings) - 1, min(POLICIES - len(alone), len(settings))).round().astype(int)
    shown = sorted([*alone, *(settings[k] for k in picked)])
    return shown, [index for index in everybody if index not in shown]


def wanted(result: Result) -> Iterator[tuple[int, int, list[int]]]:
    """Index of each policy shown, of the one beside it, and the rows of its closest encounters."""
    beside = reference_index(result)
    nominal = [scored.entry.name for scored in result.policies].index(NOMINAL)
    for index in chosen(result, beside)[0]:
        yield index, beside if index != beside else nominal, closest(result.policies[index])


def fly(result: Result) -> Flown:
    """Fly the encounters again that the player shows: at most `ENCOUNTERS` of `POLICIES` policies, and those beside."""
    flights: dict[tuple[str, int], dict[str, Any]] = {}
    failed: dict[str, str] = {}
    for index, beside, rows in wanted(result):
        for row, one in ((row, one) for row in rows for one in (index, beside)):
            scored = result.policies[one]
            name, episode = scored.entry.name, int(scored.table["episode"][row])
            if name in failed or (name, episode) in flights:
                continue
            try:
                flights[name, episode] = again(scored.entry, result.suite.split, result.seed, scored.table[row])
            except PolicyError as error:
                failed[name] = str(error)
    return Flown(flights, tuple(failed.values()))


def player(result: Result, flown: Flown) -> dict[str, Any]:
    """What the player shows: policies with their cases, each of which names two of the flights, as plain JSON."""
    beside = reference_index(result)
    numbers = {key: number for number, key in enumerate(flown.flights)}
    policies = []
    for index, other, rows in wanted(result):
        scored, name = result.policies[index], result.policies[other].entry.name
        cases = [
            {
                "episode": (episode := int(scored.table["episode"][row])),
                "family": result.suite.families[scored.table["family"][row]],
                "least_m": round(float(scored.table["min_separation_m"][row]), 2),
                "closest_s": round(float(scored.table["closest_s"][row]), 1),
                "flight": numbers.get((scored.entry.name, episode)),
                "beside": numbers.get((name, episode)) if other != index else None,
            }
            for row in rows
        ]
        if all(case["flight"] is not None and (case["beside"] is not None or other == index) for case in cases):
            policies.append({"name": scored.entry.name, "cases": cases})
    flights = [{"name": name} | flight for (name, _), flight in flown.flights.items()]
    left_out = [result.policies[index].entry.name for index in chosen(result, beside)[1]]
    return described(result.suite, policies, flights, result.policies[beside].entry.name, left_out, flown.failed)


def described(
    suite: Suite,
    policies: Sequence[Mapping[str, Any]],
    flights: Sequence[Mapping[str, Any]],
    beside: str,
    left_out: Sequence[str] = (),
    failed: Sequence[str] = (),
) -> dict[str, Any]:
    """What the script of the page is given: policies with their cases, flights, and what it needs of the world."""
    return {
        "policies": list(policies),
        "flights": list(flights),
        "beside": beside,
        "left_out": list(left_out),
        "failed": list(failed),
        "zone_m": suite.params.zone.radius_m,
        "collision_m": suite.params.zone.collision_m,
        "decision_s": suite.params.clock.decision_s,
        "planar": suite.params.encounter.planar,
    }


def again(entry: Entry, split: str, seed: int, row: np.void) -> dict[str, Any]:
    """The encounter of a row of a policy's table, flown again, and whether it came out as scored."""
    flight = ReplayFlight()
    block = Block(split, seed, [int(row["episode"])])
    table, _ = fly_episodes(entry.policy, entry.name, entry.params, block, watch=flight)
    same = all(bool(table[0][name] == row[name]) for name in SAME)
    return {"same": same, **flight.to_dict()}


def markup(data: dict[str, Any] | None, which: str = "Each policy's encounters with the least separation") -> Markup:
    """The markup round the player, which the page's script shows and fills with what `player` gave.

    `which` begins the sentence above it: whose encounters, and which.
    """
    return render("replays.html", data=data, which=which, nothing=NOTHING, nominal=NOMINAL)
