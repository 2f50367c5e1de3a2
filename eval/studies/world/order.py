"""The return and the cost order policies alike."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.stats import spearmanr

from rss_gym import baselines
from rss_gym.eval.columns import AIR
from rss_gym.eval.episodes import Block, checked, command, start
from rss_gym.eval.studies.section import Criterion, Scale, Section
from rss_gym.eval.studies.world.rows import SEED
from rss_gym.params import Params

POLICIES = [
    "none", "constant:right_m=30", "constant:along_m=-300,right_m=0", "stop",
    *(f"orthogonal:radius_m={radius}" for radius in (30, 40, 60, 80)),
    "orca", "mvp", "cbf", "mpc",
]  # fmt: skip
EPISODES = 2000


def section(scale: Scale) -> Section:
    """Mean return and mean cost of each."""
    names = [*POLICIES, *(name for name in baselines.AGENTS if name in baselines.able(Params()))][: len(POLICIES) + 1]
    found = {name: _means(name) for name in names}
    returns, costs = np.array(list(found.values())).T
    rank = float(spearmanr(returns, -costs).statistic)
    return Section(
        "Return and cost order policies alike",
        f"`rss_gym/Encounter-v0`, {EPISODES:,} encounters of the split `suite`, seed {SEED}; the returns are not "
        "discounted.",
        ("policy", "mean return", f"mean {AIR['cost_m'].heading}"),
        [
            [name, f"{one:.3f}", f"{other:.3f}"]
            for name, (one, other) in sorted(found.items(), key=lambda item: item[1][1])
        ],
        [
            Criterion(
                "Spearman's rank correlation of the return and minus the cost is 1", f"{rank:.6f}", rank > 1.0 - 1e-9
            )
        ],
    )


def _means(name: str) -> tuple[float, float]:
    policy = baselines.make(name, Params())
    params = policy.params
    batch: Any = start(params, Block("suite", SEED, range(EPISODES)))
    total, done, state, first = np.zeros(EPISODES), np.zeros(EPISODES, bool), None, True
    while not done.all():
        actions, state = command(policy, name, batch.observations, state, np.full(EPISODES, first))
        batch.step(checked(actions, name, params, EPISODES)[0], ~done)
        total += np.where(done, 0.0, batch.rewards)
        done, first = batch.episode["terminated"] | batch.episode["truncated"], False
    return float(total.mean()), float(batch.episode["cost_m"].mean())
