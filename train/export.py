"""From a model of Stable-Baselines3 to a policy folder that cannot run code, checked against SB3's own `predict`.

Reading SB3's `.zip` unpickles Python objects, which runs code from the file: only here, and only when asked to.
"""

from __future__ import annotations

import dataclasses
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rss_gym.baselines.agent import Agent, load
from rss_gym.baselines.masks import kept
from rss_gym.baselines.policy_files import DOCUMENT, FORMAT, WEIGHTS, Network
from rss_gym.domain import domain_of
from rss_gym.files import new_folder
from rss_gym.params import Params, ParamsError

TOLERANCE = 1e-5  # of an action in [-1, 1]
OBSERVATIONS = {"air": 1000, "road": 100}  # a drive takes a hundred times the time of a flight


@dataclass(frozen=True)
class Normalisation:
    """Statistics of SB3's `VecNormalize`: mean and variance a field, the clip, and what is added to the variance."""

    mean: np.ndarray
    variance: np.ndarray
    clip: float
    epsilon: float = 1e-8

    @classmethod
    def of(cls, wrapper: Any) -> Normalisation | None:
        """Of a `VecNormalize`; None where it leaves observations as they are."""
        if not wrapper.norm_obs:
            return None
        statistics = wrapper.obs_rms
        return cls(statistics.mean.copy(), statistics.var.copy(), float(wrapper.clip_obs), float(wrapper.epsilon))

    def __call__(self, rows: np.ndarray) -> np.ndarray:
        """Rows as the network sees them, float32."""
        scaled = (rows - self.mean) / np.sqrt(self.variance + self.epsilon)
        return np.clip(scaled, -self.clip, self.clip).astype(np.float32)


@dataclass(frozen=True)
class Inputs:
    """What stands between the observations and the model.

    Parameters
    ----------
    normalisation : Normalisation, optional
        What `VecNormalize` did to all that follows.
    stack : int
        Observations stacked by `VecFrameStack`.
    zeroed : str
        What is taken away from them, one of `rss_gym.baselines.masks.MASKS`.
    """

    normalisation: Normalisation | None = None
    stack: int = 1
    zeroed: str = "nothing"


PLAIN = Inputs()


def export(
    model: Any,
    params: Params,
    out: str | os.PathLike[str],
    inputs: Inputs = PLAIN,
    training: dict[str, Any] | None = None,
) -> float:
    """Write `policy.json` and `policy.safetensors` into the new folder `out`.

    Parameters
    ----------
    model : BaseAlgorithm
        PPO, SAC or RecurrentPPO with a multilayer perceptron (after the recurrent layer).
    params : Params
        The world it was trained in; its interface goes into the file.
    out : path
        New folder.
    inputs : Inputs
        What it was given of them.
    training : dict, optional
        Record of the training, in JSON types.

    Returns
    -------
    float
        Greatest difference between the folder's actions and SB3's on observations of 1,000 decisions (100 on a road);
        the training record holds it too, as `difference`.

    Raises
    ------
    ParamsError
        For a model of another kind or for another world, or a difference above 1e-5; nothing is then written.
    """
    from safetensors.numpy import save

    document, tensors = _described(model, params, inputs)
    with new_folder(out) as folder:
        write_document(folder, document)
        (folder / WEIGHTS).write_bytes(save(tensors))
        difference = compare(model, folder, params, inputs.normalisation)
        if not difference <= TOLERANCE:
            raise ParamsError(
                f"the exported policy differs from SB3's by {difference:.2g} on observations; at most "
                f"{TOLERANCE:g} is allowed, so nothing was written"
            )
        write_document(folder, {**document, "training": {**(training or {}), "difference": difference}})
    return difference


def agent(model: Any, params: Params, inputs: Inputs = PLAIN) -> Agent:
    """The policy that `export` would write, in memory; for the parameters and errors see there."""
    document, tensors = _described(model, params, inputs)
    network = Network(**document["network"])
    return Agent(network, {name: tensor.astype(np.float64) for name, tensor in tensors.items()}, params, document, "")


def _described(model: Any, params: Params, inputs: Inputs) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """`policy.json` without the training record, and the tensors of `policy.safetensors`."""
    network, tensors = _taken(model, inputs)
    shapes = network.shapes(params)
    for name, shape in shapes.items():
        if tensors[name].shape != shape:
            raise ParamsError(
                f"the model does not fit the world: {name} is {tensors[name].shape}, and stack {inputs.stack} "
                f"needs {shape}; name the environment it was trained in"
            )
    document = {
        "format": FORMAT,
        "network": dataclasses.asdict(network),
        "interface": {"information": params.interface.information},
        "observation": network.inputs(params),
        "training": {},
    }
    return document, {name: tensors[name] for name in shapes}


