"""Flies the bars of the shipped agents and writes docs/agents.md and the README's table: make bars.

What is flown and asked stands in docs/bars.toml, which has to be committed before: a plan, or code that flies it, with
changes that are not committed is refused, and so are other agents than those that the plan was sealed for. Each job is
a record of `rss-gym eval` in a folder of its own in runs/bars/, named by everything that defines it, so that an
interrupted run goes on where it stopped; beside it stands the commit of the plan that it was flown for.
"""

import argparse
import dataclasses
import hashlib
import json
import subprocess
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import bars_page
import bars_plan
import flights
import opponents
from bars_asked import Flight, Flown

from rss_gym.baselines.agent import Agent as Learned
from rss_gym.baselines.mpc import Mpc
from rss_gym.baselines.range_only import RangeOnly
from rss_gym.eval import Result, evaluate, reading
from rss_gym.eval.policies import Entry, entry
from rss_gym.eval.suites import Suite, find
from rss_gym.files import write_text
from rss_gym.pages.figure import require_figures
from rss_gym.params import ParamsError

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
PLAN = DOCS / "bars.toml"
RUNS = ROOT / "runs" / "bars"
CODE = ("rss_gym", "baselines", "eval", "docs/*.py")  # what the flights and the verdicts depend on, beside the plan
FLOWN_FOR = "plan.txt"  # in a record: the commit of the plan
WORKERS = 2
LEARNED_COST, FILTER_COST, MPC_COST = 5.0, 3.0, 15.0  # time of a flight, in those of a cheap rule


@dataclass(frozen=True)
class Job:
    """What one record holds.

    Parameters
    ----------
    name : str
    suite : Suite
        On the split that is flown.
    seed, episodes : int
    policies : dict
        Name in the tables -> specification.
    changes : dict
        Of the suite's world.
    """

    name: str
    suite: Suite
    seed: int
    episodes: int
    policies: dict[str, str]
    changes: dict[str, Any] = field(default_factory=dict)

    @cached_property
    def entries(self) -> list[Entry]:
        """The policies, made for the world; refuses those that cannot be."""
        world = self.suite.changed(**self.changes).params
        return [entry(spec, world, name) for name, spec in self.policies.items()]

    @property
    def folder(self) -> Path:
        """Named by the job and by everything that defines it, a learned policy's numbers too."""
        flown = {item.name: item.hash for item in self.entries}
        content = json.dumps([self.suite.changed(**self.changes).hash, self.seed, self.episodes, flown])
        return RUNS / f"{self.name}-{hashlib.sha256(content.encode()).hexdigest()[:8]}"

    @property
    def flights(self) -> int:
        """With those of `none`."""
        return self.episodes * len({*self.policies, "none"})

    @property
    def cost(self) -> float:
        """Time that it takes, in flights of a cheap rule."""
        return self.episodes * (1.0 + sum(_cost(item) for item in self.entries))

    def evaluate(self) -> Result:
        """Fly it."""
        return evaluate(self.policies, self.suite, self.episodes, self.seed, WORKERS, progress=None, **self.changes)


def _cost(item: Entry) -> float:
    if isinstance(item.policy, Mpc):
        return MPC_COST
    if isinstance(item.policy, RangeOnly):
        return FILTER_COST
    return LEARNED_COST if isinstance(item.policy, Learned) else 1.0


@dataclass(frozen=True)
class Part:
    """An agent of the plan and its jobs.

    Parameters
    ----------
    agent : bars_plan.Agent
    shipped : str
        Name of the seed that is handed on; empty where none is.
    seeds : tuple of str
        Names of all of them.
    own : list of Job
        In the agent's suite; all that fly as often share a job, and the flights of `none`.
    worlds : dict
        World -> job of the seed that is handed on.
    """

    agent: bars_plan.Agent
    shipped: str
    seeds: tuple[str, ...]
    own: list[Job]
    worlds: dict[str, Job]

    @property
    def jobs(self) -> list[Job]:
        """All."""
        return [*self.own, *self.worlds.values()]


def part(agent: bars_plan.Agent, most: int) -> Part:
    """The jobs of an agent, with at most so many encounters each.

    Raises
    ------
    ParamsError
        If a policy cannot be made, or the one handed on is none of the seeds.
    """
    suite = dataclasses.replace(find(agent.suite), split=agent.split)
    seeds = {f"{agent.name}, seed {index}": spec for index, spec in enumerate(agent.seeds)}
    shipped = _shipped(agent, seeds, suite) if agent.policy else ""
    wanted: dict[int, dict[str, str]] = {}
    for name, spec in seeds.items():
        count = agent.encounters if name == shipped else agent.seed_encounters
        wanted.setdefault(min(count, most), {})[name] = spec
    for grid in agent.opponents:
        wanted.setdefault(min(grid.encounters, most), {}).update({spec: spec for spec in grid.specs})

    def job(name: str, policies: dict[str, str], count: int, changes: dict[str, Any]) -> Job:
        return Job(f"{agent.name}-{name}", suite, agent.seed, count, policies, changes)

    own = [job(f"{count}", policies, count, {}) for count, policies in sorted(wanted.items(), reverse=True)]
    worlds = {
        world.name: job(world.name, {shipped: seeds[shipped]}, min(world.encounters, most), world.changes)
        for world in agent.worlds
    }
    return Part(agent, shipped, tuple(seeds), own, worlds)


