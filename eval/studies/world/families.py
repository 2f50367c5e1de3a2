"""What the encounters are: the collisions of who does nothing, by family, and the share of planned conflicts."""

from __future__ import annotations

from rss_gym.encounters import FAMILIES
from rss_gym.eval.studies.section import Criterion, Scale, Section
from rss_gym.eval.studies.world.rows import SEED, fly, interval, value

EPISODES = 5000
SHARE = 0.36, 0.44


def section(scale: Scale) -> Section:
    """Each family that is drawn in the default world, then all of them by their weights."""
    weights = {name: family.weight for name, family in FAMILIES.items() if family.weight > 0.0}
    total = sum(weights.values())
    rows = []
    for name, weight in weights.items():
        scores = fly(["none"], scale, episodes=EPISODES, families=name)["none"]
        rows.append([name, f"{weight / total:.3f}", interval(scores["collision_rate"], ".3f")])
    mixed = fly(["none"], scale)["none"]
    rows.append(["mixed", "1", interval(mixed["collision_rate"], ".3f")])
    return Section(
        "The encounters",
        f"Policy `none`, {EPISODES:,} encounters a family and {scale.episodes:,} of all, seed {SEED}. The weights were "
        "chosen so that about 40 % of the encounters end in a collision if nobody acts, and so that intruders come "
        "from every side.",
        ("family", "weight", "collisions of `none`"),
        rows,
        [
            Criterion(
                f"the collision rate of `none` is between {SHARE[0]:g} and {SHARE[1]:g}",
                interval(mixed["collision_rate"], ".3f"),
                SHARE[0] <= value(mixed, "collision_rate") <= SHARE[1],
            )
        ],
    )
