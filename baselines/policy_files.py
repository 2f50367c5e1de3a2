"""The two files of a learned policy, `policy.json` and `policy.safetensors`, and what is checked of them before use.

Numbers only: nothing in them can run.
"""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import Discrete

from rss_gym.baselines.masks import MASKS
from rss_gym.baselines.network import ACTIVATIONS
from rss_gym.domain import domain_of
from rss_gym.params import Params, ParamsError, suggestion
from rss_gym.plain_files import read_plain

DOCUMENT, WEIGHTS = "policy.json", "policy.safetensors"
FORMAT = 2
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
    zeroed : str
        What the policy is flown without, one of `rss_gym.baselines.masks.MASKS`.
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
    zeroed: str = "nothing"
    lstm: int = 0
    squash: bool = False
    clip: float = 0.0

    def inputs(self, params: Params) -> list[str]:
        """Names of the fields of an observation of this world."""
        return [field.name for field in domain_of(params).fields(params)]

    def shapes(self, params: Params) -> dict[str, tuple[int, ...]]:
        """The tensors' shapes in this world."""
        width = self.stack * len(self.inputs(params))
        found: dict[str, tuple[int, ...]] = {}
        if self.clip:
            found |= {"mean": (width,), "std": (width,)}
        if self.lstm:
            found |= {"lstm.input": (width, 4 * self.lstm), "lstm.hidden": (self.lstm, 4 * self.lstm)}
            found |= {"lstm.bias": (4 * self.lstm,)}
            width = self.lstm
        for index, units in enumerate((*self.layers, outputs(params)[0])):
            found |= {f"{index}.weight": (width, units), f"{index}.bias": (units,)}
            width = units
        return found


def outputs(params: Params) -> tuple[int, bool]:
    """How many numbers the network gives in this world, and whether the largest of them is the action."""
    space: Any = domain_of(params).spaces(params)[1]
    discrete = isinstance(space, Discrete)
    return (int(space.n) if discrete else int(space.shape[0])), discrete


def read(folder: Path) -> tuple[bytes, bytes]:
    """What both files hold, document first; refuses files too large or not there."""
    return _read(folder / DOCUMENT, DOCUMENT_LIMIT), _read(folder / WEIGHTS, WEIGHTS_LIMIT)


def _read(path: Path, limit: int) -> bytes:
    try:
        return read_plain(path, limit)
    except ParamsError as error:
        raise ParamsError(f"{path.name} {error}") from error
    except OSError as error:
        raise ParamsError(f"{path.name} cannot be read: {error.strerror or error}") from error


def document_of(text: bytes) -> dict[str, Any]:
    """The document, its fields and their kinds checked."""
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ParamsError(f"{DOCUMENT} is not JSON: {error}") from error
    kinds = {"format": int, "network": dict, "interface": dict, "observation": list, "training": dict}
    if not isinstance(document, dict):
        raise ParamsError(f"{DOCUMENT} must hold an object, got {type(document).__name__}")
    same_names(DOCUMENT, document, kinds)
    for name, kind in kinds.items():
        if not isinstance(document[name], kind):
            raise ParamsError(f"{DOCUMENT}: {name} must be a {kind.__name__}, got {document[name]!r}"[:300])
    if document["format"] != FORMAT:
        raise ParamsError(f"{DOCUMENT}: format {document['format']} is unknown; this version reads {FORMAT}")
    return document


def same_names(where: str, found: Any, known: Any) -> None:
    """Refuse a name that is unknown or missing."""
    for name in found:
        if name not in known:
            raise ParamsError(f"{where} has an unknown field {name!r}{suggestion(str(name), known)}")
    for name in known:
        if name not in found:
            raise ParamsError(f"{where} lacks the field {name!r}")


def network_of(table: dict[str, Any]) -> Network:
    """The architecture in a document, its bounds checked."""
    where = f"{DOCUMENT}, network"
    same_names(where, table, [field.name for field in dataclasses.fields(Network)])
    layers = table["layers"]
    if not isinstance(layers, list) or len(layers) > LAYERS_LIMIT:
        raise ParamsError(f"{where}: layers must be a list of at most {LAYERS_LIMIT} numbers, got {layers!r}"[:300])
    bounds = [("layers", units, 1, UNITS_LIMIT) for units in layers]
    bounds += [("stack", table["stack"], 1, STACK_LIMIT), ("lstm", table["lstm"], 0, UNITS_LIMIT)]
    for name, value, low, high in bounds:
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise ParamsError(f"{where}: {name} must be a whole number in [{low}, {high}], got {value!r}"[:300])
    for name, known in (("activation", ACTIVATIONS), ("zeroed", MASKS)):
        value = table[name]
        if not isinstance(value, str) or value not in known:
            raise ParamsError(f"{where}: {name} {value!r} is unknown{suggestion(str(value), known)}"[:300])
    if not isinstance(table["squash"], bool):
        raise ParamsError(f"{where}: squash must be true or false, got {table['squash']!r}"[:300])
    clip = table["clip"]
    if isinstance(clip, bool) or not isinstance(clip, (int, float)) or not 0.0 <= clip <= 1e6:
        raise ParamsError(f"{where}: clip must be a number in [0, 1e6], got {clip!r}"[:300])
    return Network(**{**table, "layers": tuple(layers), "clip": float(clip)})


def tensors_of(blob: bytes, shapes: dict[str, tuple[int, ...]]) -> dict[str, np.ndarray]:
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
    same_names(WEIGHTS, found, shapes)
    for name, shape in shapes.items():
        tensor = found[name]
        if tensor.dtype != np.float32 or tensor.shape != shape:
            raise ParamsError(f"{WEIGHTS}: tensor {name!r} must be float32 {shape}, got {tensor.dtype} {tensor.shape}")
        if not np.isfinite(tensor).all():
            raise ParamsError(f"{WEIGHTS}: tensor {name!r} holds a value that is not finite")
    if "std" in shapes and not (found["std"] > 0.0).all():
        raise ParamsError(f"{WEIGHTS}: tensor 'std' must be positive")
    return {name: np.ascontiguousarray(found[name], dtype=np.float64) for name in shapes}
