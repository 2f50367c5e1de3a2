"""Exported policies act as SB3's do, whatever the algorithm, the wrappers and the batch."""

import json

import numpy as np
import pytest

pytest.importorskip("sb3_contrib", reason="sb3-contrib (extra `train`) is not installed")

import torch
from sb3_contrib import RecurrentPPO
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.vec_env import VecFrameStack, VecNormalize

from rss_gym.baselines.agent import load
from rss_gym.baselines.masks import kept
from rss_gym.params import Params, ParamsError
from rss_gym.sb3 import make_vec_env
from rss_gym.train.export import Inputs, Normalisation, export
from rss_gym.train.masked import Masked

WORLDS = {
    "plane": ("rss_gym/Encounter-v0", {}),
    "space": ("rss_gym/Encounter3D-v0", {}),
    "range": ("rss_gym/EncounterRangeOnly-v0", {"intruders": 2}),
    "oracle": ("rss_gym/Encounter-v0", {"information": "oracle"}),
}


def model_of(kind, venv, **network):
    options = {"seed": 0, "device": "cpu", "policy_kwargs": network}
    if kind is PPO:
        return PPO("MlpPolicy", venv, n_steps=8, batch_size=16, n_epochs=1, **options)
    if kind is RecurrentPPO:
        return RecurrentPPO("MlpLstmPolicy", venv, n_steps=8, batch_size=16, n_epochs=1, **options)
    return SAC("MlpPolicy", venv, learning_starts=8, train_freq=4, buffer_size=64, batch_size=16, **options)


@pytest.mark.parametrize("world", sorted(WORLDS))
@pytest.mark.parametrize(
    ("kind", "network"),
    [
        (PPO, {"net_arch": [16, 8], "log_std_init": -1.0}),
        (PPO, {"net_arch": [], "activation_fn": torch.nn.ReLU}),
        (SAC, {"net_arch": [16]}),
        (RecurrentPPO, {"net_arch": [8], "lstm_hidden_size": 12}),
    ],
)
def test_actions_equal_sb3(kind, network, world, tmp_path):
    name, keywords = WORLDS[world]
    venv = make_vec_env(name, 4, seed=1, **keywords)
    params = venv.params
    model = model_of(kind, venv, **network)
    model.learn(64)
    assert export(model, params, tmp_path / "agent") <= 1e-5
    agent = load(tmp_path / "agent", params)
    venv.seed(9)
    seen = venv.reset()
    expected, _ = model.predict(seen, deterministic=True)
    actions, _ = agent.predict(seen)
    np.testing.assert_allclose(actions, expected, atol=1e-5)


def test_the_mean_of_state_dependent_exploration_is_exported(tmp_path):
    venv = make_vec_env("rss_gym/Encounter-v0", 4, seed=1)
    model = PPO("MlpPolicy", venv, n_steps=8, batch_size=16, n_epochs=1, seed=0, device="cpu", use_sde=True)
    model.learn(64)
    assert export(model, venv.params, tmp_path / "agent") <= 1e-5


def test_normalisation_and_stack(tmp_path):
    venv = make_vec_env("rss_gym/Encounter-v0", 4, seed=1)
    wrapped = VecNormalize(VecFrameStack(venv, 3), clip_obs=2.0)
    model = model_of(PPO, wrapped, net_arch=[16])
    model.learn(400)
    normalisation = Normalisation.of(wrapped)
    assert export(model, venv.params, tmp_path / "agent", Inputs(normalisation, stack=3)) <= 1e-5
    agent = load(tmp_path / "agent", venv.params)
    assert (agent.network.stack, agent.network.clip) == (3, 2.0)
    # Flown through SB3's own wrappers, and by the folder from bare observations.
    wrapped.training = False
    wrapped.seed(5)
    seen, memory, first = wrapped.reset(), None, np.ones(4, bool)
    for _ in range(300):
        expected, _ = model.predict(seen, deterministic=True)
        actions, memory = agent.predict(venv.batch.observations.copy(), memory, first)
        np.testing.assert_allclose(actions, expected, atol=1e-5)
        seen, _, first, _ = wrapped.step(expected)


