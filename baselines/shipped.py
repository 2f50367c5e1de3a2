"""The learned policies that come with the package: a folder each in `agents/`, whose name is the policy's.

`docs/agents.py` makes these folders from trainings; those of drivers are in `road/agents/`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from rss_gym.baselines.agent import Agent, load
from rss_gym.baselines.policy_files import DOCUMENT
from rss_gym.params import Params, ParamsError

FOLDER = Path(__file__).parent / "agents"


def found(folder: Path = FOLDER) -> dict[str, Path]:
    """Name -> policy folder of those in a folder."""
    return {path.parent.name: path.parent for path in sorted(folder.glob(f"*/{DOCUMENT}"))}


AGENTS = found()


def make(name: str, params: Params | None = None, track: str | None = None) -> Agent:
    """The shipped agent of that name.

    Parameters
    ----------
    name : str
        One of `AGENTS`.
    params : Params, optional
        As `rss_gym.baselines.agent.load` takes it.
    track : str, optional
        Must be the agent's own.

    Raises
    ------
    ParamsError
        For a world that it was not made for, or another track.
    """
    agent = load(AGENTS[name], params, f"policy {name!r}, trained in {home(name)}")
    own = agent.world.interface.track
    if track not in (None, own):
        raise ParamsError(
            f"policy {name!r} cannot fly on track {track!r}: it was trained on {own!r} and flies there only"
        )
    return agent


def fits(name: str, world: Params) -> bool:
    """Whether the agent can fly in this world, on its track."""
    try:
        return make(name, world).world.interface.track == world.interface.track
    except ParamsError:
        return False


def home(name: str) -> str:
    """The id that the agent was trained in."""
    return str(_recipe(AGENTS[name])["recipe"]["env"])


def summary(folder: Path) -> str:
    """One line for listings."""
    recipe = _recipe(folder)
    head, blind = recipe["recipe"], recipe["world"].get("radio") is False
    return f"Learned in {head['env']}{', blind to the others' if blind else ''}: {head['summary']}."


def _recipe(folder: Path) -> dict[str, Any]:
    """The recipe, which every shipped policy records."""
    document = json.loads((folder / DOCUMENT).read_text(encoding="utf-8"))
    recipe: dict[str, Any] = document["training"]["recipe"]
    return recipe
