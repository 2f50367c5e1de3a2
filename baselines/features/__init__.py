"""What a learned policy is told besides the observation, computed from the observations alone.

A new set of features is one class and one line in `FEATURES`.
"""

from __future__ import annotations

import numpy as np

from rss_gym import observation
from rss_gym.baselines.features.approach import Approach
from rss_gym.baselines.features.feature_set import FeatureSet, Nothing
from rss_gym.baselines.features.sides import Sides
from rss_gym.params import Params

__all__ = ["FEATURES", "LIMIT", "FeatureSet", "append", "names"]

LIMIT = 5.0  # features are clipped to this

FEATURES: dict[str, type[FeatureSet]] = {"none": Nothing, "approach": Approach, "sides": Sides}


def names(kind: str, world: Params) -> list[str]:
    """Names of the features in a world, in order."""
    table = _table(FEATURES[kind](world), np.zeros((1, len(observation.fields(world)))), None)
    return [f"intruder_{k}.{name}" for k in range(world.encounter.intruders) for name in table]


def append(features: FeatureSet, rows: np.ndarray, memory: np.ndarray | None = None) -> np.ndarray:
    """The features behind the columns they are made of.

    Parameters
    ----------
    features : FeatureSet
    rows : (n, m) array
        The last columns are the newest observation of the set's world; older ones may stand before it.
    memory : (n, `features.columns`) array, optional
        Of the episode, zero at its start and changed in place; None for rows that all begin one.

    Returns
    -------
    (n, m + f) array
        Features are rounded to float32; finite for all rows without NaN.
    """
    table = _table(features, rows[:, -len(observation.fields(features.world)) :], memory)
    if not table:
        return rows
    values = np.clip(np.stack(list(table.values()), axis=-1), -LIMIT, LIMIT).astype(np.float32)
    return np.concatenate([rows, values.reshape(len(rows), -1)], axis=1)


def _table(features: FeatureSet, rows: np.ndarray, memory: np.ndarray | None) -> dict[str, np.ndarray]:
    seen = observation.split(np.clip(rows, *observation.bounds(features.world)), features.world)
    seen |= features.facts(seen, np.zeros((len(rows), features.columns)) if memory is None else memory)
    return features.table(seen, np)