@pytest.mark.parametrize("world", sorted(WORLDS))
def test_fields_taken_away_stay_away(world, tmp_path):
    """From stacked observations too, and from the last one of an episode, which is not that of the next."""
    name, keywords = WORLDS[world]
    venv = make_vec_env(name, 4, seed=1, **keywords)
    wrapped = VecNormalize(Masked(VecFrameStack(venv, 2), "range", venv.params), clip_obs=3.0)
    model = model_of(PPO, wrapped, net_arch=[16])
    model.learn(400)
    normalisation = Normalisation.of(wrapped)
    assert export(model, venv.params, tmp_path / "agent", Inputs(normalisation, stack=2, zeroed="range")) <= 1e-5
    agent = load(tmp_path / "agent", venv.params)
    assert (agent.network.stack, agent.network.zeroed) == (2, "range")
    wrapped.training = False
    wrapped.seed(5)
    seen, memory, first = wrapped.reset(), None, np.ones(4, bool)
    mask, ended = kept("range", venv.params, 2), 0
    for _ in range(300):
        expected, _ = model.predict(seen, deterministic=True)
        actions, memory = agent.predict(venv.batch.observations.copy(), memory, first)
        np.testing.assert_allclose(actions, expected, atol=1e-5)
        bare = venv.batch.observations.copy()
        seen, _, first, infos = wrapped.step(expected)
        original = wrapped.get_original_obs()
        assert not original[:, mask == 0.0].any() and original[:, mask == 1.0].any()
        for row in np.flatnonzero(first):
            last = wrapped.unnormalize_obs(infos[row]["terminal_observation"])
            assert np.abs(last[mask == 0.0]).max() < 1e-6
            ended += not np.array_equal(last[mask == 1.0], original[row][mask == 1.0])
        assert not np.array_equal(bare, venv.batch.observations)
    assert ended


def test_rows_do_not_depend_on_the_batch(tmp_path):
    venv = make_vec_env("rss_gym/Encounter-v0", 7, seed=1)
    model = model_of(RecurrentPPO, venv, net_arch=[8], lstm_hidden_size=8)
    export(model, venv.params, tmp_path / "agent")
    agent = load(tmp_path / "agent", venv.params)
    seen, memory = venv.reset(), None
    alone: list = [None] * 7
    for _ in range(5):
        actions, memory = agent.predict(seen, memory)
        for row in range(7):
            action, alone[row] = agent.predict(seen[row], alone[row])
            np.testing.assert_array_equal(action, actions[row])
            np.testing.assert_array_equal(alone[row][0], memory[row])
        seen = venv.step(actions)[0]


def test_a_difference_writes_nothing(tmp_path, monkeypatch):
    venv = make_vec_env("rss_gym/Encounter-v0", 2, seed=1)
    model = model_of(PPO, venv)
    monkeypatch.setattr("rss_gym.train.export.compare", lambda *_: 2e-5)
    with pytest.raises(ParamsError, match="2e-05"):
        export(model, venv.params, tmp_path / "agent")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("network", "words"),
    [({"activation_fn": torch.nn.ELU}, "Tanh or ReLU"), ({"lstm_hidden_size": 8, "n_lstm_layers": 2}, "2 layers")],
)
def test_foreign_networks_are_refused(network, words, tmp_path):
    venv = make_vec_env("rss_gym/Encounter-v0", 2, seed=1)
    model = model_of(RecurrentPPO if "lstm_hidden_size" in network else PPO, venv, **network)
    with pytest.raises(ParamsError, match=words):
        export(model, venv.params, tmp_path / "agent")


def test_another_world_is_refused(tmp_path):
    model = model_of(PPO, make_vec_env("rss_gym/Encounter3D-v0", 2, seed=1))
    with pytest.raises(ParamsError, match="does not fit"):
        export(model, Params(), tmp_path / "agent")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    venv = make_vec_env("rss_gym/Encounter-v0", 2, seed=1)
    place = tmp_path_factory.mktemp("agents") / "agent"
    export(model_of(PPO, venv, net_arch=[8]), venv.params, place, training={"seed": 0})
    return place


