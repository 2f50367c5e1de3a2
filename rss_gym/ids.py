"""The registered environments: id -> the keywords that set it apart from the default world, or from the other roads."""

import gymnasium as gym

IDS: dict[str, dict[str, object]] = {
    "rss_gym/Encounter-v0": {},
    "rss_gym/Encounter3D-v0": {"planar": False},
    "rss_gym/EncounterRangeOnly-v0": {"information": "ranges"},
}
ROADS: dict[str, dict[str, object]] = {  # of highway-env, extra `highway`
    "rss_gym/Highway-v0": {"scene": "highway"},
    "rss_gym/Merge-v0": {"scene": "merge"},
    "rss_gym/Intersection-v0": {"scene": "intersection"},
}


def register_all() -> None:
    """Register every id once, with string entry points so that specs travel as JSON."""
    for name, keywords in IDS.items():
        if name not in gym.registry:
            gym.register(
                name,
                entry_point="rss_gym.env:EncounterEnv",
                vector_entry_point="rss_gym.vector:EncounterVectorEnv",
                kwargs=keywords,
            )
    for name, keywords in ROADS.items():
        if name not in gym.registry:
            gym.register(name, entry_point="rss_gym.highway.env:RoadEnv", kwargs=keywords)
