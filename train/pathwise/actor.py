"""The acting part of an SB3 actor-critic as a function of its observation, with its derivative."""

from __future__ import annotations

from typing import Any

import torch

from rss_gym.train.actor import parts


def mean_actions(policy: Any, rows: torch.Tensor) -> torch.Tensor:
    """Mean actions (n, A) of observations (n, d), not clipped."""
    hidden, last = parts(policy)
    actions: torch.Tensor = last(hidden(rows))
    return actions


@torch.no_grad()
def with_jacobian(policy: Any, rows: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Mean actions (n, A) and their derivative by the observation (n, A, d), of dense layers with Tanh or ReLU."""
    hidden, last = parts(policy)
    values, slopes = rows, []  # of each layer's activation
    for layer in hidden:
        values = layer(values)
        if isinstance(layer, torch.nn.Tanh):
            slopes.append(1.0 - values * values)
        elif isinstance(layer, torch.nn.ReLU):
            slopes.append((values > 0.0).to(values.dtype))
    dense = [layer.weight for layer in hidden if isinstance(layer, torch.nn.Linear)]
    rows_of = []
    for axis in last.weight:
        backward = axis.expand(len(rows), -1)
        for weight, slope in zip(reversed(dense), reversed(slopes), strict=True):
            backward = (backward * slope) @ weight
        rows_of.append(backward)
    return last(values), torch.stack(rows_of, dim=1)