def broken(folder, tmp_path, change):
    import shutil

    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    change(copy)
    return copy


def edit(**changes):
    def change(copy):
        path = copy / "policy.json"
        document = json.loads(path.read_text())
        for name, value in changes.items():
            part, _, key = name.partition("__")
            if key:
                document[part][key] = value
            else:
                document[part] = value
        path.write_text(json.dumps(document))

    return change


def tensors(change):
    def apply(copy):
        from safetensors.numpy import load_file, save_file

        found = load_file(copy / "policy.safetensors")
        change(found)
        save_file(found, copy / "policy.safetensors")

    return apply


def poison(found):
    found["0.weight"][0, 0] = np.nan


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda copy: (copy / "policy.json").unlink(), "policy.json cannot be read"),
        (lambda copy: (copy / "policy.safetensors").unlink(), "policy.safetensors cannot be read"),
        (lambda copy: (copy / "policy.json").write_text("{"), "not JSON"),
        (lambda copy: (copy / "policy.json").write_text("[]"), "must be a table with format, network"),
        (lambda copy: (copy / "policy.json").write_text("[" * 100_000), "not JSON"),
        (lambda copy: (copy / "policy.json").write_bytes(b"\x80\x04"), "not JSON"),
        (edit(format=1), "format = 1 must be"),
        (edit(wights=1), "field 'wights' is unknown"),
        (edit(network__layers=[8] * 99), "layers"),
        (edit(network__layers=[10**9]), "layers"),
        (edit(network__layers="8"), "layers"),
        (edit(network__activation="elu"), "activation"),
        (edit(network__stack=0), "stack"),
        (edit(network__zeroed="rang"), "did you mean 'range'"),
        (edit(network__zeroed=["range"]), "zeroed"),
        (edit(network__features="approach"), "field 'network.features' is unknown"),
        (edit(network__lstm=True), "lstm"),
        (edit(network__clip=float("nan")), "clip"),
        (edit(network__squash=1), "squash"),
        (edit(network__clip="1"), "clip"),
        (edit(interface__information="position"), "did you mean 'positions'"),
        (edit(interface__action="velocity"), "field 'interface.action' is unknown"),
        (edit(interface={}), "interface.information is missing"),
        (edit(observation=["range_m"]), "fields"),
        (edit(network__layers=[9]), "0.weight"),
        (lambda copy: (copy / "policy.safetensors").write_bytes(b""), "truncated"),
        (lambda copy: (copy / "policy.safetensors").write_bytes(b"\xff" * 100), "header"),
        (lambda copy: (copy / "policy.safetensors").write_bytes(b"\x10" + b"\0" * 50), "not a safetensors"),
        (
            lambda copy: (copy / "policy.safetensors").write_bytes((copy / "policy.safetensors").read_bytes()[:-4]),
            "not a safetensors",
        ),
        (tensors(poison), "not finite"),
        (tensors(lambda found: found.pop("0.bias")), "0.bias is missing"),
        (tensors(lambda found: found.update(extra=np.zeros(1, np.float32))), "field 'extra' is unknown"),
        (tensors(lambda found: found.update({"0.bias": found["0.bias"].astype(np.float64)})), "float32"),
    ],
)
def test_broken_folders_are_one_sentence(folder, tmp_path, change, words):
    with pytest.raises(ParamsError, match=words) as caught:
        load(broken(folder, tmp_path, change))
    assert "copy" in str(caught.value) and "\n" not in str(caught.value) and len(str(caught.value)) < 900


def test_no_pickle_is_opened(folder, tmp_path):
    def change(copy):
        import pickle

        (copy / "policy.safetensors").write_bytes(pickle.dumps(print))

    with pytest.raises(ParamsError):
        load(broken(folder, tmp_path, change))


def test_digest_tells_agents_apart(folder, tmp_path):
    assert load(folder).digest == load(folder).digest
    assert load(broken(folder, tmp_path, edit(training__seed=1))).digest != load(folder).digest
