"""Makes docs/opponents.md with its chart and the README's scores: make table (about half an hour on two free cores).

Each job is a record of `rss-gym eval` in a folder of its own in runs/table/, so that an interrupted run goes on where
it stopped. A folder's name tells what is flown, not by which code: remove runs/table/ after a change of the world or of
a policy. `--readme` flies and writes the README's table alone (some minutes).
"""

import argparse
import hashlib
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, get_args

import flights
import opponents

from rss_gym import baselines
from rss_gym.baselines import policy_files
from rss_gym.encounters import FAMILIES
from rss_gym.eval import Result, evaluate
from rss_gym.eval.suites import find
from rss_gym.files import write_text
from rss_gym.pages.figure import require_figures
from rss_gym.params import Information

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
RUNS = ROOT / "runs" / "table"
SUITE, SPACE, SEED = "encounter-v0", "encounter3d-v0", 0
README_EPISODES, EPISODES, FAMILY_EPISODES = 20_000, 5_000, 1_000

# Level of information -> rule -> radii, in front of the options that stay.
RADII: dict[str, dict[str, tuple[float, ...]]] = {
    "positions": {
        "orthogonal": (30, 40, 60, 80),
        "orca": (15, 20, 25, 30),
        "mvp": (15, 20, 25, 40),
        "cbf": (15, 20, 25, 30),
        "mpc": (15, 20, 25, 30),
    },
    "ranges": {
        "orthogonal": (40, 60, 80),
        "modified-orthogonal": (60, 90, 120),
        "orca": (20, 30, 40),
        "mvp": (20, 30, 40),
        "cbf": (20, 30, 40),
        "mpc": (20, 30, 40),
    },
    "oracle": {
        "orthogonal": (20, 30, 40),
        "orca": (15, 17, 20),
        "mvp": (15, 17, 20),
        "cbf": (15, 17, 20),
        "mpc": (15, 17, 20),
    },
}
# These know nothing, so that they fly the same on every level, and the next know of a warning at most.
BLIND = ("constant:right_m=30", "constant:right_m=100", "velocity", "stop", "back", "blind")
DEAF = ("brake", "right-turn", "random")
AGENTS = "-agents"  # of the name of a record that holds these
DEFAULTS = ("orthogonal", "orca", "mvp", "cbf", "mpc")
README = (
    "none",
    *("orthogonal:radius_m=30", "orthogonal:radius_m=40", "orthogonal:radius_m=60"),
    *("orca:radius_m=15", "orca:radius_m=20", "orca:radius_m=25"),
    *("mvp", "cbf", "mpc"),
    *("constant:right_m=30", "stop", "back"),
)
OF_FAMILY = {"merging": {"intruders": 8, "intruders_min": 2}}  # what a family needs of the world beside its name


@dataclass(frozen=True)
class Job:
    """What one record holds: policies in a suite with changes to its world."""

    name: str
    suite: str
    changes: dict[str, Any]
    policies: tuple[str, ...]
    episodes: int

    @property
    def folder(self) -> Path:
        """Named by the job and by everything that defines it."""
        hashes = [find(self.suite).changed(**self.changes).hash, *(digest(name) for name in self.policies)]
        content = json.dumps([hashes, self.policies, self.episodes])
        return RUNS / f"{self.name}-{hashlib.sha256(content.encode()).hexdigest()[:8]}"

    @property
    def flights(self) -> int:
        """How many it flies, those of `none` included."""
        return self.episodes * len({*self.policies, "none"})

    def evaluate(self, workers: int) -> Result:
        """Fly them all."""
        return evaluate(self.policies, self.suite, self.episodes, SEED, workers, progress=False, **self.changes)


def digest(name: str) -> str:
    """What a name alone does not tell of an agent."""
    agents = baselines.AGENTS
    return hashlib.sha256(b"".join(policy_files.read(agents[name]))).hexdigest() if name in agents else ""


def rules(level: str) -> tuple[str, ...]:
    """Every rule at every radius."""
    return tuple(f"{rule}:radius_m={radius:g}" for rule, radii in RADII[level].items() for radius in radii)


