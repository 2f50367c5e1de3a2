"""One agent for every radio: flown on each of them beside the scripted policies."""

from __future__ import annotations

from rss_gym.eval.studies.section import Criterion, Section
from rss_gym.eval.studies.world.rows import RULE, SEED, Scores, cheapest, interval, value
from rss_gym.train.study.training import Trainer

RECIPE, SEEDS, SUITE = "pathwise-radios", 1, "radios-v0"
# Radio -> the greatest risk ratio.
RADIOS = {"paper": 0.01, "outdoor": 0.01, "wifi-walk": 0.01, "ble-indoor": 0.01, "quadcopter": 0.02}
SCRIPTED = [f"orca:radius_m={radius}" for radius in (20, 30, 40)] + ["mpc", "mpc:radius_m=30", "cbf:radius_m=30"]
SCRIPTED += [*RULE, "orthogonal:radius_m=120"]


def section(trainer: Trainer) -> Section:
    """A row a radio for the cheapest seed on all of them, and for the cheapest scripted policy on each."""
    seeds = {f"{RECIPE}, seed {seed.number}": seed.folder for seed in trainer.train(RECIPE, seeds=SEEDS)}
    agent = cheapest(trainer.score(seeds, SUITE))
    rows, criteria = [], []
    for radio, limit in RADIOS.items():
        flown = trainer.score({agent: seeds[agent]} | {name: name for name in SCRIPTED}, SUITE, channel=radio)
        learned, best = flown.pop(agent), cheapest(flown)
        rows += [_row(radio, agent, learned), _row(radio, best, flown[best])]
        risk, mine_m, theirs_m = value(learned, "risk_ratio"), value(learned, "cost_m"), value(flown[best], "cost_m")
        criteria += [
            Criterion(f"`{radio}`: risk ratio at most {limit}", f"{risk:.2e}", risk <= limit),
            Criterion(
                f"`{radio}`: cheaper than every scripted policy",
                f"{mine_m:.2f} against {theirs_m:.2f} m of `{best}`",
                mine_m < theirs_m,
            ),
        ]
    return Section(
        "One agent for every radio",
        f"`{RECIPE}`, trained on a radio drawn anew for each encounter; {trainer.episodes:,} encounters a row of "
        f"`{SUITE}` with that radio alone, split `suite`, seed {SEED}; the scripted policies have their cheapest "
        "radius on each radio.",
        ("radio", "policy", "cost m", "risk ratio", "collision rate", "mean deviation m"),
        rows,
        criteria,
    )


def _row(radio: str, name: str, scores: Scores) -> list[str]:
    metrics = (("cost_m", ".2f"), ("risk_ratio", ".1e"), ("collision_rate", ".1e"), ("path_deviation_mean_m", ".2f"))
    return [radio, name, *(interval(scores[metric], form) for metric, form in metrics)]
