"""What each part is worth: `pathwise` trained and flown without it."""

from __future__ import annotations

from typing import Any

from rss_gym.eval.studies.section import Section
from rss_gym.eval.studies.world.rows import SEED, value
from rss_gym.train.study.curves import SUITE, cells
from rss_gym.train.study.training import Trainer

RECIPE, STEPS, SEEDS = "pathwise", 2_000_000, 3
# What is missing -> changes of the recipe; those of its world hold for the flights too.
ABLATIONS: dict[str, dict[str, Any]] = {
    "nothing": {},
    "tracker: the message held (`latest`)": {"world.tracker": "latest"},
    "range: not in the track, not observed": {"world.track_range": False, "policy.zeroed": "range"},
    "coloured noise in the filter: `ekf-white`": {"world.estimator": "ekf-white"},
    "coloured noise in the filter: `ekf-white-r`": {"world.estimator": "ekf-white-r"},
    "filter: least squares (`ls`)": {"world.estimator": "ls"},
    "closest approaches in the observation": {"policy.zeroed": "approach"},
    "imitation": {"imitation.episodes": 0},
}


def section(trainer: Trainer) -> Section:
    """A row a seed, and its difference from the mean of the seeds with everything."""
    rows: list[list[str]] = []
    means_m: list[float] = []  # the first is that of the seeds with everything
    for what, changes in ABLATIONS.items():
        seeds = trainer.train(RECIPE, {"recipe.steps": STEPS, **changes}, SEEDS)
        world = {key.removeprefix("world."): found for key, found in changes.items() if key.startswith("world.")}
        scores = trainer.score({f"seed {seed.number}": seed.folder for seed in seeds}, SUITE, **world)
        means_m.append(sum(value(found, "cost_m") for found in scores.values()) / len(scores))
        rows += [[what, f"{seed.number}", *cells(found)] for seed, found in zip(seeds, scores.values(), strict=True)]
        rows.append([what, "mean", f"{means_m[-1]:.2f} ({means_m[-1] - means_m[0]:+.2f})", "", "", ""])
    return Section(
        "Ablations",
        f"`{RECIPE}` trained for {STEPS:,} decisions and flown without one part, {SEEDS} seeds each; "
        f"{trainer.episodes:,} encounters of `{SUITE}`, split `suite`, seed {SEED}. The action is a change of velocity "
        "in this world; there is no other continuous one to compare it with.",
        ("without", "seed", "cost m", "collision rate", "mean deviation m", "unnecessary manoeuvres"),
        rows,
    )
