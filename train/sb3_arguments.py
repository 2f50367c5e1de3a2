"""Hyperparameters as Stable-Baselines3 takes them."""

from __future__ import annotations

import dataclasses
from typing import Any

from stable_baselines3.common.utils import LinearSchedule
from torch import nn

from rss_gym.train.hyperparameters import Pathwise, Ppo, PpoNetwork, Sac, SacNetwork, Schedule


def arguments(table: Ppo | Sac | Pathwise) -> dict[str, Any]:
    """Keywords of the algorithm."""
    found: dict[str, Any] = {}
    for item in dataclasses.fields(table):
        value = getattr(table, item.name)
        if isinstance(value, Schedule):
            is_constant = value.end == 1.0
            value = value.start if is_constant else LinearSchedule(value.start, value.start * value.end, 1.0)
        found[item.name] = None if item.name in ("clip_range_vf", "target_kl") and value == 0.0 else value
    return found


def network(table: PpoNetwork | SacNetwork) -> dict[str, Any]:
    """Keywords of its policy."""
    found = table.to_dict()
    del found["zeroed"]  # of the rows
    found["activation_fn"] = {"tanh": nn.Tanh, "relu": nn.ReLU}[found.pop("activation")]
    return found
