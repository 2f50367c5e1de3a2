"""The world of a suite and the network of an agent as one program of JavaScript."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from rss_gym import encounters, observation, state, world
from rss_gym.baselines.agent import Agent
from rss_gym.baselines.network import feed_forward
from rss_gym.core import SPLITS, Seen
from rss_gym.eval.suites import Suite
from rss_gym.javascript import Program, fresh, kind_of, literal
from rss_gym.params import Params, ParamsError
from rss_gym.sensed import OTHER, OWN

FLIGHT = Path(__file__).with_name("flight.js")
# Arguments of the kernels, by the names of `one_row`.
RESET = ("state", "seen", "mask", "split", "seeds", "numbers", "observations")
STEP = ("state", "seen", "mask", "actions", "observations", "rewards")


def program(suite: Suite, agent: Agent) -> str:
    """Code that defines `rssWorld`: encounters of the suite, flown by whoever gives actions, and the agent's actions.

    Parameters
    ----------
    suite : Suite
        A suite of the air.
    agent : Agent
        A feed-forward policy of one observation.

    Returns
    -------
    str
        JavaScript that needs nothing else; `flight.js` says what it defines.

    Raises
    ------
    ParamsError
        For a suite or an agent that a page cannot fly.
    TranslationError
        For a kernel that the translator does not know.
    """
    if suite.domain.name != "air" or not isinstance(suite.params, Params):
        raise ParamsError(f"suite {suite.name!r} is flown on roads; a page flies encounters in the air")
    network = agent.network
    if network.lstm or network.stack > 1 or network.clip or agent.discrete or network.zeroed != "nothing":
        raise ParamsError(
            "a page flies agents of one plain network with continuous actions: no recurrent layer, no stacked, "
            "normalised or zeroed observations"
        )
    rows = one_row(suite.params)
    translated = Program()
    names = {
        "reset": translated.add(world.reset, [kind_of(rows[name]) for name in RESET]),
        "step": translated.add(world.step, [kind_of(rows[name]) for name in STEP]),
    }
    layers = agent.layers
    inputs, outputs = np.zeros((1, len(layers[0][0]))), np.zeros((1, len(layers[1][-1])))
    names["think"] = translated.add(feed_forward, [kind_of(value) for value in (*layers, inputs, outputs)])
    parts = [f"{name}: () => {_made(value)}" for name, value in rows.items()]
    parts += [f"layers: {literal(layers)}", f"inputs: {inputs.size}, outputs: {outputs.size}"]
    parts += [f"{name}: {code}" for name, code in names.items()]
    parts += [f"flown: {{split: {SPLITS[suite.split]}, seed: {suite.seed}n}}"]
    return (
        "const rssWorld = (() => {\n"
        + translated.code
        + "const $parts = {\n"
        + ",\n".join(parts)
        + "\n};\n"
        + FLIGHT.read_text(encoding="utf-8")
        + "})();\n"
    )


def one_row(params: Params) -> dict[str, Any]:
    """The arguments of `reset` and `step` for a batch of one, as `rss_gym.core.Batch` makes them."""
    table = observation.transforms(observation.fields(params))
    others = np.zeros((1, params.encounter.intruders), OTHER)
    return {
        "state": state.allocate(params, encounters.table(params.encounter), 1),
        "seen": Seen(np.zeros(1, OWN), others, np.zeros(len(table)), table),
        "mask": np.ones(1, bool),
        "split": np.zeros(1, np.int64),
        "seeds": np.zeros(1, np.uint64),
        "numbers": np.zeros(1, np.uint64),
        "actions": np.zeros((1, 3)),
        "observations": np.zeros((1, len(table)), np.float32),
        "rewards": np.zeros(1),
    }


def _made(value: Any) -> str:
    """The expression that makes a value anew: zeros by their shape, all else as a literal."""
    if hasattr(value, "_fields"):
        return "({" + ", ".join(f"{name}: {_made(getattr(value, name))}" for name in value._fields) + "})"
    if not np.any(value.view(np.uint8)):
        return fresh(value.dtype, value.shape)
    return literal(value)
