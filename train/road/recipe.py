"""Recipes for roads: TOML files as the world's, with the keywords of a road as `[world]`."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rss_gym.baselines.road import POLICIES
from rss_gym.highway.env import RoadEnv
from rss_gym.ids import ROADS
from rss_gym.params import Group, ParamsError, number, suggestion
from rss_gym.train.hyperparameters import Ppo, PpoNetwork, Validation, group

FOLDER = Path(__file__).parent / "recipes"
SECTIONS = ("recipe", "world", "algorithm", "policy", "imitation", "validation")


@dataclass(frozen=True, slots=True, kw_only=True)
class Head(Group):
    """The table `[recipe]`."""

    summary: str = ""
    env: str = "rss_gym/Highway-v0"
    steps: int = number(20_480, 1, 10**9)  # decisions of one seed, over all rows
    n_envs: int = number(4, 1, 1024)

    def __post_init__(self) -> None:
        """Check the id."""
        Group.__post_init__(self)
        if not isinstance(self.env, str) or self.env not in ROADS:
            raise ParamsError(f"env = {self.env!r} is no road{suggestion(str(self.env), ROADS)}")


@dataclass(frozen=True, slots=True, kw_only=True)
class RoadImitation(Group):
    """The table `[imitation]`: what the actor learns before PPO; nothing where `episodes` is zero.

    Parameters
    ----------
    policy : str
        A scripted driver that chooses actions, as on the command line. It sees the vehicles, whatever the actor sees.
    episodes : int
        To drive.
    disturbance : float
        Share of its decisions that are replaced at random, so that states off its way are seen.
    epochs, batch_size : int
    learning_rate : float
    critic_steps : int
        So many first decisions of PPO teach the critic alone: one that knows nothing spoils the actor.
    """

    policy: str = "rule"
    episodes: int = number(0, 0, 10**5)
    disturbance: float = number(0.1, 0.0, 1.0)
    epochs: int = number(20, 1, 1000)
    batch_size: int = number(64, 1, 10**6)
    learning_rate: float = number(1e-3, 1e-8, 1.0)
    critic_steps: int = number(0, 0, 10**9)

    def __post_init__(self) -> None:
        """Check the name."""
        Group.__post_init__(self)
        known = [name for name, kind in POLICIES.items() if not kind.keywords]
        name = str(self.policy).partition(":")[0]
        if name not in known:
            raise ParamsError(f"policy = {self.policy!r} is no driver to imitate{suggestion(name, known)}")


@dataclass(frozen=True, kw_only=True)
class RoadRecipe:
    """A training on a road; `world` are keywords of its environment."""

    name: str
    head: Head
    world: dict[str, Any]
    hyperparameters: Ppo
    policy: PpoNetwork
    imitation: RoadImitation
    validation: Validation

    def __post_init__(self) -> None:
        """Check what several tables decide together."""
        if self.policy.zeroed != "nothing":
            raise ParamsError(
                f"[policy]: zeroed must be 'nothing' on a road, got {self.policy.zeroed!r}; "
                "world.radio = false takes the vehicles' fields away"
            )
        total = self.hyperparameters.n_steps * self.head.n_envs
        if total % self.hyperparameters.batch_size:
            raise ParamsError(
                f"[algorithm]: batch_size must divide n_steps * n_envs = {total}, got {self.hyperparameters.batch_size}"
            )
        if self.imitation.episodes and self.imitation.critic_steps >= self.head.steps:
            raise ParamsError(
                f"[imitation]: critic_steps must be below the {self.head.steps} steps of the training, got "
                f"{self.imitation.critic_steps}: the actor would not learn"
            )

    @property
    def radio(self) -> bool:
        """Whether the actor sees the other vehicles."""
        return bool(self.world.get("radio", True))

    def environment(self, **changes: Any) -> RoadEnv:
        """The road, new."""
        keywords: dict[str, Any] = {**ROADS[self.head.env], **self.world, **changes}
        return RoadEnv(**keywords)

    def to_dict(self) -> dict[str, Any]:
        """The tables of its file, with every default, in plain JSON types."""
        return {
            "recipe": self.head.to_dict(),
            "world": self.world,
            "algorithm": self.hyperparameters.to_dict(),
            "policy": self.policy.to_dict(),
            "imitation": self.imitation.to_dict(),
            "validation": self.validation.to_dict(),
        }


def recipes() -> dict[str, Path]:
    """The shipped recipes: name -> TOML file."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.toml"))}


def is_road(source: str) -> bool:
    """Whether this names a recipe for a road, by its name or by the id in the file."""
    if source in recipes():
        return True
    try:
        table = tomllib.loads(Path(source).read_text(encoding="utf-8")).get("recipe")
    except (OSError, ValueError, RecursionError):  # the loader says what is wrong
        return False
    env = table.get("env") if isinstance(table, Mapping) else None
    return isinstance(env, str) and env in ROADS


def load(source: str | os.PathLike[str], changes: Mapping[str, Any] | None = None) -> RoadRecipe:
    """A recipe by its name or from a TOML file, with `section.key` -> value changed.

    Raises
    ------
    ParamsError
        When the file is not a recipe for a road: the sentence names file, key and value.
    """
    text = os.fspath(source)
    path = recipes().get(text) or Path(text)
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise ParamsError(f"recipe file {text!r} is not readable TOML: {error}") from error
    for key, value in (changes or {}).items():
        section, _, name = key.partition(".")
        if section not in SECTIONS or not name:
            raise ParamsError(f"--set {key}: write section.key=value, such as algorithm.learning_rate=3e-4")
        tables.setdefault(section, {})[name] = value
    return from_dict(path.stem, tables)


def from_dict(name: str, tables: Mapping[str, Any]) -> RoadRecipe:
    """The recipe of these tables, as in a file or from `RoadRecipe.to_dict`.

    Raises
    ------
    ParamsError
        As `load`.
    """
    try:
        for section, table in tables.items():
            if section not in SECTIONS:
                raise ParamsError(f"a recipe for a road has no table {section!r}{suggestion(section, SECTIONS)}")
            if not isinstance(table, Mapping):
                raise ParamsError(f"[{section}] must be a table")
        return RoadRecipe(
            name=name,
            head=group("recipe", Head(), tables),
            world=dict(tables.get("world", {})),
            hyperparameters=group("algorithm", Ppo(), tables),
            policy=group("policy", PpoNetwork(), tables),
            imitation=group("imitation", RoadImitation(), tables),
            validation=group("validation", Validation(every_steps=5_120, episodes=50), tables),
        )
    except ParamsError as error:
        raise ParamsError(f"recipe {name!r}: {error}") from error
