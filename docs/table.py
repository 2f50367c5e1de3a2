"""Makes docs/opponents.md and the README's scores: make table (under an hour on two free cores).

Each job is a record of `rss-gym eval` in a folder of its own in runs/table/, so that an interrupted run goes on where
it stopped. A folder's name tells what is flown, not by which code: remove runs/table/ after a change of the world or of
a rule.
"""

import argparse
import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import flights
import opponents

from rss_gym.baselines import POLICIES
from rss_gym.encounters import FAMILIES
from rss_gym.eval import Result, evaluate
from rss_gym.eval.suites import find
from rss_gym.files import write_text
from rss_gym.pages.figure import require_figures

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
RUNS = ROOT / "runs" / "table"
SUITE, SEED, WORKERS = "encounter-v0", 0, 2
CHOSEN, POINT, BY_FAMILY = 100_000, 20_000, 5_000  # encounters of a rule's chosen setting, of others, in a family
SLOW_CHOSEN, SLOW_POINT, SLOW_BY_FAMILY = 20_000, 5_000, 2_000  # of the slow rules
SLOW_COST = 8  # time of a slow rule's flight in those of another, for the time that is left


@dataclass(frozen=True)
class Curve:
    """A rule's settings: the one chosen and the others, values of `option` in front of the options that stay."""

    chosen: float
    others: tuple[float, ...] = ()
    option: str = "radius_m"
    rest: str = ""

    @property
    def values(self) -> list[float]:
        """All, ascending."""
        return sorted((self.chosen, *self.others))


# Chosen on 4,000 encounters of split `validation`, seed 0; on track `paper` the rules' defaults.
CONSTANT = Curve(30, (15, 60, 100), "right_m")
CURVES: dict[str, dict[str, Curve]] = {
    "paper": {
        "orthogonal": Curve(60, (20, 40, 80, 120)),
        "orca": Curve(25, (10, 15, 20, 40)),
        "mvp": Curve(25, (10, 15, 40, 60)),
        "cbf": Curve(25, (10, 15, 20, 40)),
        "mpc": Curve(30, (10, 15, 20, 40)),
        "constant": CONSTANT,
    },
    "range": {
        "orthogonal": Curve(60, (20, 40, 80, 120)),
        "orca": Curve(25, (15, 20, 30, 40)),
        "mvp": Curve(30, (15, 20, 45, 70), rest=",lookahead_s=40"),
        "cbf": Curve(25, (15, 20, 30, 45)),
        "mpc": Curve(20, (10, 15, 30, 45)),
        "modified-orthogonal": Curve(120, (40, 60, 90)),
        "constant": CONSTANT,
    },
    "oracle": {
        "orthogonal": Curve(60, (20, 30, 40, 80)),
        "orca": Curve(10, (5, 7, 15, 25)),
        "mvp": Curve(10, (5, 7, 15, 25)),
        "cbf": Curve(10, (5, 7, 15, 25)),
        "mpc": Curve(10, (5, 7, 15, 25)),
        "constant": CONSTANT,
    },
}
CLIMB = Curve(15, (5, 10), "up_m")
OF_FAMILY = {"merging": {"intruders": 8, "intruders_min": 2}}  # what a family needs of the world beside its name
README_TRACK = "paper"
BLIND = ("blind", "brake", "right-turn", "random")


@dataclass(frozen=True)
class Job:
    """What one record holds: policies in a suite with changes to its world; `slow` if the policies are."""

    name: str
    suite: str
    changes: dict[str, Any]
    policies: tuple[str, ...]
    episodes: int
    slow: bool = False

    @property
    def folder(self) -> Path:
        """Named by the job and by everything that defines it."""
        content = json.dumps([find(self.suite).changed(**self.changes).hash, self.policies, self.episodes])
        return RUNS / f"{self.name}-{hashlib.sha256(content.encode()).hexdigest()[:8]}"

    @property
    def flights(self) -> int:
        """With those of `none`."""
        return self.episodes * len({*self.policies, "none"})

    @property
    def cost(self) -> int:
        """Time that it takes, in flights."""
        return self.flights * (SLOW_COST if self.slow else 1)

    def evaluate(self) -> Result:
        """Fly them all."""
        return evaluate(self.policies, self.suite, self.episodes, SEED, WORKERS, progress=False, **self.changes)


def spec(rule: str, curve: Curve, value: float) -> str:
    """The policy at one setting."""
    return f"{rule}:{curve.option}={value:g}{curve.rest}"


def is_slow(rule: str, track: str) -> bool:
    """Whether the rule enumerates candidates or needs the range-only filter."""
    return rule == "mpc" or (track == "range" and POLICIES[rule].reads_positions)


def families() -> list[str]:
    """Those drawn by `mixed` and those that tell the rules apart; not the degenerate ones, which are one encounter."""
    return [name for name, family in FAMILIES.items() if family.script is None]


