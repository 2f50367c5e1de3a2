"""Recipes: the shipped ones are complete, what is wrong is named in one sentence, and they survive JSON."""

import dataclasses
import inspect
import json
import tomllib

import pytest

from rss_gym.domain import ROAD
from rss_gym.params import Params, ParamsError
from rss_gym.train.hyperparameters import ALGORITHMS, Schedule
from rss_gym.train.recipe import from_dict, load, parse_changes, recipes

NAMES = sorted(recipes())


def tables(name="ppo"):
    return tomllib.loads(recipes()[name].read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", NAMES)
def test_shipped_recipes_name_every_hyperparameter(name):
    recipe, written = load(name), tables(name)
    for section, group in (
        ("vec", recipe.vec),
        ("algorithm", recipe.hyperparameters),
        ("policy", recipe.policy),
        ("imitation", recipe.imitation),
        ("validation", recipe.validation),
        ("checkpoint", recipe.checkpoint),
    ):
        if section == "imitation" and not recipe.imitation.episodes:
            assert section not in written
            continue
        assert sorted(written[section]) == sorted(field.name for field in dataclasses.fields(group))
    assert recipe.summary


@pytest.mark.parametrize("name", NAMES)
def test_a_recipe_survives_json(name):
    comfort = {} if load(name).domain is ROAD else {"comfort_m": 20.0}
    stages = [{"start": 0.25, "channel": ["paper", "quadcopter"], **comfort}]
    recipe = load(name, {"curriculum": stages})
    again = from_dict(name, json.loads(json.dumps(recipe.to_dict())))
    assert again == recipe
    assert not comfort or again.params_of(1).reward.comfort_m == 20.0
    assert len(again.params_of(1).channels) == 2


def test_every_learner_has_its_hyperparameters_and_defaults():
    pytest.importorskip("sb3_contrib", reason="sb3-contrib (extra `train`) is not installed")
    import importlib

    code = {"policy", "env", "policy_kwargs", "verbose", "seed", "device", "_init_setup_model", "tensorboard_log"}
    code |= {"stats_window_size", "action_noise", "use_sde_at_warmup"}
    exploration = {"use_sde", "sde_sample_freq"}  # with which SAC's policy cannot be exported
    code |= {f"{kind}_buffer_{what}" for kind in ("rollout", "replay") for what in ("class", "kwargs")}
    code |= {"optimize_memory_usage"}
    for kind in ALGORITHMS.values():
        arguments = inspect.signature(getattr(importlib.import_module(kind.module), kind.name)).parameters
        known = {field.name: field.default for field in dataclasses.fields(kind.hyperparameters)}
        assert set(arguments) - code - (exploration - set(known)) == set(known)
        for name, default in known.items():
            value = default.start if isinstance(default, Schedule) else default
            assert value == (arguments[name].default or 0), name


def test_changes_of_a_command_line():
    changes = parse_changes(
        ["algorithm.learning_rate=1e-3", "world.channel=quadcopter", "policy.net_arch=[8, 4]", "recipe.steps=7"]
    )
    recipe = load("ppo", changes)
    assert recipe.hyperparameters.learning_rate == Schedule(1e-3)
    assert recipe.params.channels == Params.of(channel="quadcopter").channels
    assert recipe.policy.net_arch == (8, 4) and recipe.steps == 7


def test_a_recipe_from_a_file_and_its_channels_as_numbers(tmp_path):
    channel = tmp_path / "radio.toml"
    channel.write_text("[channel]\npath_loss_factor = 2.2\n")
    file = tmp_path / "mine.toml"
    text = recipes()["ppo"].read_text(encoding="utf-8")
    file.write_text(
        text.replace("[world]", f'[world]\nchannel = ["paper", {json.dumps(str(channel))}]\n#'), encoding="utf-8"
    )
    recipe = load(file)
    channel.unlink()
    assert recipe.name == "mine"
    assert [channel.path_loss_factor for channel in recipe.params.channels] == [2.7, 2.2]


def test_stages():
    recipe = load(
        "ppo",
        {
            "recipe.steps": 1000,
            "curriculum": [{"start": 0.2, "comfort_m": 20.0}, {"start": 0.5, "collision_price_m": 500.0}],
        },
    )
    assert [recipe.stage(steps) for steps in (0, 199, 200, 499, 500, 1000)] == [0, 0, 1, 1, 2, 2]
    assert [recipe.params_of(stage).reward.comfort_m for stage in range(3)] == [25.0, 20.0, 25.0]
    assert [recipe.params_of(stage).reward.collision_price_m for stage in range(3)] == [0.0, 0.0, 500.0]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"algorithm.learning_rat": 1e-3}, ["[algorithm]", "'learning_rat'", "did you mean 'learning_rate'"]),
        ({"algorithm.learning_rate": -1}, ["learning_rate", "-1"]),
        ({"algorithm.learning_rate": True}, ["learning_rate", "True"]),
        ({"algorithm.learning_rate": {"start": 1e-3, "ende": 0}}, ["learning_rate", "'ende'", "{start, end}"]),
        ({"algorithm.learning_rate": {"start": 1e-3, "end": 2}}, ["end", "[0, 1]", "2"]),
        ({"algorithm.learning_rate": float("nan")}, ["learning_rate", "nan"]),
        ({"algorithm.gamma": "high"}, ["gamma", "'high'"]),
        ({"algorithm.gamma": 1.5}, ["gamma", "1.5"]),
        ({"algorithm.n_steps": 1.5}, ["n_steps", "whole number"]),
        ({"algorithm.batch_size": 3000}, ["batch_size", "3000", "8192"]),
        ({"policy.net_arch": [0]}, ["net_arch", "[0]"]),
        ({"policy.net_arch": 64}, ["net_arch", "64"]),
        ({"policy.net_arch": [8] * 9}, ["net_arch", "8 layers"]),
        ({"policy.activation": "tan"}, ["activation", "did you mean 'tanh'"]),
        ({"policy.lstm_hidden_size": 8}, ["[policy]", "'lstm_hidden_size'"]),
        ({"policy.zeroed": "rang"}, ["[policy]", "'rang'", "did you mean 'range'"]),
        ({"policy.zeroed": ["range"]}, ["[policy]", "zeroed", "one of nothing, range, approach, radio"]),
        ({"imitation.policy": 3}, ["[imitation]", "policy", "3"]),
        ({"imitation.policy": "orka"}, ["[imitation]", "'orka'", "did you mean 'orca'"]),
        ({"imitation.policy": "mpc:radius=3"}, ["[imitation]", "'radius'", "did you mean 'radius_m'"]),
        ({"imitation.policy": "a:b"}, ["[imitation]", "'a'", "unknown"]),
        ({"imitation.policy": "mpc@oracle"}, ["[imitation]", "'mpc@oracle'", "information", "'oracle'"]),
        ({"imitation.episodes": -1}, ["[imitation]", "episodes", "-1"]),
        ({"imitation.epoch": 2}, ["[imitation]", "'epoch'", "did you mean 'epochs'"]),
        ({"vec.n_envs": 0}, ["[vec]", "n_envs", "0"]),
        ({"vec.normalise_reward": 1}, ["normalise_reward", "true or false"]),
        ({"world.comfort": 3}, ["'comfort'", "did you mean 'comfort_m'"]),
        ({"world.comfort_m": -3}, ["comfort_m", "-3"]),
        ({"world.channel": "papr"}, ["'papr'", "did you mean 'paper'"]),
        ({"world.channel": []}, ["channel", "empty"]),
        ({"world.action": "discrete"}, ["discrete", "velocity"]),
        ({"world.families": "crosing"}, ["'crosing'", "did you mean 'crossing'"]),
        ({"recipe.algorithm": "pppo"}, ["'pppo'", "did you mean 'ppo'"]),
        ({"recipe.env": "rss_gym/Encounter-v1"}, ["'rss_gym/Encounter-v1'", "did you mean"]),
        ({"recipe.steps": 0}, ["steps", "0"]),
        ({"recipe.steps": "many"}, ["steps", "'many'"]),
        ({"recipe.summary": 3}, ["summary", "3"]),
        ({"recipe.name": "x"}, ["[recipe]", "'name'"]),
        ({"validation.episodes": 0}, ["[validation]", "episodes"]),
        ({"checkpoint.every": 5}, ["[checkpoint]", "'every'", "did you mean 'every_steps'"]),
        ({"policies.net_arch": [8]}, ["'policies'", "did you mean 'policy'"]),
        ({"algorithm": 3}, ["algorithm", "section.key=value"]),
        ({"curriculum.start": 3}, ["curriculum.start", "section.key=value"]),
        ({"curriculum": 3}, ["curriculum = 3", "list of tables"]),
        ({"curriculum": [3]}, ["[[curriculum]]", "start"]),
        ({"curriculum": [{"comfort_m": 3.0}]}, ["[[curriculum]]", "start"]),
        ({"curriculum": [{"start": 1.0}]}, ["start", "[0, 1)", "1.0"]),
        ({"curriculum": [{"start": 0.5}, {"start": 0.5}]}, ["start = 0.5", "exceed 0.5"]),
        ({"curriculum": [{"start": 0.5, "comfort": 3.0}]}, ["'comfort'", "did you mean"]),
        ({"curriculum": [{"start": 0.5, "intruders": 2}]}, ["0.5", "intruders", "[world]"]),
        ({"curriculum": [{"start": 0.5, "information": "oracle"}]}, ["0.5", "[world]"]),
    ],
)
def test_bad_input_is_one_sentence(changes, words):
    with pytest.raises(ParamsError) as caught:
        load("ppo", {"imitation.episodes": 1, **changes})
    assert "\n" not in str(caught.value)
    for word in words:
        assert word in str(caught.value)


