"""Learned policies from a folder, `policy.json` and `policy.safetensors`: numbers only, nothing in them can run.

What is read is checked against the schema below before it is used; `train/export.py` writes these files.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rss_gym import observation
from rss_gym.baselines.features import FEATURES, append, names
from rss_gym.baselines.features.masks import MASKS, kept
from rss_gym.baselines.network import ACTIVATIONS, feed_forward, long_short_term
from rss_gym.params import Params, ParamsError, suggestion

DOCUMENT, WEIGHTS = "policy.json", "policy.safetensors"
FORMAT = 1
DOCUMENT_LIMIT, HEADER_LIMIT, WEIGHTS_LIMIT = 1 << 20, 1 << 16, 1 << 26  # bytes
LAYERS_LIMIT, UNITS_LIMIT, STACK_LIMIT = 8, 2048, 64


@dataclass(frozen=True)
class Network:
    """Architecture of a policy.

    Parameters
    ----------
    layers : tuple of int
        Units of the hidden layers.
    activation : str
        Of the hidden layers, one of `ACTIVATIONS`.
    stack : int
        Observations of so many last decisions, oldest first, are the input; zero before the episode began.
    features : str
        What is computed from the newest observation and stands behind it, one of `rss_gym.baselines.features.FEATURES`.
    zeroed : str
        What the policy is flown without, one of `rss_gym.baselines.features.masks.MASKS`.
    lstm : int
        Units of a recurrent layer before the hidden ones; 0 without.
    squash : bool
        The action is the tanh of the output; it is clipped to [-1, 1] in any case.
    clip : float
        Normalised observations are held within +-clip; 0 without normalisation.
    """

    layers: tuple[int, ...]
    activation: str = "tanh"
    stack: int = 1
    features: str = "none"
    zeroed: str = "nothing"
    lstm: int = 0
    squash: bool = False
    clip: float = 0.0

    def inputs(self, world: Params) -> list[str]:
        """Names of the fields of an observation of this world, and of the features."""
        return [field.name for field in observation.fields(world)] + names(self.features, world)

    def shapes(self, world: Params) -> dict[str, tuple[int, ...]]:
        """The tensors' shapes in this world."""
        width = len(self.inputs(world)) + (self.stack - 1) * len(observation.fields(world))
        axes = 2 if world.encounter.planar else 3
        found: dict[str, tuple[int, ...]] = {}
        if self.clip:
            found |= {"mean": (width,), "std": (width,)}
        if self.lstm:
            found |= {"lstm.input": (width, 4 * self.lstm), "lstm.hidden": (self.lstm, 4 * self.lstm)}
            found |= {"lstm.bias": (4 * self.lstm,)}
            width = self.lstm
        for index, units in enumerate((*self.layers, axes)):
            found |= {f"{index}.weight": (width, units), f"{index}.bias": (units,)}
            width = units
        return found


