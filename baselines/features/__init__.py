"""What a learned policy is told besides the observation, computed from the observations alone.

A new set of features is one class and one line in `FEATURES`.
"""

from __future__ import annotations

import numpy as np

from rss_gym import observation
from rss_gym.baselines.features.approach import Approach
from rss_gym.baselines.features.feature_set import FeatureSet, Nothing
from rss_gym.baselines.features.guided import Guided
from rss_gym.params import Params

__all__ = ["FEATURES", "LIMIT", "FeatureSet", "append", "names"]

LIMIT = 5.0  # features are clipped to this

FEATURES: dict[str, type[FeatureSet]] = {"none": Nothing, "approach": Approach, "guided": Guided}


def names(kind: str, world: Params) -> list[str]:
    """Names of the features in a world, in order."""
    features = FEATURES[kind](world)
    table = _table(features, np.zeros((1, len(observation.fields(world)))), None)
    own = [name for name, values in table.items() if values.ndim == 1]
    others = [name for name in table if name not in own]
    return own + [f"intruder_{k}.{name}" for k in range(world.encounter.intruders) for name in others]


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
    own = [values for values in table.values() if values.ndim == 1]
    others = [values for values in table.values() if values.ndim == 2]
    found = np.stack(own, axis=-1) if own else np.zeros((len(rows), 0))
    if others:
        found = np.concatenate([found, np.stack(others, axis=-1).reshape(len(rows), -1)], axis=1)
    return np.concatenate([rows, np.clip(found, -LIMIT, LIMIT).astype(np.float32)], axis=1)


def _table(features: FeatureSet, rows: np.ndarray, memory: np.ndarray | None) -> dict[str, np.ndarray]:
    seen = observation.split(np.clip(rows, *observation.bounds(features.world)), features.world)
    return features.table(seen, np.zeros((len(rows), features.columns)) if memory is None else memory)
