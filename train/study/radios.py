"""One agent for every radio: flown on each of them beside the scripted policies and an agent of one radio."""

from __future__ import annotations

from typing import Any

from rss_gym.eval.columns import AIR
from rss_gym.eval.studies.section import Criterion, Section
from rss_gym.eval.studies.world.rows import RULE, SEED, Scores, cheapest, value
from rss_gym.pages.table import Cell, Column
from rss_gym.params import random_channels
from rss_gym.train.study.training import Trainer

RECIPE, SEEDS, SUITE = "pathwise-radios", 1, "radios-v0"
NEW = "20 radios never trained on"
# Radio -> the greatest risk ratio. The recipe draws its random radios from seed 0.
RADIOS: dict[str, float] = {"paper": 0.01, "outdoor": 0.01, "wifi-walk": 0.01, "ble-indoor": 0.01, "quadcopter": 0.02}
RADIOS[NEW] = 0.02
CHANNELS: dict[str, Any] = {radio: radio for radio in RADIOS} | {NEW: random_channels(20, seed=1)}
ALONE, MOST = "paper", 1.2  # the cost there, in that of an agent trained on this radio alone
COLUMNS = {metric: AIR[metric] for metric in ("cost_m", "collision_rate", "path_deviation_mean_m")}
COLUMNS["risk_ratio"] = Column("risk ratio", form=".1e")
SCRIPTED = [f"orca:radius_m={radius}" for radius in (20, 30, 40)] + ["mpc", "mpc:radius_m=30", "cbf:radius_m=30"]
SCRIPTED += [*RULE, "orthogonal:radius_m=120"]


def section(trainer: Trainer) -> Section:
    """A row a radio for the cheapest seed on all of them, and for the cheapest scripted policy on each."""
    seeds = {f"{RECIPE}, seed {seed.number}": seed.folder for seed in trainer.train(RECIPE, seeds=SEEDS)}
    (alone,) = trainer.train(RECIPE, {"world.channel": ALONE}, seeds=1)
    specialist = f"{RECIPE} on `{ALONE}` alone"
    agent = cheapest(trainer.score(seeds, SUITE))
    rows: list[list[str | Cell]] = []
    criteria: list[Criterion] = []
    for radio, limit in RADIOS.items():
        learned = {agent: seeds[agent]} | ({specialist: alone.folder} if radio == ALONE else {})
        flown = trainer.score(learned | {name: name for name in SCRIPTED}, SUITE, channel=CHANNELS[radio])
        best = cheapest({name: flown[name] for name in SCRIPTED})
        rows += [_row(radio, name, flown[name]) for name in (*learned, best)]
        risk, cost_m, theirs_m = (
            value(flown[name], metric) for name, metric in ((agent, "risk_ratio"), (agent, "cost_m"), (best, "cost_m"))
        )
        criteria += [
            Criterion(f"{radio}: risk ratio at most {limit}", f"{risk:.2e}", risk <= limit),
            Criterion(
                f"{radio}: cheaper than every scripted policy",
                f"{cost_m:.2f} against {theirs_m:.2f} m of `{best}`",
                cost_m < theirs_m,
            ),
        ]
        if radio == ALONE:
            alone_m = value(flown[specialist], "cost_m")
            criteria.append(
                Criterion(
                    f"{radio}: at most {MOST} times the cost of the agent trained on it alone",
                    f"{cost_m:.2f} against {alone_m:.2f} m",
                    cost_m <= MOST * alone_m,
                )
            )
    return Section(
        "One agent for every radio",
        f"`{RECIPE}`, trained on a radio drawn anew for each encounter; {trainer.episodes:,} encounters a row of "
        f"`{SUITE}` with that radio alone, split `suite`, seed {SEED}; the scripted policies have their cheapest "
        "radius on each radio.",
        ("radio", "policy", *(column.heading for column in COLUMNS.values())),
        rows,
        criteria,
    )


def _row(radio: str, name: str, scores: Scores) -> list[str | Cell]:
    return [radio, name, *(column.cell(scores[metric]) for metric, column in COLUMNS.items())]