def _shipped(agent: bars_plan.Agent, seeds: dict[str, str], suite: Suite) -> str:
    """Name of the seed that the policy handed on equals."""
    handed_on = entry(agent.policy, suite.params).hash
    for name, spec in seeds.items():
        if entry(spec, suite.params).hash == handed_on:
            return name
    raise ParamsError(f"[agents.{agent.name}]: policy {agent.policy!r} is none of the seeds; name its folder there too")


def ablation(item: bars_plan.Ablation, index: int, most: int) -> Job:
    """The job of an ablation."""
    encounters = min(item.encounters, most)
    return Job(f"ablation-{index}", find(item.suite), item.seed, encounters, {item.what: item.policy}, item.changes)


def seal(jobs: Iterable[Job]) -> str:
    """Digest of the numbers of all learned policies, wherever their folders lie."""
    found = {item.policy.digest for job in jobs for item in job.entries if isinstance(item.policy, Learned)}
    return hashlib.sha256(json.dumps(sorted(found)).encode()).hexdigest()[:16]


def committed(git: Callable[..., str]) -> str:
    """The commit that holds the plan.

    Raises
    ------
    ParamsError
        If plan or code have changes that are not committed.
    """
    plan = PLAN.relative_to(ROOT).as_posix()
    changed = git("status", "--porcelain", "--", plan, *CODE).splitlines()
    if changed:
        raise ParamsError(
            f"{', '.join(line[3:] for line in changed)[:200]}: changes that are not committed; the plan and what flies "
            "it are committed before the flight (or fly a --draft)"
        )
    return git("log", "-1", "--format=%H", "--", plan).strip()


def git(*arguments: str) -> str:
    """Output of Git in this repository.

    Raises
    ------
    ParamsError
        If it fails.
    """
    try:
        done = subprocess.run(["git", "-C", str(ROOT), *arguments], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise ParamsError(
            f"git {arguments[0]} failed, so that nothing shows when the plan was made: {error}"
        ) from error
    return done.stdout


def read(job: Job) -> dict[str, Flight]:
    """The flights of a job, those of `none` too, by name."""
    record = reading.load(job.folder)
    return {policy.name: Flight.of(record, policy.name) for policy in record.policies}


def flown(item: Part) -> Flown:
    """The flights of an agent's records."""
    by_name: dict[str, Flight] = {}
    for job in reversed(item.own):  # of `none` those that are most
        by_name |= read(job)
    groups: dict[str, list[Flight]] = {}
    for grid in item.agent.opponents:
        groups.setdefault(grid.group, []).extend(by_name[spec] for spec in grid.specs)
    return Flown(
        none=by_name["none"],
        shipped=by_name[item.shipped] if item.shipped else None,
        seeds=tuple(by_name[name] for name in item.seeds),
        groups=groups,
        worlds={name: read(job)[item.shipped] for name, job in item.worlds.items()},
    )


def main() -> int:
    """Fly what is missing and write the pages."""
    parser = argparse.ArgumentParser(description="Flies the bars of the agents and writes docs/agents.md.")
    parser.add_argument("--plan", type=Path, default=PLAN, help="another plan, for a draft only")
    parser.add_argument(
        "--draft", type=int, default=0, metavar="N", help="at most N encounters each, into runs/bars/draft, not docs/"
    )
    options = parser.parse_args()
    try:
        run(options.plan, options.draft)
    except ParamsError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


def run(path: Path, draft: int) -> None:
    """See `main`.

    Raises
    ------
    ParamsError
        As `bars_plan.load`, `part` and `committed`; for a plan sealed for other agents, or lying elsewhere.
    """
    require_figures()
    if path.resolve() != PLAN and not draft:
        raise ParamsError(f"--plan {str(path)!r} can only be flown as a --draft; the plan of a flight is {PLAN.name}")
    plan = bars_plan.load(path)
    most = draft or sys.maxsize
    parts = [part(agent, most) for agent in plan.agents]
    ablations = [ablation(item, index, most) for index, item in enumerate(plan.ablations)]
    jobs = [job for item in parts for job in item.jobs] + ablations
    found = seal(jobs)
    if not draft and plan.sealed != found:
        raise ParamsError(
            f"plan {path.name}: sealed = {plan.sealed!r} must be {found!r}, the digest of the agents named"
        )
    commit = "draft" if draft else committed(git)
    flights.fly(jobs, {FLOWN_FOR: commit})
    commits = sorted({(job.folder / FLOWN_FOR).read_text(encoding="utf-8") for job in jobs})
    report = bars_page.Report(
        plan=plan,
        flown={item.agent.name: flown(item) for item in parts},
        ablations=[read(job)[name].row for job in ablations for name in job.policies],
        commit=commit,
        flown_for=commits,
    )
    out = DOCS
    if draft:
        out = RUNS / "draft"
        out.mkdir(exist_ok=True)
        write_text(out / "agents.md", f"{bars_page.TABLES[0]}\n\n{bars_page.TABLES[1]}\n")
    opponents.put(out / "agents.md", "tables", report.tables())
    write_text(out / "agents.svg", report.chart())
    if not draft:
        opponents.put(ROOT / "README.md", "agents", report.summary())


if __name__ == "__main__":
    sys.exit(main())
