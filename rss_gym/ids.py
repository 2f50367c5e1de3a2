"""The registered environments: id -> the keywords that set it apart from the default world, or from the other roads."""

from __future__ import annotations

import copy
from typing import Any

import gymnasium as gym
from gymnasium.envs.registration import EnvSpec

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


# Gymnasium before 1.0 does not pass an id's keywords on to a vector entry point: it would make another world.
_VECTOR: dict[str, Any] = (
    {} if gym.__version__.startswith("0.") else {"vector_entry_point": "rss_gym.vector:EncounterVectorEnv"}
)


def register_all() -> None:
    """Register every id once, with string entry points so that specs travel as JSON."""
    for name, keywords in IDS.items():
        if name not in gym.registry:
            gym.register(name, entry_point="rss_gym.env:EncounterEnv", kwargs=keywords, **_VECTOR)
    for name, keywords in ROADS.items():
        if name not in gym.registry:
            gym.register(name, entry_point="rss_gym.highway.env:RoadEnv", kwargs=keywords)


def bounded(spec: EnvSpec | None, longest: int, limit: int | None = None) -> EnvSpec | None:
    """A spec whose `max_episode_steps` holds: `limit` if there is one, else what no episode of the world exceeds.

    The registry leaves it open, because it depends on the parameters, and because a `TimeLimit` made of it would cut
    the episodes of worlds that were given longer ones.
    """
    if spec is None or spec.max_episode_steps is not None:
        return spec
    found = copy.copy(spec)
    found.max_episode_steps = longest if limit is None else min(longest, limit)
    return found
