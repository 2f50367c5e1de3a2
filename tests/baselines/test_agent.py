"""Learned policies from a folder: what is read, what is refused, and what the fields that are taken away are."""

import json
import shutil

import numpy as np
import pytest
from safetensors.numpy import save

from rss_gym import baselines, observation
from rss_gym.baselines.agent import load
from rss_gym.baselines.masks import MASKS, kept
from rss_gym.baselines.policy_files import DOCUMENT, FORMAT, WEIGHTS, Network
from rss_gym.core import Batch, decode
from rss_gym.eval import policies
from rss_gym.params import Params, ParamsError

NETWORK = {
    "layers": [8],
    "activation": "tanh",
    "stack": 2,
    "zeroed": "nothing",
    "lstm": 4,
    "squash": False,
    "clip": 5.0,
}


def folder(path, params, network=NETWORK, **changes):
    """A policy folder with random weights."""
    rng, net = np.random.default_rng(0), Network(**{**network, "layers": tuple(network["layers"])})
    tensors = {name: rng.normal(size=shape).astype(np.float32) for name, shape in net.shapes(params).items()}
    if "std" in tensors:
        tensors["std"] = np.abs(tensors["std"]) + 0.1
    document = {"format": FORMAT, "network": network, "interface": {"information": params.interface.information}}
    document |= {"observation": net.inputs(params), "training": {}} | changes
    path.mkdir(exist_ok=True)
    (path / DOCUMENT).write_text(json.dumps(document))
    (path / WEIGHTS).write_bytes(save(tensors))
    return path


@pytest.mark.parametrize("information", ["oracle", "positions", "ranges"])
def test_it_flies_in_the_world_it_is_given(tmp_path, information):
    params = Params.of(information=information, channel="outdoor")
    agent = baselines.make(str(folder(tmp_path / "agent", params)), params)
    assert agent.params == params and load(tmp_path / "agent").params == Params.of(information=information)
    batch = Batch(params, 3)
    batch.reset(np.ones(3, bool))
    state = alone = None
    for step in range(5):
        first = np.full(3, step == 3)
        actions, state = agent.predict(batch.observations, state, first)
        one, alone = agent.predict(batch.observations[1], alone, first[:1])
        np.testing.assert_array_equal(one, actions[1])
        assert state.shape == (3, len(observation.fields(params)) + 8)
        batch.step(decode(actions, params, 3), np.ones(3, bool))


def test_another_level_of_information_is_refused_by_name(tmp_path):
    path = str(folder(tmp_path / "agent", Params()))
    for information in ("oracle", "ranges"):
        with pytest.raises(ParamsError) as caught:
            baselines.make(path, Params.of(information=information))
        for word in (path, repr(information), "'positions'"):
            assert word in str(caught.value)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"format": 1}, ["format = 1 must be 2"]),
        ({"interface": {"information": "paper"}}, ["'paper'", "known: oracle, positions, ranges"]),
        ({"interface": {}}, ["interface.information is missing"]),
        ({"interface": {"information": "positions", "reach_m": 60.0}}, ["'interface.reach_m' is unknown"]),
        ({"network": NETWORK | {"features": "none"}}, ["'network.features' is unknown"]),
        ({"network": NETWORK | {"zeroed": "everything"}}, ["'everything'"]),
        ({"observation": ["time_s"]}, ["1 fields"]),
    ],
)
def test_what_is_not_of_this_format_is_refused(tmp_path, changes, words):
    path = (
        folder(tmp_path / "agent", Params(), **changes)
        if "network" not in changes
        else folder(tmp_path / "agent", Params())
    )
    if "network" in changes:
        document = json.loads((path / DOCUMENT).read_text()) | changes
        (path / DOCUMENT).write_text(json.dumps(document))
    with pytest.raises(ParamsError) as caught:
        load(path, Params())
    for word in words:
        assert word in str(caught.value)


def test_another_number_of_intruders_or_axes_is_refused(tmp_path):
    path = folder(tmp_path / "agent", Params())
    for keywords in ({"planar": False}, {"intruders": 2}):
        with pytest.raises(ParamsError, match="planar and intruders must be as in training"):
            load(path, Params.of(**keywords))


def test_masks_take_away_what_they_say():
    params = Params.of(intruders=2)
    names = np.array([field.name for field in observation.fields(params)])
    assert kept("nothing", params).all() and len(kept("range", params, 3)) == 3 * len(names)
    gone = set(names[kept("range", params) == 0.0])
    assert {"intruder_0.range_m", "intruder_1.margin_m", "intruder_1.coloured_tc_s"} <= gone
    assert not {"intruder_0.warning", "intruder_0.track_position_along_m", "intruder_0.message_age_s"} & gone
    assert set(names[kept("radio", params) == 0.0]) == {name for name in names if name.startswith("intruder_")}
    approach = set(names[kept("approach", params) == 0.0])
    assert {"intruder_0.flown_time_s", "intruder_1.planned_distance_m", "intruder_1.flown_miss_along_m"} <= approach
    assert not {name for name in approach if "track" in name or "message" in name}
    assert set(MASKS) == {"nothing", "range", "approach", "radio"}


def test_the_folder_of_a_run_names_its_agent(tmp_path):
    shutil.copytree(baselines.AGENTS["ppo-plane"], tmp_path / "run" / "agent")
    run, agent = (baselines.make(str(tmp_path / name)) for name in ("run", "run/agent"))
    assert run.digest == agent.digest
    assert policies.entry(str(tmp_path / "run"), Params()).name == "run"
    with pytest.raises(ParamsError, match="unknown"):
        baselines.make(str(tmp_path))