def chosen(track: str, slow: bool) -> tuple[str, ...]:
    """The chosen setting of each rule, of the slow or of the others."""
    curves = CURVES[track].items()
    return tuple(spec(rule, curve, curve.chosen) for rule, curve in curves if is_slow(rule, track) == slow)


def points(rule: str, curve: Curve) -> tuple[str, ...]:
    """Every setting of a curve."""
    return tuple(spec(rule, curve, value) for value in curve.values)


def jobs(shrink: int) -> list[Job]:
    """All of them, with `shrink` times fewer encounters."""
    counts = (CHOSEN, POINT, BY_FAMILY, SLOW_CHOSEN, SLOW_POINT, SLOW_BY_FAMILY)
    chosen_n, point_n, family_n, slow_n, slow_point_n, slow_family_n = (max(count // shrink, 2) for count in counts)
    out = []
    for track, curves in CURVES.items():
        where: dict[str, Any] = {"track": track}
        first = Job(track, SUITE, where, ("none", *chosen(track, slow=False), *BLIND), chosen_n)
        out.append(first)
        for rule, curve in curves.items():
            slow, best = is_slow(rule, track), spec(rule, curve, curve.chosen)
            others = tuple(name for name in points(rule, curve) if name != best)
            out.append(Job(f"{track}-{rule}", SUITE, where, others, slow_point_n if slow else point_n, slow))
        slow_rules = chosen(track, slow=True)
        out.append(Job(f"{track}-slow", SUITE, where, slow_rules, slow_n, slow=True))
    rules = (*chosen("paper", slow=False), *chosen("paper", slow=True))
    flown = dict.fromkeys(("none", *rules, *points("constant", CONSTANT), *points("climb", CLIMB)))
    out.append(Job("space", "encounter3d-v0", {}, tuple(flown), point_n))
    for track in CURVES:
        for family in families():
            where = {"track": track, "families": [family], **OF_FAMILY.get(family, {})}
            out.append(Job(f"{track}-{family}", SUITE, where, chosen(track, slow=False), family_n))
            slow_rules = chosen(track, slow=True)
            out.append(Job(f"{track}-{family}-slow", SUITE, where, slow_rules, slow_family_n, slow=True))
    return out


def pages(todo: list[Job]) -> tuple[str, str, str]:
    """From the records of the jobs: the README's table, those of docs/opponents.md, the chart."""
    found = {job.name: opponents.read(job.folder) for job in todo}
    curves: dict[str, dict[str, list[opponents.Row]]] = {}
    main, text = {}, []
    for track in CURVES:
        curves[track], rows = {}, [found[track]["none"]]
        for rule, curve in CURVES[track].items():
            known = found[f"{track}-{rule}"] | found[f"{track}-slow"] | found[track]
            curves[track][rule] = [known[name] for name in points(rule, curve)]
            rows += curves[track][rule] if curve is CONSTANT else [known[spec(rule, curve, curve.chosen)]]
        main[track] = opponents.scores([*rows, *(found[track][name] for name in BLIND)])
        text.append(f"## Track `{track}`\n\n{main[track]}")
    text.append(f"## All settings\n\n![Collisions over deviation](opponents.svg)\n\n{opponents.LEGEND}")
    for track in CURVES:
        rows = [row for line in curves[track].values() for row in line]
        text.append(f"### Track `{track}`\n\n{opponents.settings(rows)}")
    text.append(f"## In space, track `paper`\n\n{opponents.scores(found['space'].values())}")
    for track in CURVES:
        rows_of = {name: found[f"{track}-{name}-slow"] | found[f"{track}-{name}"] for name in families()}
        text.append(f"## Collisions by family, track `{track}`\n\n{opponents.by_family(rows_of)}")
    drawn = opponents.chart(curves, {track: found[track]["none"] for track in CURVES})
    return f"{main[README_TRACK]}\n\n{opponents.made()}", "\n\n".join([*text, opponents.made()]), drawn


def main() -> None:
    """Fly what is missing and write the pages, or print them for a test."""
    parser = argparse.ArgumentParser(description="Flies the tables of the scripted rules and writes docs/opponents.md.")
    parser.add_argument("--shrink", type=int, default=1, metavar="N", help="N times fewer encounters, for a test")
    options = parser.parse_args()
    require_figures()
    todo = jobs(options.shrink)
    flights.fly(todo)
    readme, tables, drawn = pages(todo)
    if options.shrink > 1:
        print(tables)
        return
    opponents.put(ROOT / "README.md", "scores", readme)
    opponents.put(DOCS / "opponents.md", "tables", tables)
    write_text(DOCS / "opponents.svg", drawn)


if __name__ == "__main__":
    main()
