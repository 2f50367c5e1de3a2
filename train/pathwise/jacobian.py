"""Derivative of the actor's actions by its observation."""

from __future__ import annotations

from typing import Any

import torch

from rss_gym.train.actor import parts


@torch.no_grad()
def actions_with_jacobian(policy: Any, rows: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Mean actions (n, A), not clipped, and their derivative by observations (n, d): (n, A, d).

    For dense layers with Tanh or ReLU between them.
    """
    hidden, last = parts(policy)
    values, slopes = rows, []  # of each layer's activation
    for layer in hidden:
        values = layer(values)
        if isinstance(layer, torch.nn.Tanh):
            slopes.append(1.0 - values * values)
        elif isinstance(layer, torch.nn.ReLU):
            slopes.append((values > 0.0).to(values.dtype))
    dense = [layer.weight for layer in hidden if isinstance(layer, torch.nn.Linear)]
    jacobian = []  # one row an axis of the action
    for axis in last.weight:
        backward = axis.expand(len(rows), -1)
        for weight, slope in zip(reversed(dense), reversed(slopes), strict=True):
            backward = (backward * slope) @ weight
        jacobian.append(backward)
    return last(values), torch.stack(jacobian, dim=1)
