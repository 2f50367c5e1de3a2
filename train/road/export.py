"""From a PPO of Stable-Baselines3 with discrete actions to a policy folder that cannot run code."""

from __future__ import annotations

import dataclasses
import os
from typing import Any

import numpy as np

from rss_gym.baselines.policy_files import FORMAT, WEIGHTS, Network
from rss_gym.baselines.road import World
from rss_gym.baselines.road.agent import RoadAgent, inputs, load, of_vehicles, shapes
from rss_gym.files import new_folder
from rss_gym.params import ParamsError
from rss_gym.train.export import array, dense_layers, write_document

TOLERANCE = 1e-4  # of log-probabilities, which SB3 computes in single precision


def taken(model: Any, world: World, radio: bool) -> tuple[dict[str, np.ndarray], Network]:
    """Tensors (float32) and architecture of the part of the model that acts; without `radio` blind to the vehicles.

    Raises
    ------
    ParamsError
        For a model of another kind, or for another road.
    """
    policy, kind = model.policy, type(model).__name__
    if not hasattr(policy, "mlp_extractor") or not hasattr(model.action_space, "n"):
        raise ParamsError(f"a {kind} with actions {model.action_space} cannot be exported; PPO with discrete ones can")
    linear, activation = dense_layers(policy.mlp_extractor.policy_net, kind)
    tensors: dict[str, np.ndarray] = {}
    for index, layer in enumerate([*linear, policy.action_net]):
        weight, bias = array(layer.weight).T, array(layer.bias)
        tensors |= {f"{index}.weight": np.ascontiguousarray(weight, np.float32), f"{index}.bias": bias}
    network = Network(layers=tuple(layer.out_features for layer in linear), activation=activation)
    for name, shape in shapes(network.layers, world).items():
        if tensors[name].shape != shape:
            raise ParamsError(f"the model does not fit the road: {name} is {tensors[name].shape}, not {shape}")
    if not radio:  # these weights never learnt anything: their inputs were zero
        tensors["0.weight"] = np.where(of_vehicles(world)[:, None], np.float32(0.0), tensors["0.weight"])
    return tensors, network


def agent(model: Any, world: World, radio: bool) -> RoadAgent:
    """The driver that `export` would write, in memory."""
    tensors, network = taken(model, world, radio)
    return RoadAgent(tensors, network.activation)


def export(
    model: Any,
    world: World,
    radio: bool,
    observations: np.ndarray,
    out: str | os.PathLike[str],
    training: dict[str, Any] | None = None,
) -> float:
    """Write `policy.json` and `policy.safetensors` into the new folder `out`.

    Returns
    -------
    float
        Greatest difference between the folder's log-probabilities and SB3's on `observations` (n, d).

    Raises
    ------
    ParamsError
        As `taken`, or for a difference above 1e-4; nothing is then written.
    """
    from safetensors.numpy import save

    tensors, network = taken(model, world, radio)
    document = {
        "format": FORMAT,
        "network": dataclasses.asdict(network),
        "interface": {
            "information": world.params.interface.information,
            "radio": radio,
            "actions": list(world.actions),
        },
        "observation": inputs(world),
        "training": {},
    }
    with new_folder(out) as folder:
        write_document(folder, document)
        (folder / WEIGHTS).write_bytes(save(tensors))
        difference = compare(model, load(folder, world), observations)
        if not difference <= TOLERANCE:
            raise ParamsError(
                f"the exported driver differs from SB3's by {difference:.2g} in its log-probabilities; at most "
                f"{TOLERANCE:g} is allowed, so nothing was written"
            )
        write_document(folder, {**document, "training": {**(training or {}), "difference": difference}})
    return difference


def compare(model: Any, driver: RoadAgent, observations: np.ndarray) -> float:
    """Greatest difference of the log-probabilities of the actions on observations (n, d)."""
    import torch

    with torch.no_grad():
        seen = torch.as_tensor(np.asarray(observations, np.float32))
        expected = model.policy.get_distribution(seen).distribution.logits.numpy()
    logits = driver.logits(observations)
    peak = logits.max(axis=1, keepdims=True)
    found = logits - peak - np.log(np.exp(logits - peak).sum(axis=1, keepdims=True))
    return float(np.abs(found - expected).max())
