"""Recipes from scratch: what each costs after how much of one core, beside the rule and the best scripted policy."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rss_gym.eval.columns import AIR
from rss_gym.eval.studies.section import Criterion, Section
from rss_gym.eval.studies.world.rows import ORCA, OTHERS, RULE, SEED, Scores, cells, cheapest, value
from rss_gym.pages import figure
from rss_gym.pages.table import Cell
from rss_gym.train.study.training import Trained, Trainer

SUITE = "encounter-v0"
METRICS = ("cost_m", "collision_rate", "path_deviation_mean_m", "unnecessary_manoeuvre_rate")
HEADINGS = [AIR[metric].heading for metric in METRICS]


@dataclass(frozen=True, slots=True)
class Bar:
    """What a recipe is to beat, after how many CPU seconds, and by how many seeds at most this is tried."""

    rival: str
    cpu_s: float
    seeds: int = 5


BARS = {
    "ppo-short": Bar("rule", 120.0),
    "ppo": Bar("best scripted policy", 600.0),
    "sac": Bar("rule", 600.0, 3),
    "recurrent-ppo": Bar("rule", 600.0, 3),
    "pathwise": Bar("best scripted policy", 60.0),
}


def section(trainer: Trainer) -> Section:
    """Every recipe of `BARS`, a row a seed."""
    scripted = trainer.score({name: name for name in ORCA + OTHERS + RULE}, SUITE)
    rule = cheapest({name: scripted[name] for name in RULE})
    rivals = {"rule": rule, "best scripted policy": cheapest(scripted)}
    rows: list[list[str | Cell]] = []
    criteria: list[Criterion] = []
    for recipe, bar in BARS.items():
        seeds = trainer.train(recipe, seeds=bar.seeds)
        scores = trainer.score({f"{recipe}, seed {seed.number}": seed.folder for seed in seeds}, SUITE)
        rows += list(_rows(seeds, scores))
        costs = [value(found, "cost_m") for found in scores.values()]
        spent_s, rival = max(seed.cpu_s for seed in seeds), rivals[bar.rival]
        limit_m = value(scripted[rival], "cost_m")
        beaten = sum(cost < limit_m for cost in costs)
        criteria.append(
            Criterion(
                f"`{recipe}`: every seed is cheaper than the {bar.rival} (`{rival}`, {limit_m:.1f} m) after at most "
                f"{bar.cpu_s:.0f} CPU seconds",
                f"{beaten} of {len(costs)} ({', '.join(f'{cost:.1f}' for cost in costs)} m) after {spent_s:.0f} s",
                beaten == len(costs) and spent_s <= bar.cpu_s,
            )
        )
    rows += [[name, "", "", *cells(scripted[name], METRICS)] for name in dict.fromkeys(rivals.values())]
    return Section(
        "From scratch",
        f"The policy that each seed's own validations chose, on {trainer.episodes:,} other encounters of `{SUITE}`, "
        f"split `suite`, seed {SEED}. The rule and the scripted policies have their cheapest radius.",
        ("policy", "decisions", "CPU s", *HEADINGS),
        rows,
        criteria,
    )


def _rows(seeds: list[Trained], scores: dict[str, Scores]) -> Iterator[list[str | Cell]]:
    for seed, (name, found) in zip(seeds, scores.items(), strict=True):
        yield [name, f"{seed.decisions:,}", f"{seed.cpu_s:.0f}", *cells(found, METRICS)]


def chart(trainer: Trainer) -> str:
    """Cost of the validations over CPU seconds, a line a seed, a colour a recipe; an SVG file."""
    label = "Cost of each seed's validations over the CPU seconds of its training, a colour for each recipe"
    with figure.figure(label, height_in=3.8) as drawing:
        axes = drawing.axes
        for colour, (recipe, bar) in zip(figure.COLOURS, BARS.items(), strict=False):
            for seed in trainer.train(recipe, seeds=bar.seeds):
                points = [(float(row["cpu_s"]), float(row["cost_m"])) for row in seed.validations]
                first = {"label": recipe} if seed.number == 0 else {}
                axes.plot(*zip(*points, strict=True), color=colour, marker=".", **first)
        axes.set(xscale="log", yscale="log", xlabel="CPU seconds", ylabel="cost, m (lower is better)")
        axes.legend()
    return figure.standalone(drawing.markup)
