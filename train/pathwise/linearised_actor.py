"""The actor that learns, in NumPy, with the derivative of its actions by its observation.

Batches of a few dozen rows are small: PyTorch would spend more time on its calls than on the numbers.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch

from rss_gym.train.actor import parts


class LinearisedActor:
    """Dense layers with Tanh or ReLU between them, as they are when this is made.

    Parameters
    ----------
    policy : ActorCriticPolicy
    """

    def __init__(self, policy: Any) -> None:
        hidden, last = parts(policy)
        dense = [layer for layer in (*hidden, last) if isinstance(layer, torch.nn.Linear)]
        self._layers = [(layer.weight.detach().numpy().T, layer.bias.detach().numpy()) for layer in dense]
        self._is_tanh = any(isinstance(layer, torch.nn.Tanh) for layer in hidden)

    def __call__(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean actions (n, A), not clipped, and their derivative by observations (n, d): (n, A, d); float32."""
        *hidden, (last, bias) = self._layers
        values, slopes = rows, []  # of each layer's activation
        for weight, offset in hidden:
            values = values @ weight + offset
            if self._is_tanh:
                values = np.tanh(values)
                slopes.append(1.0 - values * values)
            else:
                values = np.maximum(values, 0.0)
                slopes.append((values > 0.0).astype(np.float32))
        jacobian = np.empty((len(rows), last.shape[1], rows.shape[1]), np.float32)
        for axis in range(last.shape[1]):
            backward = np.broadcast_to(last[:, axis], values.shape)
            for (weight, _), slope in zip(reversed(hidden), reversed(slopes), strict=True):
                backward = (backward * slope) @ weight.T
            jacobian[:, axis] = backward
        return values @ last + bias, jacobian