def test_state_dependent_exploration_is_refused_on_a_road():
    with pytest.raises(ParamsError, match="use_sde explores continuous actions"):
        load("highway", {"algorithm.use_sde": True})


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[recipe", ["not readable TOML"]),
        ("recipe = 3", ["recipe = 3", "table"]),
        ("[recipe]\nenv = 'rss_gym/Encounter-v0'\nsteps = 3", ["[recipe]: algorithm is missing", "recurrent-ppo"]),
        ("[recipes]", ["'recipes'", "did you mean 'recipe'"]),
        ("x = '" + "a" * 70000 + "'", ["larger than"]),
    ],
)
def test_bad_files_are_refused_in_one_sentence(text, words, tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(text)
    with pytest.raises(ParamsError) as caught:
        load(file)
    assert "\n" not in str(caught.value)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("name", "words"), [("pppo", "did you mean 'ppo'"), ("no/such", "does not exist"), ("no.toml", "does not exist")]
)
def test_unknown_recipes(name, words):
    with pytest.raises(ParamsError, match=words):
        load(name)


@pytest.mark.parametrize("item", ["steps", "=3", ""])
def test_a_change_without_a_value_is_refused(item):
    with pytest.raises(ParamsError, match="key=value"):
        parse_changes([item])


def test_other_algorithms_have_their_own_keys():
    with pytest.raises(ParamsError, match=r"\[policy\].*'log_std_init'"):
        load("sac", {"policy.log_std_init": 0.0})
    with pytest.raises(ParamsError, match='ent_coef must be a number or "auto"'):
        load("sac", {"algorithm.ent_coef": "high"})
    for name in ("sac", "recurrent-ppo"):
        with pytest.raises(ParamsError, match=f"imitation.*'{name}'"):
            load(name, {"imitation.episodes": 10})
    with pytest.raises(ParamsError, match="shared_lstm"):
        load("recurrent-ppo", {"policy.shared_lstm": True})


def test_a_recipe_draws_radios_as_the_world_does():
    drawn = load("ppo", {"world.channel": "radios"})
    assert drawn.params.channels == Params.of(channel="radios").channels
    assert from_dict("again", drawn.to_dict()).params == drawn.params
