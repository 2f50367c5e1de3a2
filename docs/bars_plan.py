"""Reads docs/bars.toml: who flies what and how often, and what is asked; all of it fixed before the flight."""

import dataclasses
import tomllib
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any, get_args, get_origin

from bars_asked import EVENTS, KINDS, AtMost, Bar, CollisionsAtDeviation, FewerEvents

from rss_gym.core import SPLITS
from rss_gym.eval.metrics import METRICS
from rss_gym.eval.suites import find
from rss_gym.params import ParamsError, suggestion

KINDS_OF_VALUE = {
    bool: "true or false",
    int: "a whole number >= 0",
    float: "a number",
    str: "a string",
    tuple: "a list",
    dict: "a table",
}


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Settings of an opponent: every combination of the values of its options; without options its defaults."""

    group: str
    policy: str
    encounters: int
    options: dict[str, list] = field(default_factory=dict)

    @property
    def specs(self) -> list[str]:
        """Names of `rss_gym.baselines.make`."""
        texts = (
            ",".join(f"{name}={value:g}" for name, value in zip(self.options, values, strict=True))
            for values in product(*self.options.values())
        )
        return [f"{self.policy}:{text}" if text else self.policy for text in texts]


@dataclass(frozen=True, kw_only=True)
class World:
    """Another world that the shipped policy flies in: the suite with changes of parameters."""

    name: str
    encounters: int
    changes: dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Ablation:
    """A policy trained with something taken away or given, flown in a suite with changes of parameters."""

    what: str
    policy: str
    suite: str
    encounters: int
    seed: int = 0
    changes: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Agent:
    """A trained agent: its seeds, the one that is handed on, its opponents and its bars.

    Parameters
    ----------
    name, suite, split : str
    seed : int
        Of the encounters.
    seeds : tuple of str
        Policy folders of trainings that differ in their seed only.
    policy : str
        The one handed on, equal to one of the seeds; empty where none is.
    encounters, seed_encounters : int
        Of the policy handed on, and of each other seed.
    """

    name: str
    suite: str
    seeds: tuple[str, ...]
    seed_encounters: int
    encounters: int = 0
    policy: str = ""
    split: str = "suite"
    seed: int = 0
    opponents: tuple[Grid, ...] = ()
    worlds: tuple[World, ...] = ()
    bars: tuple[Bar, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Plan:
    """All of it.

    Parameters
    ----------
    sealed : str
        Digest of the learned policies that the plan names; a flight with others is refused.
    alpha : float
        Error of all comparisons together.
    """

    sealed: str
    alpha: float
    agents: tuple[Agent, ...]
    ablations: tuple[Ablation, ...] = ()


def load(path: Path) -> Plan:
    """The plan in a file.

    Raises
    ------
    ParamsError
        For what is unknown, missing, of the wrong type, or in contradiction; the sentence names file, table and field.
    """
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ParamsError(f"plan {path.name} cannot be read: {error}") from error
    try:
        return _plan(table)
    except ParamsError as error:
        raise ParamsError(f"plan {path.name}: {error}") from error


def _plan(table: dict[str, Any]) -> Plan:
    agents = tuple(_agent(name, dict(value)) for name, value in _tables("agents", table.pop("agents", {})))
    if not agents:
        raise ParamsError("there is no table [agents.NAME]")
    ablations = tuple(_made(Ablation, value, "[[ablations]]") for value in _listed(table, "ablations", "the head"))
    plan = _made(Plan, table | {"agents": agents, "ablations": ablations}, "the head")
    if not 0.0 < plan.alpha < 1.0:
        raise ParamsError(f"alpha must lie between 0 and 1, got {plan.alpha!r}")
    for item in ablations:
        find(item.suite).changed(**item.changes)
    return plan


def _agent(name: str, table: dict[str, Any]) -> Agent:
    where = f"[agents.{name}]"
    opponents = tuple(_grid(value, where) for value in _listed(table, "opponents", where))
    worlds = tuple(_made(World, value, f"{where}, worlds") for value in _listed(table, "worlds", where))
    bars = tuple(_bar(value, where) for value in _listed(table, "bars", where))
    parts = {"name": name, "opponents": opponents, "worlds": worlds, "bars": bars}
    agent = _made(Agent, table | parts, where)
    _check(agent, where)
    return agent


def _grid(table: dict[str, Any], where: str) -> Grid:
    own = {item.name for item in dataclasses.fields(Grid)} - {"options"}
    options = {name: value for name, value in table.items() if name not in own}
    for name, values in options.items():
        if not isinstance(values, list) or not values or any(type(value) not in (int, float) for value in values):
            raise ParamsError(f"{where}, opponents: {name} must be a list of numbers, got {values!r}")
    return _made(Grid, {name: table[name] for name in own & set(table)} | {"options": options}, f"{where}, opponents")


def _bar(table: dict[str, Any], where: str) -> Bar:
    kind = table.pop("kind", None)
    if kind not in KINDS:
        raise ParamsError(f"{where}, bars: kind {kind!r} is unknown{suggestion(str(kind), KINDS)}")
    return _made(KINDS[kind], table, f"{where}, bars, kind {kind!r}")


def _check(agent: Agent, where: str) -> None:
    """Refuse what names something that the plan does not hold."""
    suite = find(agent.suite)
    if agent.split not in SPLITS:
        raise ParamsError(f"{where}: split {agent.split!r} is unknown{suggestion(agent.split, SPLITS)}")
    if not agent.seeds:
        raise ParamsError(f"{where}: seeds must name at least one policy folder")
    if agent.policy and not agent.encounters:
        raise ParamsError(f"{where} lacks the field 'encounters', those of policy {agent.policy!r}")
    if agent.worlds and not agent.policy:
        raise ParamsError(f"{where}: worlds need policy, the one that flies in them")
    for world in agent.worlds:
        suite.changed(**world.changes)
    specs = [spec for grid in agent.opponents for spec in grid.specs]
    for spec in specs:
        if specs.count(spec) > 1:
            raise ParamsError(f"{where}, opponents: {spec!r} is given twice")
    groups, worlds = {grid.group for grid in agent.opponents}, {world.name for world in agent.worlds}
    for bar in agent.bars:
        of = f"{where}, bars, {bar.asked!r}"
        for group in bar.against:
            _known(f"{of}: group", group, groups)
        if bar.world:
            _known(f"{of}: world", bar.world, worlds)
        if isinstance(bar, AtMost):
            _known(f"{of}: metric", bar.metric, METRICS)
        if bar.compares and not bar.against:
            raise ParamsError(f"{of}: against must name groups of opponents")
        if isinstance(bar, FewerEvents):
            for event in bar.events:
                _known(f"{of}: event", event, EVENTS)
        if not agent.policy and not (isinstance(bar, CollisionsAtDeviation) and bar.every_seed):
            raise ParamsError(f"{of}: it judges the policy that is handed on, and {where} names none")


def _known(what: str, name: str, known: Any) -> None:
    if name not in known:
        raise ParamsError(f"{what} {name!r} is unknown{suggestion(name, known)}")


def _tables(name: str, value: Any) -> Any:
    if not isinstance(value, dict) or not all(isinstance(item, dict) for item in value.values()):
        raise ParamsError(f"{name} must be tables [{name}.NAME], got {value!r}"[:300])
    return value.items()


def _listed(table: dict[str, Any], name: str, where: str) -> list[dict[str, Any]]:
    """Take a list of tables out of a table."""
    value = table.pop(name, [])
    if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
        raise ParamsError(f"{where}: {name} must be a list of tables, got {value!r}"[:300])
    return value


def _made(kind: type, table: dict[str, Any], where: str) -> Any:
    """The dataclass from a table, its names and types checked; lists become tuples."""
    known = {item.name: item for item in dataclasses.fields(kind)}
    values = {}
    for name, value in table.items():
        if name not in known:
            raise ParamsError(f"{where} has no field {name!r}{suggestion(name, known)}")
        values[name] = _typed(value, known[name].type, f"{where}: {name}")
        if name.endswith("encounters") and values[name] < 1:
            raise ParamsError(f"{where}: {name} must be at least 1, got {values[name]!r}")
    for name, item in known.items():
        if name not in values and item.default is dataclasses.MISSING and item.default_factory is dataclasses.MISSING:
            raise ParamsError(f"{where} lacks the field {name!r}")
    return kind(**values)


def _typed(value: Any, wanted: Any, where: str) -> Any:
    """The value, if it is of the type that a field is declared with."""
    if get_origin(wanted) is tuple and isinstance(value, (list, tuple)):
        inner = get_args(wanted)[0]
        return tuple(_typed(item, inner, where) for item in value)
    if wanted is float and type(value) is int:
        value = float(value)
    plain = get_origin(wanted) or wanted
    is_wrong = not isinstance(value, plain) or (isinstance(value, bool) and plain is not bool)
    if is_wrong or (plain is int and value < 0):
        raise ParamsError(f"{where} must be {KINDS_OF_VALUE[plain]}, got {value!r}"[:300])
    return value
