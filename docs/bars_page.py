"""The page of the agents from flown records: bars, comparisons, tables of docs/agents.md and the README, the chart."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import opponents
from bars_asked import Bar, Finding, Findings, Flight, Flown
from bars_plan import Plan

from rss_gym.eval.curve import frontier
from rss_gym.eval.intervals import Interval, holm

TABLES = ("<!-- tables -->", "<!-- /tables -->")
VERDICTS = {False: ("missed", "met"), True: ("not reached", "reached")}  # by whether it is an aim
NAMED_MAX = 3  # findings of a bar that do not hold, named in the table of the bars


@dataclass(frozen=True)
class Judged:
    """A bar with what the flights say to it.

    Attributes
    ----------
    agent : str
    bar : Bar
    findings : Findings
    adjusted : tuple
        Holm's p-value of each finding, None where it has none.
    holds : tuple of bool
        Of each finding.
    """

    agent: str
    bar: Bar
    findings: Findings
    adjusted: tuple[float | None, ...]
    holds: tuple[bool, ...]

    @property
    def verdict(self) -> str:
        """In a word; a bar that nothing was compared for is missed."""
        return VERDICTS[self.bar.aim][bool(self.holds) and all(self.holds)]

    @property
    def outcome(self) -> str:
        """What came out: the only finding, or how many hold and the first that do not."""
        found = self.findings.found
        if len(found) == 1:
            return shown(found[0], self.adjusted[0])
        if not found:
            return "every setting deviates less: nothing to compare at equal or smaller deviation"
        failed = [shown(item, p) for item, p, holds in zip(found, self.adjusted, self.holds, strict=True) if not holds]
        more = f"; and {len(failed) - NAMED_MAX} more" if len(failed) > NAMED_MAX else ""
        failures = f"; not: {'; '.join(failed[:NAMED_MAX])}{more}" if failed else ""
        return f"{sum(self.holds)} of {len(found)} comparisons hold{failures}"


def shown(finding: Finding, p_adjusted: float | None) -> str:
    """A finding in a line."""
    text = f"{finding.what}: {cell(finding.value, finding.form)}"
    return text if p_adjusted is None else f"{text}, p {p_adjusted:.1e}"


def cell(value: Interval, form: str) -> str:
    """Value and ends; of a one-sided interval the bound alone."""
    if value.value is None:
        return "undefined"
    if value.low is None or value.high is None:
        return format(value.value, form)
    if value.low == 0.0:
        return f"{format(value.value, form)}, at most {format(value.high, form)}"
    return f"{format(value.value, form)} [{format(value.low, form)}, {format(value.high, form)}]"


def judge(plan: Plan, flown: dict[str, Flown]) -> list[Judged]:
    """Every bar of the plan; the p-values of all comparisons are adjusted together."""
    asked = [(agent.name, bar, bar.findings(flown[agent.name])) for agent in plan.agents for bar in agent.bars]
    # Two bars may ask for one comparison, which counts once.
    p_values = {
        (name, item.what): item.p for name, _, findings in asked for item in findings.found if item.p is not None
    }
    adjusted = dict(zip(p_values, holm(list(p_values.values())), strict=True))
    out = []
    for name, bar, findings in asked:
        own = tuple(adjusted.get((name, item.what)) for item in findings.found)
        holds = tuple(item.holds(p, plan.alpha) for item, p in zip(findings.found, own, strict=True))
        out.append(Judged(name, bar, findings, own, holds))
    return out


def best_curve(flights: Iterable[Flight]) -> list[opponents.Row]:
    """The settings that no other one equals or beats in both, along the curve."""
    given = list(flights)
    return [given[index].row for index in frontier([(item.points.mean_m, item.points.rate) for item in given])]


@dataclass(frozen=True)
class Report:
    """Everything that the page shows.

    Attributes
    ----------
    plan : Plan
    flown : dict
        Agent -> its flights.
    ablations : list of opponents.Row
    commit : str
        Of the plan, or `draft`.
    flown_for : list of str
        Commits of the plan for which the records were flown.
    """

    plan: Plan
    flown: dict[str, Flown]
    ablations: list[opponents.Row]
    commit: str
    flown_for: list[str]

    @cached_property
    def judged(self) -> list[Judged]:
        """Every bar."""
        return judge(self.plan, self.flown)

    def head(self) -> str:
        """Which plan."""
        if self.commit == "draft":
            return "**A draft: few encounters, and no plan committed before. Nothing here is a result.**"
        text = f"Plan: `docs/bars.toml` of commit `{self.commit}`."
        others = [name for name in self.flown_for if name != self.commit]
        return text + (f" Some flights were made for other plans: {', '.join(others)}." if others else "")

    def bars(self) -> str:
        """A line a bar."""
        rows = ([f"`{j.agent}`", j.bar.asked, j.outcome, f"**{j.verdict}**"] for j in self.judged)
        return opponents.table(["agent", "asked", "came out", ""], rows)

    def comparisons(self) -> str:
        """A line a finding with a p-value, as asked bar by bar."""
        lines, different = [], set()
        for item in self.judged:
            rows = [
                [found.what, f"{found.value.n}", cell(found.value, found.form), f"{found.p:.1e}", f"{p:.1e}"]
                for found, p in zip(item.findings.found, item.adjusted, strict=True)
                if found.p is not None and p is not None
            ]
            different |= {(item.agent, row[0]) for row in rows}
            if rows or item.findings.remarks:
                lines.append(f"`{item.agent}`: {item.bar.asked}")
            if rows:
                lines.append(opponents.table(["comparison", "encounters", "difference", "p", "p, Holm"], rows))
            lines += [f"{remark[0].upper()}{remark[1:]}." for remark in item.findings.remarks]
        return f"{len(different)} different comparisons, their p-values adjusted together.\n\n" + "\n\n".join(lines)

    def scores(self, name: str) -> str:
        """The rows of an agent: all of its seeds, other worlds, opponents."""
        flown = self.flown[name]
        text = [opponents.scores([flown.none.row, *(seed.row for seed in flown.seeds)])]
        if flown.shipped:
            text.insert(0, f"Handed on: `{flown.shipped.name}` (hash `{flown.shipped.hash[:12]}`).")
        if flown.worlds:
            rows = [opponents.Row(world, item.row.episodes, item.row.metrics) for world, item in flown.worlds.items()]
            text.append(f"In other worlds:\n\n{opponents.scores(rows)}")
        if flown.groups:
            rows = [item.row for group in flown.groups.values() for item in group]
            text.append(f"Opponents:\n\n{opponents.scores(rows)}")
        return "\n\n".join(text)

    def tables(self) -> str:
        """What stands between the markers of docs/agents.md."""
        text = [self.head(), "## Bars", self.bars()]
        text += ["## Collisions over deviation", "![Collisions over deviation](agents.svg)", opponents.LEGEND]
        for agent in self.plan.agents:
            where = f"Suite `{agent.suite}`, split `{agent.split}`, seed {agent.seed}."
            text += [f"## `{agent.name}`", where, self.scores(agent.name)]
        if self.ablations:
            flown = sorted({f"`{item.suite}`, seed {item.seed}" for item in self.plan.ablations})
            what = f"Trained with what each row names, and flown so in {', '.join(flown)}, split `suite`."
            text += ["## Ablations", what, opponents.scores(self.ablations)]
        return "\n\n".join([*text, "## Comparisons", self.comparisons(), opponents.made("bars", "")])

    def summary(self) -> str:
        """The README's table: the policies handed on."""
        rows = []
        for name, flown in self.flown.items():
            if flown.shipped:
                rows.append(opponents.Row(name, flown.shipped.row.episodes, flown.shipped.row.metrics))
        met = sum(item.verdict == VERDICTS[False][True] for item in self.judged)
        asked = sum(not item.bar.aim for item in self.judged)
        bars = f"{met} of {asked} bars met; [docs/agents.md](docs/agents.md) has each of them, and every seed."
        return f"{opponents.scores(rows)}\n\n{bars} {opponents.made('bars', self._where())}"

    def _where(self) -> str:
        """The encounters of the policies handed on."""
        found = {f"Split `{agent.split}`, seed {agent.seed}; " for agent in self.plan.agents if agent.policy}
        return "".join(sorted(found))

    def chart(self) -> str:
        """The agents' seeds beside the curves of the rules."""
        panels, single = {}, {}
        for name, flown in self.flown.items():
            by_rule: dict[str, list[Flight]] = {}
            for flight in (item for group in flown.groups.values() for item in group):
                by_rule.setdefault(re.split("[:@]", flight.name)[0], []).append(flight)
            panels[name] = {rule: best_curve(flights) for rule, flights in by_rule.items()}
            single[name] = [seed.row for seed in flown.seeds]
        label = "Collision rate over mean deviation: each agent's seeds beside the curves of the rules"
        none = {name: flown.none.row for name, flown in self.flown.items()}
        return opponents.chart(panels, none, single, "{}", label)
