"""No manoeuvre that does not listen to the radio may be cheap, on any suite."""

import pytest

from rss_gym.baselines import able
from rss_gym.domain import AIR
from rss_gym.eval import evaluate
from rss_gym.eval.blind import cheapest
from rss_gym.eval.suites import SUITES

EPISODES = 2000
# Five written geometries can be learned by heart, so one displacement may clear all of them; the other is a short one.
KNOWN = ("degenerate-v0", "smoke-v0")
BEST, RULE = 1.5, 1.0  # times the cost of the best scripted policy, and of the paper's rule at its cheapest radius
RADII_M = (30, 40, 60, 80, 110)
SCRIPTED = ("orca", "mvp", "cbf", "mpc", "qmdp", "modified-orthogonal")


@pytest.mark.slow
@pytest.mark.parametrize("suite", [name for name, suite in SUITES.items() if suite.domain is AIR and name not in KNOWN])
def test_nothing_blind_leads(suite):
    flown = SUITES[suite]
    episodes = min(EPISODES, flown.episodes)
    rules = [f"orthogonal:radius_m={radius}" for radius in RADII_M]
    others = [name for name in SCRIPTED if name in able(flown.params)]
    result = evaluate([*rules, *others], suite, episodes, progress=False)
    costs = {scored.entry.name: scored.metrics["cost_m"].value for scored in result.policies}
    blind = cheapest(suite, episodes)
    best, rule = min(costs[name] for name in (*rules, *others)), min(costs[name] for name in rules)
    print(f"\n{suite}: {blind.name} {blind.cost_m.value:.1f} m, best scripted {best:.1f} m, rule {rule:.1f} m")
    assert blind.cost_m.value >= BEST * best, blind.name
    assert blind.cost_m.value >= RULE * rule, blind.name
