"""Parts of pages that are made of the code when the site is built.

A line `<!-- generated: KIND ARGUMENT -->` of a page is replaced by Markdown: `card ID` describes a registered
environment, `listing TITLE` is a table of `rss-gym list`, `parameters GROUP` one of `rss-gym params`, and
`functions NUMBER` names the functions of an equation.
"""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import gymnasium as gym
import numba
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

from extensions import equations
from rss_gym.core import longest_episode
from rss_gym.env import EncounterEnv
from rss_gym.ids import IDS
from rss_gym.listing import listing, parameters
from rss_gym.observation import fields
from rss_gym.pages.table import Table
from rss_gym.params import Params
from rss_gym.tracking import TRACKERS

MARK = re.compile(r"^<!-- generated: (\w+) (.+?) -->$", re.MULTILINE)
CARD = re.compile(r"\.\./baselines/agents/([\w-]+)/card\.md")
LEVELS = {
    "positions": "messages of intruders hold positions and velocities",
    "ranges": "messages hold velocities only, and nobody knows a position",
    "oracle": "every field is the true state",
}


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table."""
    return Table(header, (list(map(str, row)) for row in rows)).markdown


def column(field: Any) -> str:
    """How a column of the observation is made of the value x in SI units."""
    if field.stretch > 0:
        return f"x / (abs(x) + {field.stretch:g})"
    return "x" if field.scale == 1 else f"x / {field.scale:g}"


def observations(table_of: Sequence[Any]) -> str:
    """The columns of an observation."""
    rows = [
        [number, f"`{f.name}`", f.meaning, f.unit, column(f), f"{f.low:g}", f"{f.high:g}"]
        for number, f in enumerate(table_of)
    ]
    return table(["number", "field", "meaning", "unit", "column", "low", "high"], rows)


def sections(docstring: str) -> dict[str, str]:
    """The parts of a docstring of an environment by their titles."""
    _, *parts = re.split(r"^## (.+)$", docstring, flags=re.MULTILINE)
    return {title: text.strip() for title, text in zip(parts[::2], parts[1::2], strict=True)}


def card(name: str) -> str:
    """The card of a registered environment.

    Parameters
    ----------
    name : str
        Its id.
    """
    plain, numba.config.DISABLE_JIT = (
        numba.config.DISABLE_JIT,
        0,
    )  # conf.py sets it; an environment is made here, not flown
    try:
        return encounter_card(name) if name in IDS else road_card(name)
    finally:
        numba.config.DISABLE_JIT = plain


def encounter_card(name: str) -> str:
    """The card of an id in the air: its docstring, with the numbers and the columns of this id."""
    keywords = IDS[name]
    params = Params.of(**keywords)
    env = gym.make(name, disable_env_checker=True)
    parts = sections(inspect.getdoc(EncounterEnv) or "")
    prices = params.reward
    levels = []
    for level, meaning in LEVELS.items():
        world = Params.of(**{**keywords, "information": level})
        trackers = ", ".join(f"`{key}`" for key, tracker in TRACKERS.items() if level in tracker.information)
        levels.append([f"`{level}`", meaning, len(fields(world)), trackers or "none is needed"])
    clock = params.clock
    charges = (
        (prices.deviation_price, "a metre of mean deviation"),
        (prices.snmac_price_m, "a near mid-air collision"),
        (prices.collision_price_m, "a collision"),
    )
    facts = [
        ["make", f'`gymnasium.make("{name}")`, `gymnasium.make_vec("{name}", num_envs=n)`'],
        ["keywords of this id", ", ".join(f"`{key}={value!r}`" for key, value in keywords.items()) or "none"],
        ["action", f"`{env.action_space}`"],
        ["observation", f"`Box` of {env.observation_space.shape[0]} columns, float32"],
        ["information", f"`{params.interface.information}`"],
        ["time of a decision", f"{clock.decision_s:g} s, with a tick of the radio every {clock.tick_s:g} s"],
        ["longest episode", f"{longest_episode(params)} decisions"],
        ["prices", ", ".join(f"{price:,g} m for {event}" for price, event in charges)],
    ]
    seen = "\n\n".join(p for p in parts["Observation space"].split("\n\n") if not p.lstrip().startswith("|"))
    seen = re.sub(
        r"These are the columns in space,[^;]*;", "The table has the columns of this id with one intruder;", seen
    )
    text = [parts["Description"], table(["property", "value"], facts)]
    text += ["## Action", parts["Action space"], "## Observation", seen, observations(fields(params))]
    text += ["## Levels of information", table(["`information`", "meaning", "columns", "trackers"], levels)]
    for title in ("Rewards", "Starting state", "Info", "Episode end", "Arguments", "Version history"):
        text += [f"## {title}", parts[title]]
    return "\n\n".join(text)


def road_card(name: str) -> str:
    """The card of a road."""
    from rss_gym.highway.env import SCENES, RoadEnv
    from rss_gym.highway.observation import fields as road_fields
    from rss_gym.ids import ROADS

    env = gym.make(name, disable_env_checker=True)
    params = env.unwrapped.params  # type: ignore[attr-defined]
    scene = SCENES[str(ROADS[name]["scene"])]
    parts = sections(inspect.getdoc(RoadEnv) or "")
    facts = [
        ["make", f'`gymnasium.make("{name}")`'],
        ["road", scene.summary],
        ["action", f"`{env.action_space}`"],
        ["observation", f"`Box` of {env.observation_space.shape[0]} columns, float32"],
        ["largest relative speed of the safety zone", f"{scene.speed_relative_max_mps:g} m/s"],
        ["longest episode", f"{scene.duration_s:g} s"],
    ]
    text = [parts.pop("Description"), table(["property", "value"], facts)]
    for title, body in parts.items():
        text += [f"## {title}", body]
        if title == "Observation space":
            text.append(observations(road_fields(params)))
    return "\n\n".join(text)


def listed(title: str) -> str:
    """A table of `rss-gym list`."""
    return table(["name", "what"], [[f"`{name}`", text] for name, text in listing()[title].items()])


def numbers(group: str) -> str:
    """The parameters of a group of `rss_gym.params.Params`."""
    rows = [
        [f"`{item['name']}`", item["meaning"], f"`{item['default']}`", item["unit"], item["range"]]
        for item in parameters()
        if item["group"] == group
    ]
    return table(["keyword", "meaning", "default", "unit", "range"], rows)


KINDS = {"card": card, "parameters": numbers, "listing": listed, "functions": equations.functions}


def fill(app: Sphinx, docname: str, source: list[str]) -> None:
    """Replace the marks of a page."""

    def made(mark: re.Match[str]) -> str:
        if mark[1] not in KINDS:
            raise ExtensionError(f"page {docname}: {mark[0]} is of an unknown kind; there are {', '.join(KINDS)}")
        return KINDS[mark[1]](mark[2])

    source[0] = CARD.sub(r"generated/\1.md", MARK.sub(made, source[0]))


def cards_of_agents(app: Sphinx) -> None:
    """A page for the card of each agent that comes with the package, as a card lies outside of the documents."""
    folder = Path(app.srcdir) / "generated"
    folder.mkdir(exist_ok=True)
    for file in sorted(Path(app.srcdir).parent.glob("baselines/agents/*/card.md")):
        source = os.path.relpath(file, folder)
        page = f"---\norphan: true\n---\n\n```{{include}} {source}\n:relative-images:\n```\n"
        (folder / f"{file.parent.name}.md").write_text(page, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """For Sphinx."""
    app.connect("builder-inited", cards_of_agents)
    app.connect("source-read", fill)
    return {"parallel_read_safe": True}
