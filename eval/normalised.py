"""Models of Stable-Baselines3 that were trained on observations which `VecNormalize` had normalised."""

from __future__ import annotations

from typing import Any

import numpy as np

from rss_gym.params import ParamsError


class Normalised:
    """A model that sees observations through the statistics that it was trained with.

    Parameters
    ----------
    model : object with `predict`
    statistics : VecNormalize
    """

    def __init__(self, model: Any, statistics: Any) -> None:
        self.model, self._statistics = model, statistics

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        """As the model's, of plain observations."""
        seen = self._statistics.normalize_obs(np.array(observation))
        found: tuple[Any, Any] = self.model.predict(seen, state, episode_start, deterministic)
        return found


def with_statistics(policy: Any) -> Any:
    """The policy as it was trained: with its environment's statistics of observations, if it has some.

    Raises
    ------
    ParamsError
        If it was trained on normalised observations and its statistics are not at hand.
    """
    environment = getattr(policy, "get_vec_normalize_env", None)
    statistics = environment() if callable(environment) else None
    if statistics is not None and statistics.norm_obs:
        return Normalised(policy, statistics)
    if statistics is None and saw_normalised(policy):
        raise ParamsError(
            "the model was trained on observations that VecNormalize had normalised, and comes without its statistics: "
            "load it with its environment, as in PPO.load(path, env=VecNormalize.load(statistics, venv))"
        )
    return policy


def saw_normalised(model: Any) -> bool:
    """Whether the last observations that a model of SB3 has kept lie outside of its own observation space."""
    seen: Any = getattr(model, "_last_obs", None)
    space: Any = getattr(model, "observation_space", None)
    if not isinstance(seen, np.ndarray) or not hasattr(space, "low") or seen.shape[1:] != space.shape:
        return False
    return bool((seen < space.low - 1e-3).any() or (seen > space.high + 1e-3).any())
