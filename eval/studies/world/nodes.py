"""How far apart are the reference nodes? The choice of the square's side, by the scores of the best scripted rules."""

from __future__ import annotations

from rss_gym.eval.studies.section import Scale, Section
from rss_gym.eval.studies.world.rows import HEADER, ORCA, RULE, SEED, cheapest, fly, row

SIDES_M = (200.0, 300.0, 400.0)
EPISODES = 5000


def section(scale: Scale) -> Section:
    """Scores over the side of the nodes' square."""
    rows = []
    for side_m in SIDES_M:
        found = fly(ORCA + RULE, scale, episodes=EPISODES, node_square_m=side_m)
        for names in (ORCA, RULE):
            best = cheapest({name: found[name] for name in names})
            rows.append(row(best, f"{side_m:g} m", found[best]))
    return Section(
        "The nodes' square",
        f"Suite `encounter-v0` with other sides of the nodes' square, {EPISODES:,} encounters, seed {SEED}, each rule "
        "at its cheapest radius. The world takes 300 m: the nodes stand outside the area in which the aircraft meet.",
        HEADER,
        rows,
    )
