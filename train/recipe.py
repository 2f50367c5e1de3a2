"""Recipes: everything that decides a training, in one TOML file.

`recipes/` holds the shipped ones; a new recipe is one file there.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from rss_gym import baselines
from rss_gym.baselines.policy import Scripted
from rss_gym.domain import ROAD, Domain, domain_of_id
from rss_gym.ids import IDS, ROADS
from rss_gym.params import Params, ParamsError, suggestion
from rss_gym.plain_files import read_toml
from rss_gym.schema import (
    Kind,
    Schema,
    argument,
    checked,
    listed,
    one_of,
    real,
    refuse_unknown,
    shown,
    table,
    text,
    whole,
)
from rss_gym.train.hyperparameters import (
    ALGORITHMS,
    Checkpoint,
    Imitation,
    Pathwise,
    Ppo,
    PpoNetwork,
    Sac,
    SacNetwork,
    Validation,
    Vec,
    group,
)

FOLDER = Path(__file__).parent / "recipes"
STEPS_MAX = 10**12
STAGES_MAX = 1000
SIZE_MAX = 65536  # bytes
SECTIONS: Schema = {
    **dict.fromkeys(("recipe", "world", "vec", "algorithm", "policy", "imitation"), table("a table")),
    "curriculum": listed(0, STAGES_MAX, f"a list of tables, at most {STAGES_MAX}"),
    **dict.fromkeys(("validation", "checkpoint"), table("a table")),
}
IMITATORS = ("pathwise", "ppo")
DISCRETE = ("ppo", "recurrent-ppo")  # that can choose among discrete actions
HEAD: Schema = {
    "summary": text(),
    "algorithm": one_of(ALGORITHMS),
    "env": one_of({**IDS, **ROADS}),
    "steps": whole(1, STEPS_MAX),
}
START = Kind(lambda value: real(0.0, 1.0).test(value) and value < 1.0, "a fraction of the steps in [0, 1)")


@dataclass(frozen=True, slots=True)
class Stage:
    """From the fraction `start` of the steps on, the world has these parameters."""

    start: float
    world: dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """A training.

    Parameters
    ----------
    name, summary : str
    algorithm : str
        One of `ALGORITHMS`.
    env : str
        A registered id.
    steps : int
        Decisions of one seed, over all rows.
    world : dict
        Parameters that differ from those of the id; several channels are drawn from once per episode.
    vec, hyperparameters, policy, imitation, validation, checkpoint : Group
        The tables.
    curriculum : tuple of Stage
        In order; before the first one the world is `world`, which is also the world of the validation.
    """

    name: str
    summary: str
    algorithm: str
    env: str
    steps: int
    world: dict[str, Any]
    vec: Vec
    hyperparameters: Ppo | Sac | Pathwise
    policy: PpoNetwork | SacNetwork
    imitation: Imitation
    curriculum: tuple[Stage, ...]
    validation: Validation
    checkpoint: Checkpoint

    def __post_init__(self) -> None:
        """Check what several tables decide together."""
        params = self.params
        if params.interface.action == "discrete":
            raise ParamsError("[world]: action 'discrete' cannot be exported; use velocity")
        if self.domain is ROAD and self.algorithm not in DISCRETE:
            raise ParamsError(
                f"[recipe]: algorithm {self.algorithm!r} cannot choose a road's discrete actions; use ppo"
            )
        if not self.world.get("radio", True):
            raise ParamsError(
                "[world]: radio = false is of the environment alone; [policy] zeroed = 'radio' takes the vehicles' "
                "fields from the policy, which then drives without them everywhere"
            )
        for previous, stage in pairwise((Stage(-1.0, {}), *self.curriculum)):
            if stage.start <= previous.start:
                raise ParamsError(f"[[curriculum]]: start = {stage.start:g} must exceed {previous.start:g} before it")
            later = self._with(stage.world)
            if later.interface != params.interface or self.domain.spaces(later) != self.domain.spaces(params):
                raise ParamsError(
                    f"[[curriculum]]: the stage from {stage.start:g} changes what the policy sees or does; "
                    "information, action, planar and intruders belong to [world]"
                )
        if isinstance(self.hyperparameters, Ppo):
            if self.hyperparameters.use_sde and self.domain is ROAD:
                raise ParamsError("[algorithm]: use_sde explores continuous actions; a road has discrete ones")
            total = self.hyperparameters.n_steps * self.vec.n_envs
            if total % self.hyperparameters.batch_size:
                raise ParamsError(
                    f"[algorithm]: batch_size must divide n_steps * n_envs = {total}, got "
                    f"{self.hyperparameters.batch_size}"
                )
        if self.algorithm == "pathwise" and (self.vec.stack > 1 or self.vec.normalise_observation):
            raise ParamsError("[vec]: pathwise needs stack = 1 and normalise_observation = false")
        if self.imitation.episodes:
            if self.algorithm not in IMITATORS:
                raise ParamsError(
                    f"[imitation]: only the actors of {' and '.join(IMITATORS)} can imitate, got algorithm "
                    f"{self.algorithm!r}"
                )
            _ = self.teacher  # refuses what cannot be imitated

    @property
    def domain(self) -> Domain:
        """Air or road."""
        return domain_of_id(self.env)

    @property
    def teacher(self) -> Scripted:
        """The rule that is imitated.

        Raises
        ------
        ParamsError
            If there is no such rule, or it does not fly with the interface of the world.
        """
        name, wanted = self.imitation.policy, self.params.interface
        try:
            teacher = baselines.make(name, self.params)
        except ParamsError as error:
            raise ParamsError(f"[imitation]: {error}") from error
        if not isinstance(teacher, Scripted):
            raise ParamsError(f"[imitation]: policy must name a scripted rule, got {name!r}")
        if type(teacher).home(self.params) != self.params:
            raise ParamsError(f"[imitation]: policy {name!r} is a driver of highway-env, which chooses no actions")
        found = teacher.params.interface
        if found.information != wanted.information:
            raise ParamsError(
                f"[imitation]: policy {name!r} flies with information = {found.information!r}, and [world] has "
                f"{wanted.information!r}; set one to the other"
            )
        return teacher

    @property
    def params(self) -> Params:
        """The world, without the curriculum."""
        return self._with({})

    def stage(self, steps: int) -> int:
        """How many stages of the curriculum have begun after so many steps."""
        return sum(steps >= stage.start * self.steps for stage in self.curriculum)

    def params_of(self, stage: int) -> Params:
        """The world of a stage, counted from 1; 0 is `params`."""
        return self._with(self.curriculum[stage - 1].world if stage else {})

    def _with(self, changes: dict[str, Any]) -> Params:
        params = self.domain.params({**self.domain.ids[self.env], **self.world, **changes})
        self.domain.families(params)  # refuses those that do not exist
        return params

    def to_dict(self) -> dict[str, Any]:
        """The tables of its file, with every default, in plain JSON types."""
        return {
            "recipe": {name: getattr(self, name) for name in HEAD},
            "world": self.world,
            "vec": self.vec.to_dict(),
            "algorithm": self.hyperparameters.to_dict(),
            "policy": self.policy.to_dict(),
            "imitation": self.imitation.to_dict(),
            "curriculum": [{"start": stage.start, **stage.world} for stage in self.curriculum],
            "validation": self.validation.to_dict(),
            "checkpoint": self.checkpoint.to_dict(),
        }


def recipes() -> dict[str, Path]:
    """The shipped recipes: name -> TOML file."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.toml"))}


