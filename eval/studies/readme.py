"""What the documents copy: the README's picture and the training that it quotes, and the list of docs/agents.md."""

from __future__ import annotations

import argparse
import io
import os
from collections.abc import Iterator
from pathlib import Path

import gymnasium as gym
import numpy as np

from rss_gym import baselines
from rss_gym.baselines import shipped
from rss_gym.eval.studies.study import Part, table
from rss_gym.params import ParamsError

SHOWN_SEED, SHOWN_S = 19, 29.0
EXAMPLE = Path("examples/sb3_ppo.py")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """None of its own."""


def run(options: argparse.Namespace) -> Iterator[Part]:
    """The example without its first line, the agents, and one frame of the rule in flight."""
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
    yield Part("picture: docs/encounter.png", "docs/encounter.png", picture())


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
    return table(["agent and card", "trained in", "how"], rows) if rows else "This version comes without an agent."


def picture() -> bytes:
    """A PNG of one frame."""
    from PIL import Image

    policy = baselines.make("orthogonal:radius_m=60")
    env = gym.make("rss_gym/Encounter-v0", render_mode="rgb_array")
    observation, _ = env.reset(seed=SHOWN_SEED)
    state = None
    for _ in range(int(SHOWN_S / policy.params.clock.decision_s)):
        action, state = policy.predict(observation, state)
        observation, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            break
    file = io.BytesIO()
    Image.fromarray(np.asarray(env.render())).save(file, "png", optimize=True)
    return file.getvalue()
