"""Whether the translated world scores as Python's does: flights of many encounters in both, column by column."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from rss_gym.baselines.agent import load
from rss_gym.baselines.policy import Policy
from rss_gym.baselines.shipped import AGENTS
from rss_gym.eval.episodes import Block, fly_all
from rss_gym.eval.suites import Suite
from rss_gym.fly.engines import result_of
from rss_gym.fly.world import program

COLUMNS = (
    "cost_m", "min_separation_m", "closest_s", "deviation_mean_m", "deviation_max_m", "flown_m", "zone_severity",
    "warned_s", "collision", "snmac", "zone", "false_alerts",
)  # fmt: skip
# Who flies: the agent, or the same sequence of commands in every encounter, which goes where no policy would.
PILOTS = {
    "agent": "rssWorld.think",
    "weave": "(flight) => [37, 53].map((n) => (n * flight.decisions % 201 - 100) / 100)",
}


class Weave:
    """Commands that depend on the number of the decision alone."""

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """The same action in every row; the state is the number of the decision."""
        decision = 0 if state is None else int(state[0])
        action = [(n * decision % 201 - 100) / 100 for n in (37, 53)]
        return np.tile(np.array(action, np.float32), (len(observation), 1)), np.full(len(observation), decision + 1)


@dataclass(frozen=True)
class Comparison:
    """Scores of the same encounters by Python and by JavaScript.

    Parameters
    ----------
    title : str
        Suite, pilot, and what ran the JavaScript.
    python, javascript : (n, columns) arrays
        The columns `COLUMNS`, flags as 0 and 1.
    """

    title: str
    python: np.ndarray
    javascript: np.ndarray

    @property
    def equal(self) -> int:
        """Encounters of which every column has the same bits."""
        return int(np.all(self.python.view(np.uint64) == self.javascript.view(np.uint64), axis=1).sum())

    @property
    def largest(self) -> dict[str, float]:
        """Largest difference in each column, in its unit."""
        return dict(zip(COLUMNS, np.abs(self.python - self.javascript).max(axis=0).tolist(), strict=True))

    @property
    def summary(self) -> str:
        """What was compared and what came out, one line, and one for each column that differs."""
        collisions = int(self.python[:, COLUMNS.index("collision")].sum())
        lines = [
            f"{self.title}: {self.equal} of {len(self.python)} encounters ({collisions} with a collision) have the "
            f"same bits in all {len(COLUMNS)} scores"
        ]
        return "\n".join([*lines, *(f"  {name} differs by up to {d:g}" for name, d in self.largest.items() if d)])


def compare(suite: Suite, agent: str, numbers: range, engine: str, pilot: str = "agent") -> Comparison:
    """Fly encounters in both languages.

    Parameters
    ----------
    suite : Suite
    agent : str
        A shipped agent.
    numbers : range
        Consecutive numbers of encounters.
    engine : str
        One of `rss_gym.fly.engines.engines()`.
    pilot : str
        One of `PILOTS`.
    """
    flown = load(AGENTS[agent], suite.params)
    policy: Policy = flown if pilot == "agent" else Weave()
    table = fly_all(policy, pilot, flown.params, Block(suite.split, suite.seed, numbers))
    python = np.stack([table[name].astype(np.float64) for name in COLUMNS], axis=1)
    code = program(suite, flown) + _script(numbers, PILOTS[pilot])
    rows = np.array(json.loads(result_of(code, engine)), np.float64)
    return Comparison(f"{suite.name}, {agent if pilot == 'agent' else pilot}, {engine}", python, rows)


def _script(numbers: range, act: str) -> str:
    """Code that leaves the scores in `result`; JSON holds every double exactly."""
    return (
        f"const result = JSON.stringify(Array.from({{length: {len(numbers)}}}, (_, k) => {{\n"
        f"  const {{ episode }} = rssWorld.fly({numbers.start} + k, {act});\n"
        f"  return {json.dumps(COLUMNS)}.map((name) => Number(episode[name]));\n"
        "}));\n"
    )