def load(source: str | os.PathLike[str], changes: Mapping[str, Any] | None = None) -> Recipe:
    """A recipe by its name or from a TOML file.

    Parameters
    ----------
    source : str or path
    changes : mapping, optional
        `section.key` -> value, put into the file's tables before they are checked; `curriculum` -> list of tables.

    Raises
    ------
    ParamsError
        When no recipe or file has that name, or the file is not a recipe: the sentence names file, key and value.
    """
    text, shipped = os.fspath(source), recipes()
    path = shipped.get(text) or Path(text)
    if text not in shipped and not os.path.exists(path):
        if path.suffix == ".toml" or len(path.parts) > 1:
            raise ParamsError(f"recipe file {text!r} does not exist")
        raise ParamsError(f"recipe {text!r} is unknown{suggestion(text, shipped)}")
    try:
        tables = read_toml(path, SIZE_MAX)
    except ParamsError as error:
        raise ParamsError(f"recipe file {text!r} {error}") from error
    for key, value in (changes or {}).items():
        section, _, name = key.partition(".")
        refuse_unknown("--set", "", {section: value}, SECTIONS)
        if name and section != "curriculum":
            fields = tables.setdefault(section, {})
            if isinstance(fields, dict):  # else refused below
                fields[name] = value
        elif section == "curriculum" and not name:
            tables[section] = value
        else:
            raise ParamsError(f"--set {key}: write section.key=value, such as algorithm.learning_rate=3e-4")
    return from_dict(path.stem, tables)


def from_dict(name: str, tables: Mapping[str, Any]) -> Recipe:
    """The recipe of these tables, as in a file or from `Recipe.to_dict`.

    Raises
    ------
    ParamsError
        As `load`.
    """
    empty: dict[str, Any] = {section: [] if section == "curriculum" else {} for section in SECTIONS}
    try:
        tables = checked("", "", empty | dict(tables), SECTIONS)
        head = checked("[recipe]", "", {"summary": ""} | tables["recipe"], HEAD)
        kind = ALGORITHMS[head["algorithm"]]
        return Recipe(
            name=name,
            **head,
            world=_world(tables["world"]),
            vec=group("vec", Vec(), tables),
            hyperparameters=group("algorithm", kind.hyperparameters(), tables),
            policy=group("policy", kind.network(), tables),
            imitation=group("imitation", Imitation(), tables),
            curriculum=tuple(_stage(table) for table in tables["curriculum"]),
            validation=group("validation", Validation(), tables),
            checkpoint=group("checkpoint", Checkpoint(), tables),
        )
    except ParamsError as error:
        raise ParamsError(f"recipe {name!r}: {error}") from error


def parse_changes(items: Iterable[str]) -> dict[str, Any]:
    """`key=value` of a command line, the value as in TOML, or else the text itself.

    Raises
    ------
    ParamsError
        Without `=`.
    """
    found: dict[str, Any] = {}
    for item in items:
        key, equals, value = item.partition("=")
        if not equals or not key.strip():
            raise ParamsError(f"--set {item!r} must be key=value")
        try:
            found[key.strip()] = tomllib.loads(f"value = {value}")["value"]
        except (tomllib.TOMLDecodeError, RecursionError):
            found[key.strip()] = value.strip()
    return found


def _world(table: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters, with channels as numbers: a recipe that is kept must not change with a file it named."""
    world = dict(table)
    if "channel" in world:
        world["channel"] = [channel.to_dict() for channel in Params.of(channel=world["channel"]).channels]
    return world


def _stage(given: Any) -> Stage:
    if not isinstance(given, Mapping) or "start" not in given:
        raise ParamsError(f"[[curriculum]]: a stage is a table with start, got {shown(given)}")
    start = argument("[[curriculum]]: start", given["start"], START)
    return Stage(float(start), _world({key: item for key, item in given.items() if key != "start"}))
