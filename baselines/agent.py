"""Learned policies from a folder, `policy.json` and `policy.safetensors`: numbers only, nothing in them can run.

What is read is checked by `policy_files` before it is used; `train/export.py` writes these files.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Any

import numpy as np

from rss_gym.baselines.masks import kept
from rss_gym.baselines.network import ACTIVATIONS, feed_forward, long_short_term
from rss_gym.baselines.policy_files import (
    DOCUMENT,
    Network,
    document_of,
    network_of,
    outputs,
    read,
    tensors_of,
)
from rss_gym.domain import domain_of
from rss_gym.params import Params, ParamsError


class Agent:
    """A learned policy: SB3's `predict`, deterministic, the same bits in every batch and on every machine.

    Parameters
    ----------
    network : Network
    tensors : dict of float64 arrays
        As `network.shapes` has them for this world.
    params : Params
        The world.
    document : dict
        `policy.json`, for what else it records.
    digest : str
        SHA-256 of both files.
    """

    def __init__(
        self, network: Network, tensors: dict[str, np.ndarray], params: Params, document: dict[str, Any], digest: str
    ) -> None:
        self.network, self.params, self.document, self.digest = network, params, document, digest
        self._tensors, self._kept = tensors, kept(network.zeroed, params)
        count = len(network.layers) + 1
        self._weights = tuple(tensors[f"{index}.weight"] for index in range(count))
        self._biases = tuple(tensors[f"{index}.bias"] for index in range(count))
        kinds = [ACTIVATIONS[network.activation]] * len(network.layers)
        self._activations = np.array([*kinds, ACTIVATIONS["tanh" if network.squash else "identity"]])
        self.discrete = outputs(params)[1]

    @property
    def layers(self) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...], np.ndarray]:
        """Weights, biases and activations of the dense layers, as `network.feed_forward` takes them."""
        return self._weights, self._biases, self._activations

    def predict(
        self, observation_: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """SB3's `predict`; always the mean action, or the likeliest of discrete ones.

        Parameters
        ----------
        observation_ : (d,) or (n, d) array
            One or several observations of the policy's `params`.
        state : (n, m) array, optional
            As returned by the last call; None starts afresh.
        episode_start : (n,) bool array, optional
            Rows whose memory is cleared.

        Returns
        -------
        actions, state
            float32 (axes,) or (n, axes), of discrete actions () or (n,), and the memory.
        """
        found, memory = self.outputs(observation_, state, episode_start)
        actions = found.argmax(axis=1) if self.discrete else np.clip(found, -1.0, 1.0).astype(np.float32)
        return (actions if np.ndim(observation_) > 1 else actions[0]), memory

    def outputs(self, observation_: Any, state: Any, episode_start: Any) -> tuple[np.ndarray, np.ndarray]:
        """The network's outputs (n, m), and the memory: older observations and the recurrent layer's state."""
        values = np.asarray(observation_, dtype=np.float64)
        rows = np.atleast_2d(values) * self._kept
        older = rows.shape[1] * (self.network.stack - 1)
        columns = older + 2 * self.network.lstm
        memory = np.zeros((len(rows), columns)) if state is None else np.array(state, dtype=np.float64)
        if episode_start is not None:
            memory[np.broadcast_to(np.asarray(episode_start, bool), len(rows))] = 0.0
        inputs = np.concatenate([memory[:, :older], rows], axis=1)
        memory[:, :older] = inputs[:, rows.shape[1] :]
        if self.network.clip:
            inputs = (inputs - self._tensors["mean"]) / self._tensors["std"]
            inputs = np.clip(inputs, -self.network.clip, self.network.clip)
        if self.network.lstm:
            recurrent, hidden = np.ascontiguousarray(memory[:, older:]), np.empty((len(rows), self.network.lstm))
            w_input, w_hidden = self._tensors["lstm.input"], self._tensors["lstm.hidden"]
            long_short_term(w_input, w_hidden, self._tensors["lstm.bias"], inputs, recurrent, hidden)
            memory[:, older:], inputs = recurrent, hidden
        found = np.empty((len(rows), len(self._biases[-1])))
        feed_forward(self._weights, self._biases, self._activations, np.ascontiguousarray(inputs), found)
        return found, memory


def load(folder: str | os.PathLike[str], params: Params | None = None, called: str | None = None) -> Agent:
    """The policy in a folder, for a world.

    Parameters
    ----------
    folder : path
        With `policy.json` and `policy.safetensors`.
    params : Params, optional
        The world that it will fly in; not given, the default one on the agent's information.
    called : str, optional
        What an error calls the policy; default: its folder.

    Raises
    ------
    ParamsError
        For a missing, truncated or foreign file, an unknown or missing field, a value out of bounds, a tensor of
        another shape or with a value that is not finite, or a world whose observation the policy was not made for.
    """
    try:
        text, blob = read(Path(folder))
        document = document_of(text)
        network = network_of(document["network"])
        flown = _params_of(document, params)
        known = network.inputs(flown)
        if document["observation"] != known:
            raise ParamsError(
                f"{DOCUMENT}: it was made for {len(document['observation'])} fields, and this world has {len(known)} "
                "or others; planar and intruders must be as in training, on a road scene and vehicles"
            )
        tensors = tensors_of(blob, network.shapes(flown))
    except ParamsError as error:
        raise ParamsError(f"{called or f'policy folder {os.fspath(folder)!r}'}: {error}") from error
    return Agent(network, tensors, flown, document, hashlib.sha256(text + blob).hexdigest())


def _params_of(document: dict[str, Any], params: Params | None) -> Params:
    made_for = Params.of(action="velocity", **document["interface"])
    if params is None:
        return made_for
    own, level = made_for.interface.information, params.interface.information
    if own != level:
        raise ParamsError(f"it cannot fly on information {level!r}: it was trained on {own!r} and flies there only")
    return domain_of(params).commanded(params)