def agents(suite: str, **changes: Any) -> tuple[str, ...]:
    """Those that are shipped and were made for this world."""
    return tuple(name for name in baselines.able(find(suite).changed(**changes).params) if name in baselines.AGENTS)


def families() -> list[str]:
    """Those drawn by `mixed` and those that tell the rules apart; not the degenerate ones, which are one encounter."""
    return [name for name, family in FAMILIES.items() if family.script is None]


def jobs(shrink: int = 1) -> list[Job]:
    """All of them, the README's first, with `shrink` times fewer encounters."""
    readme_n, n, family_n = (max(count // shrink, 2) for count in (README_EPISODES, EPISODES, FAMILY_EPISODES))
    out = [Job("readme", SUITE, {}, README, readme_n)]
    out += [Job(level, SUITE, {"information": level}, ("none", *rules(level), *BLIND, *DEAF), n) for level in RADII]
    out.append(Job("space", SPACE, {}, ("none", *DEFAULTS, *BLIND, "climb"), n))
    for family in families():
        where = {"families": [family], **OF_FAMILY.get(family, {})}
        out.append(Job(family, SUITE, where, ("none", *DEFAULTS), family_n))
    # Agents apart, over the same encounters: the rules need not fly again when they are made anew.
    found = [(job, agents(job.suite, **job.changes)) for job in out]
    return out + [replace(job, name=f"{job.name}{AGENTS}", policies=names) for job, names in found if names]


def folders(todo: list[Job], name: str) -> list[Path]:
    """The records of a job and of the agents over its encounters."""
    return [job.folder for job in todo if job.name in (name, f"{name}{AGENTS}")]


def readme(todo: list[Job]) -> str:
    """The README's table."""
    return f"{opponents.ranked(folders(todo, 'readme'))}\n\n{opponents.made(todo[0].episodes)}"


def pages(todo: list[Job]) -> tuple[str, str]:
    """From the records of the jobs: the tables of docs/opponents.md, and the chart."""
    text = [f"## Information `{level}`\n\n{opponents.ranked(folders(todo, level))}" for level in RADII]
    text.append(f"## In space, information `positions`\n\n{opponents.ranked(folders(todo, 'space'))}")
    rows = {name: opponents.read(folders(todo, name)) for name in families()}
    text.append(f"## Cost by family, information `positions`\n\n{opponents.by_family(rows)}")
    text.append(opponents.made())
    found = {level: opponents.read(folders(todo, level)) for level in RADII}
    curves = {
        level: {
            rule: [found[level][f"{rule}:radius_m={radius:g}"] for radius in radii]
            for rule, radii in RADII[level].items()
        }
        for level in RADII
    }
    single = {level: [found[level][name] for name in agents(SUITE, information=level)] for level in RADII}
    return "\n\n".join(text), opponents.chart(curves, {level: found[level]["none"] for level in RADII}, single)


def main() -> None:
    """Fly what is missing and write the pages, or print them for a test."""
    parser = argparse.ArgumentParser(description="Flies the tables of the policies and writes docs/opponents.md.")
    parser.add_argument("--shrink", type=int, default=1, metavar="N", help="N times fewer encounters, for a test")
    parser.add_argument("--readme", action="store_true", help="fly and write the README's table alone")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    options = parser.parse_args()
    require_figures()
    assert set(RADII) == set(get_args(Information))
    todo = jobs(options.shrink)
    todo = [job for job in todo if job.name.startswith("readme")] if options.readme else todo
    flights.fly(todo, options.workers)
    scores = readme(todo)
    tables, drawn = ("", "") if options.readme else pages(todo)
    if options.shrink > 1:
        print(f"{scores}\n\n{tables}")
        return
    opponents.put(ROOT / "README.md", "scores", scores)
    if not options.readme:
        opponents.put(DOCS / "opponents.md", "tables", tables)
        write_text(DOCS / "opponents.svg", drawn)


if __name__ == "__main__":
    main()
