"""What the tables of the policies fly: rules over their radii, blind manoeuvres, agents, families of encounters."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from rss_gym import baselines
from rss_gym.encounters import FAMILIES
from rss_gym.eval.studies.study import Job
from rss_gym.eval.suites import find

SUITE, SPACE = "encounter-v0", "encounter3d-v0"
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
DEFAULTS = ("orthogonal", "orca", "mvp", "cbf", "mpc", "qmdp")
TABLES = ("qmdp", "qmdp:sigmas=0.8", "qmdp:sigmas=1.8")  # a rule without a radius
README = ("none", "orthogonal:radius_m=40", "orca:radius_m=20", "mpc")
OF_FAMILY = {"merging": {"intruders": 8, "intruders_min": 2}}  # what a family needs of the world beside its name


def rules(level: str) -> tuple[str, ...]:
    """Every rule at every radius."""
    return tuple(f"{rule}:radius_m={radius:g}" for rule, radii in RADII[level].items() for radius in radii)


def agents(suite: str, **changes: Any) -> tuple[str, ...]:
    """Those that are shipped and were made for this world."""
    return tuple(name for name in baselines.able(find(suite).changed(**changes).params) if name in baselines.AGENTS)


def families() -> list[str]:
    """Those drawn by `mixed` and those that tell the rules apart; not the degenerate ones, which are one encounter."""
    return [name for name, family in FAMILIES.items() if family.script is None]


def planned(shrink: int = 1) -> list[Job]:
    """All of them, the README's first, with `shrink` times fewer encounters."""
    readme_n, n, family_n = (max(count // shrink, 2) for count in (README_EPISODES, EPISODES, FAMILY_EPISODES))
    out = [Job("readme", SUITE, README, readme_n)]
    for level in RADII:
        out.append(
            Job(level, SUITE, ("none", *rules(level), *TABLES, *BLIND, *DEAF), n, changes={"information": level})
        )
    out.append(Job("space", SPACE, ("none", *DEFAULTS, *BLIND, "climb"), n))
    for family in families():
        where = {"families": [family], **OF_FAMILY.get(family, {})}
        out.append(Job(family, SUITE, ("none", *DEFAULTS), family_n, changes=where))
    # Agents apart, over the same encounters: the rules need not fly again when they are made anew.
    found = [(job, agents(job.suite, **job.changes)) for job in out]
    return out + [replace(job, name=f"{job.name}{AGENTS}", policies=names) for job, names in found if names]
