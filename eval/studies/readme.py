"""What the documents copy: the README's animation and the training that it quotes, and the list of docs/agents.md."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from pathlib import Path

import gymnasium as gym

from rss_gym import baselines
from rss_gym.baselines import shipped
from rss_gym.eval.studies.study import Part
from rss_gym.pages.table import Table
from rss_gym.params import Params, ParamsError
from rss_gym.render import film

# Nobody giving way would end in a collision.
SHOWN_SEED, RULE = 9, "orthogonal:radius_m=40"
WIDTH_PX, EVERY = 440, 3
ANIMATION = "docs/img/encounter.gif"
EXAMPLE = Path("examples/sb3_ppo.py")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """None of its own."""


def run(options: argparse.Namespace) -> Iterator[Part]:
    """The example without its first line, the agents, and an encounter."""
    root = options.pages or Path()
    try:
        text = (root / EXAMPLE).read_text(encoding="utf-8")
    except OSError as error:
        raise ParamsError(
            f"example {str(root / EXAMPLE)!r} cannot be read; --pages names the root of a clone"
        ) from error
    _, _, code = text.partition('"""\n\n')
    yield Part(f"```python\n{code}```", "README.md", mark="sb3")
    yield Part(agents(root), "docs/agents.md", mark="agents")
    yield Part(f"animation: {ANIMATION}", ANIMATION, animation())


def agents(root: Path) -> str:
    """Those that are shipped, in Markdown; links lead from docs/."""
    docs = (root / "docs").resolve()
    rows = [
        [
            f"[`{name}`]({Path(os.path.relpath(folder.resolve(), docs)).as_posix()}/{shipped.CARD})",
            f"`{shipped.home(name)}`",
            shipped.summary(folder),
        ]
        for name, folder in baselines.AGENTS.items()
    ]
    shown = Table(["agent and card", "trained in", "how"], rows).markdown
    return shown if rows else "This version comes without an agent."


def animation() -> bytes:
    """A GIF of the rule of the paper and, beside it, the first agent of this world, or another rule without one."""
    able = baselines.able(Params())
    agent = next((name for name in able if name in baselines.AGENTS), "orca")
    env = gym.make("rss_gym/Encounter-v0", disable_env_checker=True)
    flights = [film.fly(env, baselines.make(name), name, SHOWN_SEED) for name in (RULE, agent)]
    return film.animated(film.frames(flights, WIDTH_PX, EVERY), EVERY)
