"""Training on a road: the recipe, a run of a few decisions, the exported driver."""

import json
import shutil
from itertools import pairwise

import numpy as np
import pytest

from rss_gym.baselines.road import World, make
from rss_gym.cli import main
from rss_gym.highway import observation
from rss_gym.highway.env import RoadEnv
from rss_gym.params import ParamsError, Reward
from rss_gym.train import recipe as world_recipes
from rss_gym.train import road

SHORT = "algorithm.n_steps=8 algorithm.batch_size=16 algorithm.n_epochs=1 validation.episodes=1 recipe.n_envs=2".split()
SHORT += "imitation.episodes=1 imitation.epochs=1 imitation.critic_steps=16 validation.every_steps=16".split()


def test_shipped_recipes_name_every_number():
    for name, path in road.recipes().items():
        found = road.load(name)
        text = path.read_text(encoding="utf-8")
        for section in ("algorithm", "policy", "imitation", "validation"):
            for key in found.to_dict()[section]:
                assert f"\n{key} = " in text, key
        assert not road.is_road("ppo-short") and name not in world_recipes.recipes()


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"recipe.env": "rss_gym/Higway-v0"}, "is no road; did you mean 'rss_gym/Highway-v0'"),
        ({"algorithm.gama": 0.9}, "no parameter 'gama'; did you mean 'gamma'"),
        ({"algorithm.batch_size": 100}, "batch_size must divide n_steps"),
        ({"recipe.env": ["rss_gym/Highway-v0"]}, "is no road"),
        ({"policy.zeroed": "radio"}, "zeroed must be 'nothing' on a road, got 'radio'; .*world.radio = false"),
        ({"vec.n_envs": 2}, "write section.key=value"),
        ({"imitation.policy": "rul"}, "policy = 'rul' is no driver to imitate; did you mean 'rule'"),
        ({"imitation.policy": "idm"}, "policy = 'idm' is no driver to imitate"),
        ({"imitation.episodes": 1, "imitation.critic_steps": 8_192}, "critic_steps must be below the 8192 steps"),
        ({"imitation.disturbance": 1.5}, r"disturbance must be in \[0, 1\]"),
    ],
)
def test_refused(changes, sentence):
    with pytest.raises(ParamsError, match=sentence):
        road.load("highway", changes)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"imitation.policy": "rule:lateral_m=99"}, r"lateral_m must be in \[0.5, 10\]"),
        ({"world.config": {"action": {"type": "ContinuousAction"}}}, "only highway-env's meta-actions can be learnt"),
    ],
)
def test_what_cannot_be_trained_is_refused_before_a_folder_is_made(changes, sentence, tmp_path):
    with pytest.raises(ParamsError, match=sentence):
        road.start(road.load("highway", changes), tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_file_whose_env_is_no_name_is_no_road(tmp_path):
    file = tmp_path / "wrong.toml"
    file.write_text("[recipe]\nenv = []\n", encoding="utf-8")
    assert not road.is_road(str(file))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Two seeds of 16 decisions, by the command."""
    pytest.importorskip("stable_baselines3")
    out = tmp_path_factory.mktemp("runs") / "short"
    assert main(["train", "highway", "--steps", "48", "--seeds", "2", "--out", str(out), "--set", *SHORT]) == 0
    return out


def test_run_holds_what_was_done(run):
    document = json.loads((run / "run.json").read_text())
    assert document["recipe"]["algorithm"]["n_steps"] == 8 and document["seeds"] == 2
    assert "highway-env" in document["versions"]
    for seed in ("seed-0", "seed-1"):
        assert (run / seed / "validation.csv").read_text().startswith("steps,episodes,collision_rate")
        assert (run / seed / "progress.csv").stat().st_size > 0
    assert (
        "seed 0 of 2" in (run / "agent" / "card.md").read_text()
        or "seed 1 of 2" in (run / "agent" / "card.md").read_text()
    )
    record = json.loads((run / "agent" / "policy.json").read_text())["training"]
    assert record["difference"] <= 1e-4 and record["seed"] in (0, 2**20)


def test_a_run_on_a_road_is_not_gone_on_with(run, capsys):
    assert main(["train", "--resume", str(run)]) == 2
    assert "it is one on a road, which is not gone on with; its driver is in agent/" in capsys.readouterr().err


def test_driver_is_scored_by_its_folder(run, tmp_path, capsys):
    arguments = ["eval", "--suite", "highway-v0", "--episodes", "1", "--policy", str(run / "agent")]
    assert main([*arguments, "--out", str(tmp_path / "scores")]) == 0
    assert "short" in capsys.readouterr().out


def test_driver_of_another_road_is_refused(run):
    env = RoadEnv("merge", vehicles=3)
    with pytest.raises(ParamsError, match="it was made for 129 fields"):
        make(str(run / "agent"), World.of(env))


def test_driver_of_another_information_level_is_refused(run):
    """The oracle's fields are those of the paper, and mean something else."""
    env = RoadEnv(information="oracle")
    with pytest.raises(ParamsError, match="it was made for information 'positions', and this road has 'oracle'"):
        make(str(run / "agent"), World.of(env))


def test_a_driver_with_zeroed_fields_is_refused(run, tmp_path):
    folder = shutil.copytree(run / "agent", tmp_path / "agent")
    document = json.loads((folder / "policy.json").read_text())
    document["network"]["zeroed"] = "radio"
    (folder / "policy.json").write_text(json.dumps(document))
    with pytest.raises(ParamsError, match="zeroed must be 'nothing' on a road, got 'radio'"):
        make(str(folder), World.of(RoadEnv()))


def vehicle_fields(env):
    names = [field.name for field in observation.fields(env.params)]
    return np.char.startswith(names, "vehicle_")


def test_imitation_sees_the_vehicles_where_the_actor_does_not():
    pytest.importorskip("stable_baselines3")
    from rss_gym.train.road.imitation import drives

    changes = {"imitation.episodes": 2, "imitation.disturbance": 0.5}
    (seen, chosen), (blind, same) = (
        drives(road.load("highway", {**changes, "world.radio": radio}), seed=0) for radio in (True, False)
    )
    vehicles = vehicle_fields(RoadEnv())
    assert np.array_equal(chosen, same) and len(set(chosen)) > 1
    assert seen[:, vehicles].any() and not blind[:, vehicles].any()
    assert np.array_equal(seen[:, ~vehicles], blind[:, ~vehicles])


def test_the_actor_waits_for_the_critic_and_is_compared_on_what_was_seen(tmp_path, monkeypatch):
    pytest.importorskip("stable_baselines3")
    from rss_gym.train.actor import parameters
    from rss_gym.train.road import learner

    found = []

    def export(model, world, radio, observations, *rest):
        found.append((model.num_timesteps, [p.detach().numpy().copy() for p in parameters(model.policy)], observations))
        return original(model, world, radio, observations, *rest)

    original = learner.export
    monkeypatch.setattr(learner, "export", export)
    monkeypatch.setattr(learner, "validate", lambda *given: learner.Score(given[-1], 1, 0.0, 0.0, 0.0, -given[-1]))
    changes = dict(item.split("=") for item in SHORT)
    recipe = road.load("highway", {key: int(value) for key, value in changes.items()} | {"recipe.steps": 48})
    learner.train_seed(recipe, tmp_path / "seed-0", 0, {})
    steps, weights, seen = zip(*found, strict=True)
    assert steps == (0, 16, 32, 48)
    alike = [all(np.array_equal(*pair) for pair in zip(*pair, strict=True)) for pair in pairwise(weights)]
    assert alike == [True, False, False]
    assert all(np.abs(rows).sum(axis=1).all() for rows in seen)


def test_imitation_fits_the_actor():
    sb3 = pytest.importorskip("stable_baselines3")
    from rss_gym.train.road.imitation import imitate

    recipe = road.load("highway", {"imitation.episodes": 6, "imitation.epochs": 300})
    model = sb3.PPO("MlpPolicy", recipe.environment(), policy_kwargs={"net_arch": [64]}, seed=0, device="cpu")
    message = imitate(model, recipe, seed=0)
    assert message.startswith("imitated rule in ") and float(message.split()[-2].rstrip("%")) > 80.0


def test_exported_network_is_sb3s():
    """On observations of random actions; log-probabilities within 1e-4, and so the same actions."""
    sb3 = pytest.importorskip("stable_baselines3")
    from rss_gym.train.road.export import agent, compare

    env = RoadEnv()
    model = sb3.PPO("MlpPolicy", env, policy_kwargs={"net_arch": [32]}, n_steps=2, batch_size=2, seed=3, device="cpu")
    rows = np.random.default_rng(0).uniform(-1.0, 1.0, (1000, env.observation_space.shape[0])).astype(np.float32)
    driver = agent(model, World.of(env), radio=True)
    assert compare(model, driver, rows) < 1e-4
    assert np.array_equal(driver.predict(rows)[0], model.predict(rows, deterministic=True)[0])


def test_a_driver_trained_without_radio_drives_without(run, tmp_path):
    pytest.importorskip("stable_baselines3")
    out = tmp_path / "blind"
    arguments = ["train", "highway", "--steps", "32", "--out", str(out), "--set", *SHORT, "world.radio=false"]
    assert main(arguments) == 0
    env = RoadEnv()
    blind = make(str(out / "agent"), World.of(env))
    rows = np.random.default_rng(0).uniform(-1.0, 1.0, (50, env.observation_space.shape[0]))
    others = rows.copy()
    others[:, vehicle_fields(env)] = 0.5
    assert np.array_equal(blind.logits(rows), blind.logits(others))
    without = World.of(RoadEnv(radio=False))
    assert np.array_equal(make(str(out / "agent"), without).logits(rows), blind.logits(rows))
    with pytest.raises(ParamsError, match=r"it was made to see the vehicles, and this road has radio = false$"):
        make(str(run / "agent"), without)
    document = json.loads((run / "agent" / "policy.json").read_text())
    document["interface"]["radio"] = False
    false = shutil.copytree(run / "agent", tmp_path / "false")
    (false / "policy.json").write_text(json.dumps(document))
    with pytest.raises(ParamsError, match="radio is false, but its weights read the vehicles' fields"):
        make(str(false), World.of(env))


def test_best_is_chosen_by_the_prices_of_the_scores(tmp_path):
    pytest.importorskip("stable_baselines3")
    from rss_gym.train.road import learner

    recipe = road.load("highway")
    assert recipe.environment().params.reward.collision_price_m == 10.0
    assert learner._Keeper(recipe, tmp_path, {}).env.params.reward == Reward()
