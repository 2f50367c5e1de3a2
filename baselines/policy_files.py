"""The two files of a learned policy, `policy.json` and `policy.safetensors`, and what is checked of them before use.

Numbers only: nothing in them can run.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

import numpy as np
from gymnasium.spaces import Discrete

from rss_gym.baselines.masks import MASKS
from rss_gym.baselines.network import ACTIVATIONS
from rss_gym.domain import domain_of
from rss_gym.params import Information, Params, ParamsError
from rss_gym.plain_files import read_plain
from rss_gym.schema import Kind, Schema, checked, listed, one_of, real, table, text, truth, version, whole

DOCUMENT, WEIGHTS = "policy.json", "policy.safetensors"
FORMAT = 2
DOCUMENT_LIMIT, HEADER_LIMIT, WEIGHTS_LIMIT = 1 << 20, 1 << 16, 1 << 26  # bytes
LAYERS_LIMIT, UNITS_LIMIT, STACK_LIMIT = 8, 2048, 64

FIELDS: Schema = {
    "format": version(FORMAT),
    "network": table("a table, the architecture"),
    "interface": table("a table, the interface of the world"),
    "observation": listed(0, 10**6, "the list of the names of the observation's fields", text()),
    "training": table("a table, what is recorded of the training"),
}
NETWORK: Schema = {
    "layers": listed(
        0,
        LAYERS_LIMIT,
        f"a list of at most {LAYERS_LIMIT} whole numbers in [1, {UNITS_LIMIT}]",
        whole(1, UNITS_LIMIT),
    ),
    "activation": one_of(ACTIVATIONS),
    "stack": whole(1, STACK_LIMIT),
    "zeroed": one_of(MASKS),
    "lstm": whole(0, UNITS_LIMIT),
    "squash": truth(),
    "clip": real(0.0, 1e6),
}
INTERFACE: Schema = {"information": one_of(get_args(Information))}
TENSOR = Kind(lambda value: isinstance(value, np.ndarray), "a tensor")


@dataclass(frozen=True)
class Network:
    """Architecture of a policy.

    Parameters
    ----------
    layers : tuple of int
        Units of the hidden layers.
    activation : str
        The activation of the hidden layers, one of `ACTIVATIONS`.
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
        document = json.loads(text.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise ParamsError(f"{DOCUMENT} is not JSON: {error}") from error
    checked(DOCUMENT, "", document, FIELDS)
    checked(DOCUMENT, "network", document["network"], NETWORK)
    checked(DOCUMENT, "interface", document["interface"], INTERFACE)
    return document


def network_of(table: dict[str, Any]) -> Network:
    """The architecture in a document."""
    return Network(**{**table, "layers": tuple(table["layers"]), "clip": float(table["clip"])})


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
    checked(WEIGHTS, "", found, dict.fromkeys(shapes, TENSOR))
    for name, shape in shapes.items():
        tensor = found[name]
        if tensor.dtype != np.float32 or tensor.shape != shape:
            raise ParamsError(f"{WEIGHTS}: tensor {name!r} must be float32 {shape}, got {tensor.dtype} {tensor.shape}")
        if not np.isfinite(tensor).all():
            raise ParamsError(f"{WEIGHTS}: tensor {name!r} holds a value that is not finite")
    if "std" in shapes and not (found["std"] > 0.0).all():
        raise ParamsError(f"{WEIGHTS}: tensor 'std' must be positive")
    return {name: np.ascontiguousarray(found[name], dtype=np.float64) for name in shapes}
