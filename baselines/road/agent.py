"""Learned drivers from a folder, `policy.json` and `policy.safetensors`: numbers only, nothing in them can run.

The files are those of `rss_gym.baselines.policy_files`; the interface is a road's, and the action the largest of the
outputs.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Any

import numpy as np

from rss_gym.baselines import policy_files as files
from rss_gym.baselines.network import ACTIVATIONS, feed_forward
from rss_gym.baselines.road.policy import World
from rss_gym.highway import observation
from rss_gym.params import ParamsError

INTERFACE = ("information", "radio", "actions")


def inputs(world: World) -> list[str]:
    """Names of the fields of the observation."""
    return [field.name for field in observation.fields(world.params)]


def of_vehicles(world: World) -> np.ndarray:
    """Which fields (d,) are of vehicles: what a blind driver does not see."""
    return np.array([name.startswith("vehicle_") for name in inputs(world)])


def shapes(layers: tuple[int, ...], world: World) -> dict[str, tuple[int, ...]]:
    """The tensors' shapes on this road."""
    width = len(inputs(world))
    found: dict[str, tuple[int, ...]] = {}
    for index, units in enumerate((*layers, len(world.actions))):
        found |= {f"{index}.weight": (width, units), f"{index}.bias": (units,)}
        width = units
    return found


class RoadAgent:
    """A learned driver: SB3's `predict`, deterministic, the same bits in every batch and on every machine.

    Parameters
    ----------
    tensors : dict of float64 arrays
        As `shapes` has them.
    activation : str
        Of the hidden layers, one of `ACTIVATIONS`.
    digest : str
        SHA-256 of both files.
    """

    def __init__(self, tensors: dict[str, np.ndarray], activation: str, digest: str = "") -> None:
        count = len(tensors) // 2
        self.keywords: dict[str, Any] = {}  # as the scripted drivers' are
        self.digest = digest
        self._weights = tuple(np.ascontiguousarray(tensors[f"{i}.weight"], np.float64) for i in range(count))
        self._biases = tuple(np.ascontiguousarray(tensors[f"{i}.bias"], np.float64) for i in range(count))
        self._activations = np.array([ACTIVATIONS[activation]] * (count - 1) + [ACTIVATIONS["identity"]])

    def logits(self, rows: np.ndarray) -> np.ndarray:
        """Outputs of the network (n, actions) for observations (n, d)."""
        outputs = np.empty((len(rows), len(self._biases[-1])))
        feed_forward(self._weights, self._biases, self._activations, np.ascontiguousarray(rows, np.float64), outputs)
        return outputs

    def predict(
        self, observation_: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        """SB3's `predict`, on one observation (d,) or a batch (n, d); always the likeliest action."""
        values = np.asarray(observation_)
        actions = self.logits(np.atleast_2d(values)).argmax(axis=1)
        return (actions if values.ndim > 1 else actions[0]), state


def load(folder: str | os.PathLike[str], world: World, called: str | None = None) -> RoadAgent:
    """The driver in a folder, for a road; errors call it `called`, or by its folder.

    Raises
    ------
    ParamsError
        For a missing, truncated or foreign file, an unknown or missing field, a value out of bounds, a tensor of
        another shape or with a value that is not finite, or a road, information or blindness that it was not made for.
    """
    try:
        text, blob = files.read(Path(folder))
        document = files.document_of(text)
        network, interface = files.network_of(document["network"]), document["interface"]
        files.same_names(f"{files.DOCUMENT}, interface", interface, INTERFACE)
        if not isinstance(interface["radio"], bool):
            raise ParamsError(f"{files.DOCUMENT}, interface: radio must be true or false, got {interface['radio']!r}")
        information = world.params.interface.information
        if interface["information"] != information:
            raise ParamsError(
                f"{files.DOCUMENT}: it was made for information {interface['information']!r}, and this road has "
                f"{information!r}"
            )
        if interface["radio"] and not world.radio:
            raise ParamsError(f"{files.DOCUMENT}: it was made to see the vehicles, and this road has radio = false")
        if document["observation"] != inputs(world) or interface["actions"] != list(world.actions):
            raise ParamsError(
                f"{files.DOCUMENT}: it was made for {len(document['observation'])} fields and actions "
                f"{interface['actions']!r}, and this road has {len(inputs(world))} and {list(world.actions)}; scene, "
                "vehicles and information must be as in training"
            )
        if network.lstm or network.stack != 1 or network.squash or network.clip:
            raise ParamsError(f"{files.DOCUMENT}, network: on a road only dense layers are supported")
        if network.zeroed != "nothing":
            raise ParamsError(f"{files.DOCUMENT}, network: zeroed must be 'nothing' on a road, got {network.zeroed!r}")
        tensors = files.tensors_of(blob, shapes(network.layers, world))
        if not interface["radio"] and tensors["0.weight"][of_vehicles(world)].any():
            raise ParamsError(f"{files.DOCUMENT}, interface: radio is false, but its weights read the vehicles' fields")
    except ParamsError as error:
        raise ParamsError(f"{called or f'policy folder {os.fspath(folder)!r}'}: {error}") from error
    return RoadAgent(tensors, network.activation, hashlib.sha256(text + blob).hexdigest())
