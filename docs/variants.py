"""Trains `pathwise-short` with one thing changed, three seeds each, and writes what that did: make variants.

A variant is a run of `rss-gym train` in a folder of its own in runs/variants/; one that is finished is not trained
again, one that was interrupted goes on. Remove runs/variants/ after a change of the world or of the recipe.
"""

import csv
from pathlib import Path
from typing import Any

from opponents import put, table

from rss_gym.eval.intervals import clopper_pearson
from rss_gym.train import recipe, run

ROOT = Path(__file__).resolve().parent.parent
RUNS = ROOT / "runs" / "variants"
RECIPE, SEEDS, BASE_SEEDS, WORKERS = "pathwise-short", 3, 5, 2
# Folder -> what is told of it, and what differs from the recipe.
VARIANTS: dict[str, tuple[str, dict[str, Any]]] = {
    "base": ("the recipe", {}),
    "no-imitation": ("no imitation before", {"imitation.episodes": 0}),
    "no-features": ("no features of the approach", {"policy.features": "none"}),
    "no-decay": ("gradient not decayed", {"algorithm.gradient_decay": 1.0}),
    "no-radio": ("ablation: radio and messages zeroed", {"policy.zeroed": "radio"}),
    "no-range": ("ablation: range fields zeroed", {"policy.zeroed": "range"}),
    "ekf-white": ("ablation: estimator `ekf-white`", {"world.estimator": "ekf-white"}),
    "ls": ("ablation: estimator `ls`", {"world.estimator": "ls"}),
    "oracle": ("ablation: track `oracle`", {"world.track": "oracle"}),
}


def train(name: str) -> Path:
    """The run of a variant, trained or taken as it is."""
    folder, recipe_ = RUNS / name, recipe.load(RECIPE, VARIANTS[name][1])
    if not folder.exists():
        run.start(recipe_, folder, SEEDS if VARIANTS[name][1] else BASE_SEEDS, WORKERS, show=False)
    elif not (folder / "agent").exists():
        run.resume(folder, WORKERS, show=False)
    return folder


def row(name: str) -> list[str]:
    """What the last policies of all seeds did on the validation's encounters, which the seeds share."""
    last = []
    for path in sorted((RUNS / name).glob("seed-*/validation.csv")):
        with open(path, encoding="utf-8", newline="") as file:
            last.append(list(csv.DictReader(file))[-1])
    rates = []
    for line in last:
        rate = clopper_pearson(int(line["collisions"]), int(line["episodes"]))
        rates.append(f"{rate.value:.1e} [{rate.low:.1e}, {rate.high:.1e}]")
    deviations = ", ".join(f"{float(line['path_deviation_mean_m']):.1f}" for line in last)
    return [VARIANTS[name][0], "; ".join(rates), deviations]


def main() -> None:
    """Train what is missing, then write the README's table."""
    for name in VARIANTS:
        print(name, flush=True)
        train(name)
    text = table(["variant", "collisions, each seed", "mean deviation, m"], [row(name) for name in VARIANTS])
    episodes = recipe.load(RECIPE).validation.episodes
    put(
        ROOT / "README.md",
        "variants",
        f"{text}\n\n`{RECIPE}` with one thing changed, the last policy of each seed on the same {episodes:,} "
        "encounters of split `validation`, 95 % intervals in brackets; made by `make variants`.",
    )


if __name__ == "__main__":
    main()