def write_document(folder: Path, document: dict[str, Any]) -> None:
    """Write `policy.json`."""
    (folder / DOCUMENT).write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def compare(model: Any, folder: Path, params: Params, normalisation: Normalisation | None = None) -> float:
    """Greatest difference of the actions over many decisions of ten rows, flown by the folder's policy."""
    agent, domain = load(folder, params), domain_of(params)
    rows = 10
    batch, everything = domain.make_batch(agent.params, rows), np.ones(rows, bool)
    batch.seed(np.arange(rows, dtype=np.uint64))
    batch.reset(everything)
    memory, state, first, worst = None, None, everything, 0.0
    mask = kept(agent.network.zeroed, agent.params, agent.network.stack)
    stacked = np.zeros((rows, agent.network.stack * batch.observations.shape[1]))
    for _ in range(OBSERVATIONS[domain.name] // rows):
        stacked[first] = 0.0
        stacked = np.concatenate([stacked, batch.observations], axis=1)[:, batch.observations.shape[1] :]
        seen = stacked * mask
        seen = seen.astype(np.float32) if normalisation is None else normalisation(seen)
        expected, state = model.predict(seen, state=state, episode_start=first, deterministic=True)
        actions, memory = agent.predict(batch.observations, memory, first)
        worst = max(worst, float(np.abs(actions - expected).max()))
        batch.step(domain.decode(actions, agent.params, rows), np.ones(rows, bool))
        first = batch.episode["terminated"] | batch.episode["truncated"]
        if first.any():
            batch.reset(first)
    return worst


def _taken(model: Any, inputs: Inputs) -> tuple[Network, dict[str, np.ndarray]]:
    """Architecture and tensors of the part of the model that acts."""
    policy, kind, normalisation = model.policy, type(model).__name__, inputs.normalisation
    lstm = getattr(policy, "lstm_actor", None)
    if hasattr(policy, "action_net") and hasattr(policy, "mlp_extractor"):
        hidden, last, squash = policy.mlp_extractor.policy_net, policy.action_net, False
    elif hasattr(getattr(policy, "actor", None), "latent_pi"):
        hidden, last, squash = policy.actor.latent_pi, policy.actor.mu, True
    else:
        raise ParamsError(f"a model of kind {kind!r} cannot be exported; PPO, SAC and RecurrentPPO can")
    if len(model.action_space.shape) != 1 and not hasattr(model.action_space, "n"):
        raise ParamsError(f"an action space {model.action_space} cannot be exported; Box and Discrete can")
    linear, activation = dense_layers(hidden, kind)
    tensors: dict[str, np.ndarray] = {}
    for index, layer in enumerate([*linear, last]):
        tensors |= {f"{index}.weight": array(layer.weight).T, f"{index}.bias": array(layer.bias)}
    units = 0
    if lstm is not None:
        if lstm.num_layers != 1:
            raise ParamsError(f"an LSTM of {lstm.num_layers} layers cannot be exported; one of a single layer can")
        units = lstm.hidden_size
        tensors |= {
            "lstm.input": array(lstm.weight_ih_l0).T,
            "lstm.hidden": array(lstm.weight_hh_l0).T,
            "lstm.bias": array(lstm.bias_ih_l0) + array(lstm.bias_hh_l0),
        }
    if normalisation is not None:
        std = np.sqrt(normalisation.variance + normalisation.epsilon)
        tensors |= {"mean": normalisation.mean.astype(np.float32), "std": std.astype(np.float32)}
    network = Network(
        layers=tuple(layer.out_features for layer in linear),
        activation=activation,
        stack=inputs.stack,
        zeroed=inputs.zeroed,
        lstm=units,
        squash=squash,
        clip=0.0 if normalisation is None else normalisation.clip,
    )
    return network, {name: np.ascontiguousarray(tensor, dtype=np.float32) for name, tensor in tensors.items()}


def dense_layers(hidden: Any, kind: str) -> tuple[list[Any], str]:
    """The dense layers of a `Sequential`, and the activation between them."""
    import torch

    names = {torch.nn.Tanh: "tanh", torch.nn.ReLU: "relu"}
    linear = [layer for layer in hidden if isinstance(layer, torch.nn.Linear)]
    others = {type(layer) for layer in hidden if not isinstance(layer, torch.nn.Linear)}
    if not others <= set(names) or len(others) > 1 or len(linear) * 2 != len(hidden):
        raise ParamsError(f"the network of this {kind} cannot be exported: dense layers with Tanh or ReLU can")
    return linear, names[others.pop()] if others else "identity"


def array(tensor: Any) -> np.ndarray:
    """A parameter of PyTorch."""
    return tensor.detach().cpu().numpy()
