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
        "The reference nodes, by which the aircraft find their positions, stand on the corners of a square. Suite "
        f"`encounter-v0` with three sides of that square, {EPISODES:,} encounters, seed {SEED}, each policy at its "
        "cheapest radius. The default is 300 m: the nodes then stand outside the area in which the aircraft meet.",
        HEADER,
        rows,
    )
