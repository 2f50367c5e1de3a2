"""Flies each policy's closest encounters again, beside a reference on the same episode, for the player of the page."""

from __future__ import annotations

import math
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from rss_gym.core import BaseBatch, Batch
from rss_gym.eval.episodes import Block, PolicyError, fly_episodes
from rss_gym.eval.evaluate import NOMINAL, Result, Scored
from rss_gym.eval.report import series
from rss_gym.highway.batch import RoadBatch
from rss_gym.pages.page import text

POLICIES, ENCOUNTERS = 12, 3  # that fit into the page
RULE = "orthogonal"
SAME = ("collision", "min_separation_m", "flown_m", "flown_s")  # columns that a second flight must repeat


class ReplayFlight:
    """The samples of one flight, one a decision: call it with the batch of one, as `fly` does.

    Lengths are whole decimetres and the least separation whole centimetres, which keeps the page small.
    """

    def __init__(self) -> None:
        self.own: dict[str, list[int | None]] = {"position": [], "planned": [], "way_point": []}
        self.intruders: list[dict[str, list[int | None]]] = []
        self.least: list[int] = []
        self.times: list[float] = []
        self.collision = False

    def __call__(self, batch: BaseBatch) -> None:
        """Take the present moment of row 0."""
        episode = batch.episode[0]
        own, others = _road(batch) if isinstance(batch, RoadBatch) else _air(batch)  # type: ignore[arg-type]
        for name, values in own.items():
            self.own[name] += scaled(values)
        for k, (position_m, other, is_heard) in enumerate(others):
            if k == len(self.intruders):  # on a road one may come later: until then it stands where it will appear
                self.intruders.append({name: [] for name in ("position", "message", "range", "std", "zone", "warning")})
                for _ in self.times:
                    self._add(self.intruders[k], position_m, other, False)
            self._add(self.intruders[k], position_m, other, is_heard)
        self.least.append(round(100.0 * float(episode["min_separation_m"])))
        self.times.append(round(float(episode["tick"]) * batch.params.clock.tick_s, 3))
        self.collision = bool(episode["collision"])

    @staticmethod
    def _add(into: dict[str, list[int | None]], position_m: np.ndarray, other: Any, is_heard: bool) -> None:
        into["position"] += scaled(position_m)
        message = other["position_m"] + other["age_s"] * other["velocity_mps"]
        into["message"] += scaled((message if is_heard and other["valid"] else np.full(3, np.nan))[: len(position_m)])
        for name, column in (("range", "range_m"), ("std", "range_std_m"), ("zone", "radius_m")):
            into[name] += scaled(other[column] if is_heard else np.nan)
        into["warning"].append(int(is_heard and other["warning"]))

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON types."""
        return {
            "own": self.own,
            "intruders": self.intruders,
            "least": self.least,
            "times": self.times,
            "collision": self.collision,
        }


Moment = tuple[dict[str, np.ndarray], list[tuple[np.ndarray, Any, bool]]]


def _air(batch: Batch) -> Moment:
    """The agent's vectors, and of each intruder its position, what is sensed of it, and whether it is."""
    params, own, aircraft = batch.params, batch.seen.own[0], batch.state.aircraft[0]
    axes = 2 if params.encounter.planar else 3
    others = batch.seen.others[0].copy()
    others["valid"] &= params.interface.information != "ranges"
    vectors = {"position": aircraft[0]["position_m"], "planned": own["planned_m"], "way_point": own["way_point_m"]}
    present = range(int(batch.episode[0]["intruders"]))
    return (
        {name: values[:axes] for name, values in vectors.items()},
        [(aircraft[1 + k]["position_m"][:axes], others[k], True) for k in present],
    )


def _road(batch: RoadBatch) -> Moment:
    """The same of a drive, with what highway-env has to the right as south."""
    env, north = batch.environments[0], np.array([1.0, -1.0])
    planned_m = env.plan.position_m(float(batch.episode[0]["tick"]) * batch.params.clock.tick_s)
    own = {"position": env.vehicle.position, "planned": planned_m, "way_point": env.vehicle.position}
    vehicles, others = env.ranging.sensor.vehicles[1:], env.ranging.sensor.sense_all().copy()
    others["position_m"][:, 1] *= -1.0
    others["velocity_mps"][:, 1] *= -1.0
    return (
        {name: values * north for name, values in own.items()},
        [(v["position_m"][:2] * north, o, bool(o["present"])) for v, o in zip(vehicles, others, strict=True)],
    )


def scaled(values: Any) -> list[int | None]:
    """Metres as whole decimetres; None for what is not finite."""
    return [round(10.0 * value) if math.isfinite(value) else None for value in np.atleast_1d(values).tolist()]


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


def collect(result: Result) -> dict[str, Any]:
    """The flights for the player: policies with their cases, each of which names two of the flights, as plain JSON."""
    beside = reference_index(result)
    nominal = [scored.entry.name for scored in result.policies].index(NOMINAL)
    shown, left_out = chosen(result, beside)
    flights: dict[tuple[int, int], int] = {}
    records: list[dict[str, Any]] = []
    failed: list[str] = []

    def flown(index: int, row: int) -> int:
        if (index, row) not in flights:
            records.append(again(result, index, row))
            flights[index, row] = len(records) - 1
        return flights[index, row]

    policies = []
    for index in shown:
        scored = result.policies[index]
        other = beside if index != beside else nominal
        try:
            cases = [
                {
                    "episode": int(scored.table["episode"][row]),
                    "family": result.suite.families[scored.table["family"][row]],
                    "least_m": round(float(scored.table["min_separation_m"][row]), 2),
                    "closest_s": round(float(scored.table["closest_s"][row]), 1),
                    "flight": flown(index, row),
                    "beside": flown(other, row) if other != index else None,
                }
                for row in closest(scored)
            ]
        except PolicyError as error:
            failed.append(str(error))
            continue
        policies.append({"name": scored.entry.name, "cases": cases})
    return {
        "policies": policies,
        "flights": records,
        "beside": result.policies[beside].entry.name,
        "left_out": [result.policies[index].entry.name for index in left_out],
        "failed": failed,
        "zone_m": result.suite.params.zone.radius_m,
        "collision_m": result.suite.params.zone.collision_m,
        "decision_s": result.suite.params.clock.decision_s,
        "planar": result.suite.params.encounter.planar,
    }


def again(result: Result, index: int, row: int) -> dict[str, Any]:
    """One encounter of one policy, flown again, with its name and whether it came out as scored."""
    scored, flight = result.policies[index], ReplayFlight()
    entry, number = scored.entry, int(scored.table["episode"][row])
    block = Block(result.suite.split, result.seed, [number])
    table, _ = fly_episodes(entry.policy, entry.name, entry.params, block, watch=flight)
    same = all(table[0][name] == scored.table[row][name] for name in SAME)
    return {"name": entry.name, "same": same, **flight.to_dict()}


def markup(result: Result, data: dict[str, Any]) -> str:
    """The player, still without flights, which a script puts in."""
    beside = result.policies[reference_index(result)].entry.name
    words = f"<code>{text(beside)}</code>"
    if beside != NOMINAL:
        words += f" (and that one beside <code>{NOMINAL}</code>)"
    notes = [f"Not flown again: {sentence}." for sentence in data["failed"]]
    if data["left_out"]:
        notes.insert(0, f"Without replays, to keep the page small: {', '.join(data['left_out'])}.")
    template = Template(Path(__file__).with_name("player.html").read_text(encoding="utf-8"))
    return template.substitute(beside=words, notes="".join(f'<p class="note">{text(note)}</p>\n' for note in notes))
