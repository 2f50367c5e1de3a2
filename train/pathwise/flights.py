"""Records encounters as they were flown, from just before the first message on."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import torch

from rss_gym import observation
from rss_gym.baselines.agent import Agent
from rss_gym.baselines.features import FEATURES
from rss_gym.baselines.features.masks import kept as kept_columns
from rss_gym.core import Batch, decode

LEAD = 1  # decisions before the first message


@dataclass(frozen=True)
class Flights:
    """n encounters over T + 1 decisions, float32 tensors; vectors (T + 1, n, 3) in metres and seconds.

    Attributes
    ----------
    seen : dict of (T + 1, n) or (T + 1, n, 1) tensors
        The observation's fields and the facts of the features, in SI units.
    kept : (T + 1, n) tensor
        Whether the encounter had not ended by then.
    decisions : (n,) tensor
        Length of the whole flight.
    position, velocity, way_point : tensors
        Of the agent.
    position_error, velocity_error : tensors
        Of its solution.
    gust, intruder_velocity : tensors
        Over the decision that follows.
    planned, planned_velocity, along : tensors
        Of the agent; `along` is the unit vector of the leg.
    intruder : tensor
        True position.
    """

    seen: dict[str, torch.Tensor]
    kept: torch.Tensor
    decisions: torch.Tensor
    position: torch.Tensor
    velocity: torch.Tensor
    way_point: torch.Tensor
    position_error: torch.Tensor
    velocity_error: torch.Tensor
    gust: torch.Tensor
    planned: torch.Tensor
    planned_velocity: torch.Tensor
    along: torch.Tensor
    intruder: torch.Tensor
    intruder_velocity: torch.Tensor

    def __len__(self) -> int:
        """How many encounters."""
        return len(self.decisions)

    def of(self, chosen: torch.Tensor) -> Flights:
        """Some of the encounters."""
        parts: dict[str, Any] = {
            field.name: getattr(self, field.name)[:, chosen]
            for field in fields(self)
            if field.name not in ("seen", "decisions")
        }
        parts["seen"] = {name: values[:, chosen] for name, values in self.seen.items()}
        return Flights(decisions=self.decisions[chosen], **parts)


def record(batch: Batch, agent: Agent, window: int) -> tuple[Flights, list[dict[str, float]]]:
    """Fly the next episode in every row of `batch`.

    Parameters
    ----------
    batch : Batch
        Of worlds with one intruder.
    agent : Agent
    window : int
        Decisions kept of each encounter.

    Returns
    -------
    flights, episodes
        The encounters in which a message arrived, and of all of them what `Course` tells at their ends.
    """
    rows, world = batch.n, batch.params
    features = FEATURES[agent.network.features](world)
    mask, memory = kept_columns(agent.network.zeroed, world), np.zeros((rows, features.columns))
    batch.reset(np.ones(rows, bool))
    done, first, state = np.zeros(rows, bool), np.ones(rows, bool), None
    totals = {name: np.zeros(rows) for name in ("r", "l", "deviation_m")}
    steps: list[dict[str, np.ndarray]] = []
    while not done.all():
        actions, state = agent.predict(batch.observations, state, first)
        seen = observation.split(batch.observations * mask, world)
        now = seen | features.facts(seen, memory) | _state(batch, done)
        batch.step(decode(actions, world, rows), done)
        steps.append(now | _motion(batch))
        for name, values in (("r", batch.rewards), ("l", 1.0), ("deviation_m", batch.info("deviation_m"))):
            totals[name] += np.where(done, 0.0, values)
        done, first = done | batch.episode["terminated"] | batch.episode["truncated"], np.zeros(rows, bool)
    flown_by_row = {name: np.stack([step[name] for step in steps]) for name in steps[0]}
    heard = flown_by_row.pop("heard")
    chosen = np.flatnonzero(heard.any(axis=0))
    at = np.maximum(heard.argmax(axis=0)[chosen] - LEAD, 0) + np.arange(window + 1)[:, None]
    within = at < len(steps)
    at = np.minimum(at, len(steps) - 1)
    taken = {name: torch.as_tensor(values[at, chosen].astype(np.float32)) for name, values in flown_by_row.items()}
    taken["kept"] *= torch.as_tensor(within, dtype=torch.float32)
    length = batch.episode["ticks"][chosen] / world.clock.ticks_per_decision
    totals |= {"deviation_m": totals["deviation_m"] / totals["l"], "collision": batch.episode["collision"]}
    episodes = [{name: float(values[row]) for name, values in totals.items()} for row in range(rows)]
    own = {field.name for field in fields(Flights)}
    told = {name: value for name, value in taken.items() if name not in own}
    true: dict[str, Any] = {name: value for name, value in taken.items() if name in own}
    return Flights(seen=told, decisions=torch.as_tensor(length, dtype=torch.float32), **true), episodes


def _state(batch: Batch, done: np.ndarray) -> dict[str, np.ndarray]:
    """What is true before a decision, a copy."""
    agent, other = batch.world.aircraft[:, 0], batch.world.aircraft[:, 1]
    return {
        "heard": batch.others["valid"][:, 0].copy(),
        "kept": ~done,
        "position": agent["position_m"].copy(),
        "velocity": agent["velocity_mps"].copy(),
        "way_point": agent["way_point_m"].copy(),
        "position_error": batch.own["position_m"] - agent["position_m"],
        "velocity_error": batch.own["velocity_mps"] - agent["velocity_mps"],
        "planned": agent["planned_m"].copy(),
        "planned_velocity": agent["planned_mps"].copy(),
        "along": agent["along"].copy(),
        "intruder": other["position_m"].copy(),
    }


def _motion(batch: Batch) -> dict[str, np.ndarray]:
    """What holds through the decision just flown, a copy; gusts change before it."""
    agent, other = batch.world.aircraft[:, 0], batch.world.aircraft[:, 1]
    moved = other["velocity_mps"] + other["gust_mps"]
    return {"gust": agent["gust_mps"].copy(), "intruder_velocity": moved}
