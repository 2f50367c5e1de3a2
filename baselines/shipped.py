"""The learned policies that come with the package: a folder each in `agents/`, whose name is the policy's.

`rss_gym.train.ship` makes these folders from trainings, in the air and on roads.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from rss_gym.baselines.agent import load
from rss_gym.baselines.policy_files import DOCUMENT
from rss_gym.params import Params, ParamsError

FOLDER = Path(__file__).parent / "agents"
CARD = "card.md"


def found(folder: Path = FOLDER) -> dict[str, Path]:
    """Name -> policy folder of those in a folder."""
    return {path.parent.name: path.parent for path in sorted(folder.glob(f"*/{DOCUMENT}"))}


AGENTS = found()


def fits(name: str, params: Params) -> bool:
    """Whether the agent was made for this world: its information, fields and axes."""
    try:
        load(AGENTS[name], params)
    except ParamsError:
        return False
    return True


def home(name: str) -> str:
    """The id that the agent was trained in."""
    return str(_recipe(AGENTS[name])["recipe"]["env"])


def summary(folder: Path) -> str:
    """One line for listings."""
    recipe = _recipe(folder)
    head, blind = recipe["recipe"], recipe["policy"]["zeroed"] == "radio"
    return f"Learned in {head['env']}{', blind to the others' if blind else ''}: {head['summary']}."


def _recipe(folder: Path) -> dict[str, Any]:
    """The recipe, which every shipped policy records."""
    document = json.loads((folder / DOCUMENT).read_text(encoding="utf-8"))
    recipe: dict[str, Any] = document["training"]["recipe"]
    return recipe
