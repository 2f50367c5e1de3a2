"""Rows of scores that the sections share."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rss_gym.eval.columns import AIR
from rss_gym.eval.evaluate import evaluate
from rss_gym.eval.metrics import Estimate
from rss_gym.eval.studies.section import Scale
from rss_gym.pages.table import Cell, Column

METRICS = ("cost_m", "collision_rate", "snmac_rate", "path_deviation_mean_m")
HEADER = ("policy", "world", *(AIR[metric].heading for metric in METRICS))
SEED = 930_000_101  # not the one that policies were tuned on
ORCA = [f"orca:radius_m={radius}" for radius in (15, 20, 25, 30)]
OTHERS = ["mvp", "cbf", "mpc"]
RULE = [f"orthogonal:radius_m={radius}" for radius in (30, 40, 50, 60)]

Scores = dict[str, Estimate]


def fly(
    policies: list[str], scale: Scale, suite: str = "encounter-v0", episodes: int | None = None, **changes: Any
) -> dict[str, Scores]:
    """Scores by policy over the first encounters of the study's seed."""
    count = scale.episodes if episodes is None else episodes
    result = evaluate(policies, suite, count, SEED, workers=scale.workers, progress=False, **changes)
    return {scored.entry.name: scored.metrics for scored in result.policies if scored.entry.name in policies}


def cheapest(found: dict[str, Scores]) -> str:
    """The policy of the least cost."""
    return min(found, key=lambda name: value(found[name], "cost_m"))


def value(scores: Scores, metric: str) -> float:
    """A metric that is always defined."""
    number = scores[metric].value
    assert number is not None
    return number


def danger(scores: Scores) -> float:
    """Collisions and sNMACs together, per encounter."""
    return value(scores, "collision_rate") + value(scores, "snmac_rate")


def interval(estimate: Estimate, form: str) -> str:
    """Value with its 95 % interval."""
    return Column("", form=form).cell(estimate).plain


def row(name: str, params: str, scores: Scores) -> list[str | Cell]:
    """Cells of `HEADER`."""
    return [name, params, *cells(scores, METRICS)]


def cells(scores: Scores, metrics: Iterable[str]) -> list[Cell]:
    """Each of these metrics with its interval, as its column shows it."""
    return [AIR[metric].cell(scores[metric]) for metric in metrics]
