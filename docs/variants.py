"""Trains `pathwise-short` with one thing changed at a time and writes what that did: make variants.

A variant is a run of `rss-gym train` in a folder of its own in runs/variants/; one that is finished is not trained
again, one that was interrupted goes on; names choose some of them (python docs/variants.py base no-radio). Remove
runs/variants/ after a change of the world or of the recipe.
"""

import csv
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from opponents import put, table

from rss_gym.eval.intervals import clopper_pearson
from rss_gym.params import ParamsError, suggestion
from rss_gym.train import recipe, run

ROOT = Path(__file__).resolve().parent.parent
RUNS = ROOT / "runs" / "variants"
RECIPE, WORKERS = "pathwise-short", 2
# Folder -> what is told of it, seeds, and what differs from the recipe.
VARIANTS: dict[str, tuple[str, int, dict[str, Any]]] = {
    "base": ("the recipe", 5, {}),
    "no-imitation": ("no imitation before", 3, {"imitation.episodes": 0}),
    "no-features": ("no features of the approach", 3, {"policy.features": "none"}),
    "no-decay": ("gradient not decayed", 3, {"algorithm.gradient_decay": 1.0}),
    "no-radio": ("ablation: radio and messages zeroed", 1, {"policy.zeroed": "radio"}),
    "no-range": ("ablation: range fields zeroed", 1, {"policy.zeroed": "range"}),
    "ekf-white": ("ablation: estimator `ekf-white`", 1, {"world.estimator": "ekf-white"}),
    "ls": ("ablation: estimator `ls`", 1, {"world.estimator": "ls"}),
    "oracle": ("ablation: track `oracle`", 1, {"world.track": "oracle"}),
}


def chosen(names: Sequence[str]) -> list[str]:
    """The variants named, all without a name.

    Raises
    ------
    ParamsError
        For an unknown one.
    """
    for name in names:
        if name not in VARIANTS:
            raise ParamsError(f"variant {name!r} is unknown{suggestion(name, VARIANTS)}")
    return list(names or VARIANTS)


def train(name: str) -> Path:
    """The run of a variant, trained or taken as it is."""
    folder, (_, seeds, changes) = RUNS / name, VARIANTS[name]
    if not folder.exists():
        run.start(recipe.load(RECIPE, changes), folder, seeds, WORKERS, show=False)
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


def main(names: Sequence[str]) -> int:
    """Train what is missing of those named, then write the README's table of all that are there."""
    try:
        for name in chosen(names):
            print(name, flush=True)
            train(name)
    except ParamsError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    rows = [row(name) for name in VARIANTS if (RUNS / name / "agent").exists()]
    text = table(["variant", "collisions, each seed", "mean deviation, m"], rows)
    episodes = recipe.load(RECIPE).validation.episodes
    put(
        ROOT / "README.md",
        "variants",
        f"{text}\n\n`{RECIPE}` with one thing changed, the last policy of each seed on the same {episodes:,} "
        "encounters of split `validation`, 95 % intervals in brackets; made by `make variants`.",
    )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