class Agent:
    """A learned policy: SB3's `predict`, deterministic, the same bits in every batch and on every machine.

    Parameters
    ----------
    network : Network
    tensors : dict of float64 arrays
        As `network.shapes` has them for this world.
    world : Params
        The world, with the interface the policy was trained for.
    document : dict
        `policy.json`, for what else it records.
    digest : str
        SHA-256 of both files.
    """

    def __init__(
        self, network: Network, tensors: dict[str, np.ndarray], world: Params, document: dict[str, Any], digest: str
    ) -> None:
        self.network, self.world, self.document, self.digest = network, world, document, digest
        self._tensors, self._features = tensors, FEATURES[network.features](world)
        self._kept = kept(network.zeroed, world)
        count = len(network.layers) + 1
        self._weights = tuple(tensors[f"{index}.weight"] for index in range(count))
        self._biases = tuple(tensors[f"{index}.bias"] for index in range(count))
        kinds = [ACTIVATIONS[network.activation]] * len(network.layers)
        self._activations = np.array([*kinds, ACTIVATIONS["tanh" if network.squash else "identity"]])

    def interface(self) -> dict[str, Any]:
        """Parameters of the world that the policy needs: track, action, reach."""
        return dict(self.document["interface"])

    def predict(
        self, observation_: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """SB3's `predict`; always the mean action.

        Parameters
        ----------
        observation_ : (d,) or (n, d) array
            Of the policy's `world`.
        state : (n, m) array, optional
            As returned by the last call; None starts afresh.
        episode_start : (n,) bool array, optional
            Rows whose memory is cleared.

        Returns
        -------
        actions, state
            float32 (axes,) or (n, axes), and the memory: older observations, what the features remember, the recurrent
            layer's state.
        """
        values = np.asarray(observation_, dtype=np.float64)
        rows = np.atleast_2d(values) * self._kept
        older = rows.shape[1] * (self.network.stack - 1)
        known = older + self._features.columns
        columns = known + 2 * self.network.lstm
        memory = np.zeros((len(rows), columns)) if state is None else np.array(state, dtype=np.float64)
        if episode_start is not None:
            memory[np.broadcast_to(np.asarray(episode_start, bool), len(rows))] = 0.0
        inputs = np.concatenate([memory[:, :older], rows], axis=1)
        memory[:, :older] = inputs[:, rows.shape[1] :]
        told = np.ascontiguousarray(memory[:, older:known])
        inputs = append(self._features, inputs, told)
        memory[:, older:known] = told
        if self.network.clip:
            inputs = (inputs - self._tensors["mean"]) / self._tensors["std"]
            inputs = np.clip(inputs, -self.network.clip, self.network.clip)
        if self.network.lstm:
            recurrent, hidden = np.ascontiguousarray(memory[:, known:]), np.empty((len(rows), self.network.lstm))
            w_input, w_hidden = self._tensors["lstm.input"], self._tensors["lstm.hidden"]
            long_short_term(w_input, w_hidden, self._tensors["lstm.bias"], inputs, recurrent, hidden)
            memory[:, known:], inputs = recurrent, hidden
        outputs = np.empty((len(rows), len(self._biases[-1])))
        feed_forward(self._weights, self._biases, self._activations, np.ascontiguousarray(inputs), outputs)
        actions = np.clip(outputs, -1.0, 1.0).astype(np.float32)
        return (actions if values.ndim > 1 else actions[0]), memory


def load(folder: str | os.PathLike[str], params: Params | None = None, called: str | None = None) -> Agent:
    """The policy in a folder, for a world.

    Parameters
    ----------
    folder : path
        With `policy.json` and `policy.safetensors`.
    params : Params, optional
        The world; the agent's own `world` is this with the interface of the agent.
    called : str, optional
        What an error calls the policy; default: its folder.

    Raises
    ------
    ParamsError
        For a missing, truncated or foreign file, an unknown or missing field, a value out of bounds, a tensor of
        another shape or with a value that is not finite, or a world whose observation the policy was not made for.
    """
    place = Path(folder)
    try:
        text, blob = _read(place / DOCUMENT, DOCUMENT_LIMIT), _read(place / WEIGHTS, WEIGHTS_LIMIT)
        document = _document(text)
        network = _network(document["network"])
        world = _world(document, params)
        known = network.inputs(world)
        if document["observation"] != known:
            raise ParamsError(
                f"{DOCUMENT}: it was made for {len(document['observation'])} fields and features, and this world has "
                f"{len(known)} or others; planar, intruders and track must be as in training"
            )
        tensors = _tensors(blob, network.shapes(world))
    except ParamsError as error:
        raise ParamsError(f"{called or f'policy folder {os.fspath(folder)!r}'}: {error}") from error
    return Agent(network, tensors, world, document, hashlib.sha256(text + blob).hexdigest())


def _read(path: Path, limit: int) -> bytes:
    try:
        size = path.stat().st_size
        if size > limit:
            raise ParamsError(f"{path.name} has {size} bytes; at most {limit} are read")
        return path.read_bytes()
    except OSError as error:
        raise ParamsError(f"{path.name} cannot be read: {error.strerror or error}") from error


def _document(text: bytes) -> dict[str, Any]:
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ParamsError(f"{DOCUMENT} is not JSON: {error}") from error
    kinds = {"format": int, "network": dict, "interface": dict, "observation": list, "training": dict}
    if not isinstance(document, dict):
        raise ParamsError(f"{DOCUMENT} must hold an object, got {type(document).__name__}")
    _same_names(DOCUMENT, document, kinds)
    for name, kind in kinds.items():
        if not isinstance(document[name], kind):
            raise ParamsError(f"{DOCUMENT}: {name} must be a {kind.__name__}, got {document[name]!r}"[:300])
    if document["format"] != FORMAT:
        raise ParamsError(f"{DOCUMENT}: format {document['format']} is unknown; this version reads {FORMAT}")
    return document


def _same_names(where: str, found: Any, known: Any) -> None:
    for name in found:
        if name not in known:
            raise ParamsError(f"{where} has an unknown field {name!r}{suggestion(str(name), known)}")
    for name in known:
        if name not in found:
            raise ParamsError(f"{where} lacks the field {name!r}")


def _network(table: dict[str, Any]) -> Network:
    where = f"{DOCUMENT}, network"
    _same_names(where, table, [field.name for field in dataclasses.fields(Network)])
    layers = table["layers"]
    if not isinstance(layers, list) or len(layers) > LAYERS_LIMIT:
        raise ParamsError(f"{where}: layers must be a list of at most {LAYERS_LIMIT} numbers, got {layers!r}"[:300])
    bounds = [("layers", units, 1, UNITS_LIMIT) for units in layers]
    bounds += [("stack", table["stack"], 1, STACK_LIMIT), ("lstm", table["lstm"], 0, UNITS_LIMIT)]
    for name, value, low, high in bounds:
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise ParamsError(f"{where}: {name} must be a whole number in [{low}, {high}], got {value!r}"[:300])
    for name, known in (("activation", ACTIVATIONS), ("features", FEATURES), ("zeroed", MASKS)):
        value = table[name]
        if not isinstance(value, str) or value not in known:
            raise ParamsError(f"{where}: {name} {value!r} is unknown{suggestion(str(value), known)}"[:300])
    if not isinstance(table["squash"], bool):
        raise ParamsError(f"{where}: squash must be true or false, got {table['squash']!r}"[:300])
    clip = table["clip"]
    if isinstance(clip, bool) or not isinstance(clip, (int, float)) or not 0.0 <= clip <= 1e6:
        raise ParamsError(f"{where}: clip must be a number in [0, 1e6], got {clip!r}"[:300])
    return Network(**{**table, "layers": tuple(layers), "clip": float(clip)})


def _world(document: dict[str, Any], params: Params | None) -> Params:
    _same_names(f"{DOCUMENT}, interface", document["interface"], ["track", "action", "reach_m"])
    world = Params.of(params, **document["interface"])
    if world.interface.action == "discrete":
        raise ParamsError(f"{DOCUMENT}, interface: action 'discrete' is not supported; use displacement or velocity")
    return world


def _tensors(blob: bytes, shapes: dict[str, tuple[int, ...]]) -> dict[str, np.ndarray]:
    """The tensors of a safetensors file, float32 in it and float64 here."""
    from safetensors import SafetensorError
    from safetensors.numpy import load as parse

    header = int.from_bytes(blob[:8], "little")
    if len(blob) < 8 or header > HEADER_LIMIT:
        raise ParamsError(f"{WEIGHTS} is truncated or has a header of more than {HEADER_LIMIT} bytes")
    try:
        found = parse(blob)
    except (SafetensorError, ValueError, KeyError, TypeError) as error:
        raise ParamsError(f"{WEIGHTS} is not a safetensors file: {error}") from error
    _same_names(WEIGHTS, found, shapes)
    for name, shape in shapes.items():
        tensor = found[name]
        if tensor.dtype != np.float32 or tensor.shape != shape:
            raise ParamsError(f"{WEIGHTS}: tensor {name!r} must be float32 {shape}, got {tensor.dtype} {tensor.shape}")
        if not np.isfinite(tensor).all():
            raise ParamsError(f"{WEIGHTS}: tensor {name!r} holds a value that is not finite")
    if "std" in shapes and not (found["std"] > 0.0).all():
        raise ParamsError(f"{WEIGHTS}: tensor 'std' must be positive")
    return {name: np.ascontiguousarray(found[name], dtype=np.float64) for name in shapes}
