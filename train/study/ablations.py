"""What each part is worth: recipes trained and flown with one change at a time."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from rss_gym.eval.studies.section import Section
from rss_gym.eval.studies.world.rows import SEED, cells, value
from rss_gym.pages.table import Cell
from rss_gym.params import Reward
from rss_gym.train.study.curves import HEADINGS, METRICS, SUITE
from rss_gym.train.study.training import Trainer

Changes = dict[str, dict[str, Any]]  # what it is in words -> changes of the recipe

SEEDS = 3
AGENT, AGENT_STEPS = "pathwise", 2_000_000
WITHOUT: Changes = {
    "nothing": {},
    "tracker: the message held (`latest`)": {"world.tracker": "latest"},
    "range: not in the track, not observed": {"world.track_range": False, "policy.zeroed": "range"},
    "coloured noise in the filter: `ekf-white`": {"world.estimator": "ekf-white"},
    "coloured noise in the filter: `ekf-white-r`": {"world.estimator": "ekf-white-r"},
    "filter: least squares (`ls`)": {"world.estimator": "ls"},
    "closest approaches in the observation": {"policy.zeroed": "approach"},
    "imitation": {"imitation.episodes": 0},
}
LEARNER, LEARNER_STEPS = "ppo-short", 1_000_000
HALF = [{"start": 0.5, "proximity_price_m": 8000.0, "comfort_m": 20.0}]
PRICES = {"world.collision_price_m": 10_000.0, "world.snmac_price_m": 100.0, "world.proximity_price_m": 0.0}
SDE = {"algorithm.use_sde": True, "algorithm.sde_sample_freq": 8}
WITH: Changes = {
    "nothing": {},
    "coherent exploration: decisions of 1 s": {"world.decision_s": 1.0},
    "coherent exploration: gSDE, a new matrix every 8 decisions": SDE,
    "curriculum: twice the price within 20 m in the second half": {"curriculum": HALF},
    "potential-based shaping, 30 m": {"world.shaping_m": 30.0, "world.shaping_discount": 0.95},
    "the prices of the scores, no price of nearness": PRICES,
    "rewards not normalised": {"vec.normalise_reward": False},
    "batches of 8,192": {"algorithm.batch_size": 8192},
    "two layers of 256": {"policy.net_arch": [256, 256]},
    "exploration of half the width": {"policy.log_std_init": -0.7},
}


RARE: Changes = {
    "nothing": {},
    "half of the rows fly encounters again that came nearer than 20 m": {
        "algorithm.near_share": 0.5,
        "algorithm.near_m": 20.0,
    },
    "gradients of a decision up to 100 m in place of 20 m": {"algorithm.gradient_limit_m": 100.0},
    "four times as many rows, so a quarter of the updates": {"vec.n_envs": 256},
}


def ablations(trainer: Trainer) -> Section:
    """The agent of a minute without one part."""
    return Section(
        "Ablations",
        f"`{AGENT}` trained for {AGENT_STEPS:,} decisions and flown without one part, {SEEDS} seeds each; "
        f"{_how(trainer)} "
        "The action is a change of velocity in this world; there is no other continuous one to compare it with.",
        *_compared(trainer, AGENT, AGENT_STEPS, WITHOUT, "without"),
    )


def changes(trainer: Trainer) -> Section:
    """PPO from scratch with one change."""
    return Section(
        "What helps PPO",
        f"`{LEARNER}` trained for {LEARNER_STEPS:,} decisions with one change, {SEEDS} seeds each; {_how(trainer)}",
        *_compared(trainer, LEARNER, LEARNER_STEPS, WITH, "change"),
    )


def rare(trainer: Trainer) -> Section:
    """Near misses flown more often than they are drawn, with importance weights, and what else makes them count."""
    return Section(
        "What helps with rare near misses",
        f"`{AGENT}` trained for {AGENT_STEPS:,} decisions with one change, {SEEDS} seeds each; {_how(trainer)} An "
        "encounter that flies again weighs less by as much as it is drawn more often.",
        *_compared(trainer, AGENT, AGENT_STEPS, RARE, "change"),
    )


def _how(trainer: Trainer) -> str:
    return f"{trainer.episodes:,} encounters of `{SUITE}`, split `suite`, seed {SEED}."


def _compared(
    trainer: Trainer, recipe: str, steps: int, table: Changes, title: str
) -> tuple[tuple[str, ...], list[list[str | Cell]]]:
    """Header and rows: one a seed, and the difference of their mean from that of the seeds without a change."""
    rows: list[list[str | Cell]] = []
    means_m: list[float] = []  # the first is that without a change
    for what, change in table.items():
        seeds = trainer.train(recipe, {"recipe.steps": steps, **change}, SEEDS)
        scores = trainer.score({f"seed {seed.number}": seed.folder for seed in seeds}, SUITE, **_flown(change))
        means_m.append(sum(value(found, "cost_m") for found in scores.values()) / len(scores))
        rows += [
            [what, f"{seed.number}", *cells(found, METRICS)] for seed, found in zip(seeds, scores.values(), strict=True)
        ]
        rows.append([what, "mean", f"{means_m[-1]:.2f} ({means_m[-1] - means_m[0]:+.2f})", "", "", ""])
    return (title, "seed", *HEADINGS), rows


def _flown(change: Mapping[str, Any]) -> dict[str, Any]:
    """Changes of the recipe's world that hold for the flights too: all but the prices of the training."""
    prices = {field.name for field in dataclasses.fields(Reward)}
    world = {key.removeprefix("world."): found for key, found in change.items() if key.startswith("world.")}
    return {key: found for key, found in world.items() if key not in prices}
