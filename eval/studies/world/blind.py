"""Does anything win blind? The cheapest manoeuvre that does not listen, beside the best that do, on every suite."""

from __future__ import annotations

from rss_gym.eval.blind import cheapest as cheapest_blind
from rss_gym.eval.columns import AIR
from rss_gym.eval.studies.section import Criterion, Scale, Section
from rss_gym.eval.studies.world.rows import ORCA, OTHERS, RULE, SEED, cheapest, fly, interval, value

SUITES = (
    "encounter-v0", "encounter3d-v0", "range-only-v0", "gnss-v0", "radios-v0", "quadcopter-v0", "turning-v0",
    "separating-v0", "merging-v0",
)  # fmt: skip
EPISODES = 2000
WIDE = ["orca:radius_m=40", "orca:radius_m=60", "orthogonal:radius_m=80", "orthogonal:radius_m=110"]
SCRIPTED, RULES = 1.5, 1.0  # times their cost, at least


def section(scale: Scale) -> Section:
    """One row a suite."""
    rows, criteria = [], []
    for suite in SUITES:
        found = fly(ORCA + OTHERS + RULE + WIDE, scale, suite, EPISODES)
        best = cheapest(found)
        rule = cheapest({name: scores for name, scores in found.items() if name.startswith("orthogonal")})
        blind = cheapest_blind(suite, EPISODES, SEED)
        costs = value(found[best], "cost_m"), value(found[rule], "cost_m"), blind.cost_m.value or 0.0
        rows.append(
            [suite, best, interval(found[best]["cost_m"], ".1f"), rule, interval(found[rule]["cost_m"], ".1f"),
             blind.name, f"{costs[2]:.1f}", f"{costs[2] / costs[0]:.1f}", f"{costs[2] / costs[1]:.1f}"]
        )  # fmt: skip
        criteria.append(
            Criterion(
                f"`{suite}`: the cheapest blind manoeuvre costs at least {SCRIPTED} times the best scripted policy and "
                f"{RULES} times the rule",
                f"{costs[2] / costs[0]:.2f} and {costs[2] / costs[1]:.2f} times",
                costs[2] >= SCRIPTED * costs[0] and costs[2] >= RULES * costs[1],
            )
        )
    cost = AIR["cost_m"].heading
    return Section(
        "Nothing blind leads",
        f"A blind policy does not listen to the radio. {EPISODES:,} encounters a suite, seed {SEED}. The blind "
        "policies are constant displacements of up to 1,000 m in 16 directions, constant velocities, stopping, "
        "flying back, climbing and descending. The last two columns are ratios of costs.",
        ("suite", "best scripted", cost, "rule", cost, "best blind", cost, "blind / scripted", "blind / rule"),
        rows,
        criteria,
    )
