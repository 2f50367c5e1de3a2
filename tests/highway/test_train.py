"""Training on a road, by the trainer of the air: recipe, run, resumption, export, shipping."""

import json
import shutil

import numpy as np
import pytest

from rss_gym.baselines import make
from rss_gym.baselines.agent import load as load_agent
from rss_gym.cli import main
from rss_gym.highway import observation
from rss_gym.highway.params import RoadParams
from rss_gym.params import ParamsError
from rss_gym.train import recipe as recipes
from rss_gym.train import run as runs

pytestmark = pytest.mark.slow

SHORT = "algorithm.n_steps=8 algorithm.batch_size=16 algorithm.n_epochs=1 validation.episodes=1 vec.n_envs=2".split()
SHORT += "imitation.episodes=1 imitation.epochs=1 imitation.critic_steps=16 validation.every_steps=16".split()
ROAD = RoadParams.of()


def short(**more):
    return recipes.load("highway", {**recipes.parse_changes(SHORT), **more})


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"recipe.env": "rss_gym/Higway-v0"}, "is unknown; did you mean 'rss_gym/Highway-v0'"),
        ({"algorithm.gama": 0.9}, "no parameter 'gama'; did you mean 'gamma'"),
        ({"algorithm.batch_size": 100}, "batch_size must divide n_steps"),
        ({"world.radio": False}, r"radio = false is of the environment alone; \[policy\] zeroed = 'radio'"),
        ({"world.families": "mixed"}, "a road has no parameter 'families'"),
        ({"imitation.policy": "rul"}, "policy 'rul' is unknown on a road; did you mean 'rule'"),
        ({"imitation.policy": "idm"}, "policy 'idm' is a driver of highway-env, which chooses no actions"),
        ({"imitation.policy": "rule:lateral_m=99"}, r"lateral_m must be a number in \[0.5, 10\]"),
    ],
)
def test_refused(changes, sentence):
    with pytest.raises(ParamsError, match=sentence):
        recipes.load("highway", changes)


@pytest.mark.parametrize("algorithm", ["sac", "pathwise"])
def test_an_algorithm_without_discrete_actions_is_refused(algorithm):
    tables = {"recipe": {"algorithm": algorithm, "env": "rss_gym/Highway-v0", "steps": 10}}
    with pytest.raises(ParamsError, match=f"'{algorithm}' cannot choose a road's discrete actions"):
        recipes.from_dict("mine", tables)


def test_other_actions_are_refused_before_a_folder_is_made(tmp_path):
    pytest.importorskip("stable_baselines3")
    changes = {"world.config": {"action": {"type": "ContinuousAction"}}, "imitation.episodes": 0}
    with pytest.raises(ParamsError, match="only highway-env's meta-actions can be learnt"):
        runs.start(recipes.load("highway", changes), tmp_path / "run")
    assert not (tmp_path / "run").exists()


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Two seeds of 48 decisions, by the command."""
    pytest.importorskip("stable_baselines3")
    out = tmp_path_factory.mktemp("runs") / "short"
    assert main(["train", "highway", "--steps", "48", "--seeds", "2", "--out", str(out), "--set", *SHORT]) == 0
    return out


def test_run_holds_what_was_done(run):
    document = json.loads((run / "run.json").read_text())
    assert document["recipe"]["algorithm"]["n_steps"] == 8 and document["seeds"] == [0, 2**20]
    assert "highway-env" in document["versions"] and document["world"]["road"]["scene"] == "highway"
    for seed in ("seed-0", "seed-1"):
        assert (run / seed / "validation.csv").read_text().startswith("steps,cpu_s,episodes,faults,cost_m")
        assert (run / seed / "progress.csv").stat().st_size > 0
    record = json.loads((run / "agent" / "policy.json").read_text())["training"]
    assert record["difference"] == 0.0 and record["seed"] in (0, 2**20)


def test_a_run_goes_on_from_its_checkpoints(run, tmp_path, capsys):
    copy = shutil.copytree(run, tmp_path / "run")
    document = json.loads((copy / "run.json").read_text())
    document["recipe"]["recipe"]["steps"] = 64
    (copy / "run.json").write_text(json.dumps(document))
    assert main(["train", "--resume", str(copy)]) == 0
    assert (copy / "seed-0" / "validation.csv").read_text().splitlines()[-1].startswith("64,")
    assert "agent: " in capsys.readouterr().out


def test_a_run_is_exported_and_scored(run, tmp_path, capsys):
    assert main(["export", str(run), "--out", str(tmp_path / "mine")]) == 0
    arguments = ["eval", "--suite", "highway-v0", "--episodes", "1", "--policy", str(tmp_path / "mine")]
    assert main([*arguments, "--out", str(tmp_path / "scores")]) == 0
    assert main(["verify", str(tmp_path / "scores")]) == 0
    assert "mine" in capsys.readouterr().out


def test_a_model_of_sb3_is_exported(tmp_path):
    pytest.importorskip("stable_baselines3")
    from rss_gym.train.convert import export_model
    from rss_gym.train.learner import Learner

    learner = Learner.new(short(), 3)
    learner.save_model(tmp_path / "model.zip")
    assert export_model(tmp_path / "model.zip", tmp_path / "out", "rss_gym/Highway-v0") == 0.0
    assert load_agent(tmp_path / "out", ROAD).discrete


def test_a_run_is_shipped(run, tmp_path):
    from rss_gym.train.ship import ship

    card = (ship(run, "mine", "- Short.", tmp_path / "agents") / "card.md").read_text()
    assert "`rss_gym/Highway-v0`, three lanes" in card and "vehicles observed: 6" in card and "- Short." in card


@pytest.mark.parametrize(
    ("road", "sentence"),
    [
        (RoadParams.of(scene="merge", vehicles=3), "it was made for 154 fields"),
        (RoadParams.of(information="oracle"), "cannot fly on information 'oracle': it was trained on 'positions'"),
        (RoadParams.of(scene="intersection"), r"tensor '2.weight' must be float32 \(128, 3\)"),
    ],
)
def test_another_road_is_refused(run, road, sentence):
    with pytest.raises(ParamsError, match=sentence):
        make(str(run / "agent"), road)


def vehicle_fields():
    return np.array([field.name.startswith(("vehicle_", "on_")) for field in observation.fields(ROAD)])


def test_imitation_sees_the_vehicles_where_the_actor_does_not():
    pytest.importorskip("stable_baselines3")
    from rss_gym.train.imitation import _flown
    from rss_gym.train.learner import Learner

    changes = {"imitation.episodes": 2, "imitation.disturbance": 0.5}
    (seen, chosen, _), (blind, same, _) = (
        _flown(Learner.new(short(**changes, **{"policy.zeroed": zeroed}), 0)) for zeroed in ("nothing", "radio")
    )
    vehicles = vehicle_fields()
    assert np.array_equal(chosen, same) and len(set(chosen)) > 1
    assert seen[:, vehicles].any() and not blind[:, vehicles].any()
    assert np.array_equal(seen[:, ~vehicles], blind[:, ~vehicles])


def test_imitation_fits_the_actor():
    pytest.importorskip("stable_baselines3")
    from rss_gym.train.imitation import imitate
    from rss_gym.train.learner import Learner

    learner = Learner.new(short(**{"imitation.episodes": 6, "imitation.epochs": 300, "policy.net_arch": [64]}), 0)
    said = imitate(learner)
    assert said.startswith("imitated rule in ") and float(said.split()[-2].rstrip("%")) > 80.0


def test_an_exported_network_is_sb3s():
    """On observations at random: the same actions, and the logits to single precision."""
    pytest.importorskip("stable_baselines3")
    import torch

    from rss_gym.train.learner import Learner

    learner = Learner.new(short(), 3)
    rows = np.random.default_rng(0).uniform(-1.0, 1.0, (1000, len(vehicle_fields()))).astype(np.float32)
    agent = learner.agent()
    assert np.array_equal(agent.predict(rows)[0], learner.model.predict(rows, deterministic=True)[0])
    with torch.no_grad():
        expected = learner.model.policy.get_distribution(torch.as_tensor(rows)).distribution.logits.numpy()
    found, _ = agent.outputs(rows, None, None)
    found -= np.log(np.exp(found).sum(axis=1, keepdims=True))
    assert np.abs(found - expected).max() < 1e-4


def test_an_agent_trained_without_the_radio_drives_without(tmp_path):
    pytest.importorskip("stable_baselines3")
    from rss_gym.train.learner import Learner

    Learner.new(short(**{"policy.zeroed": "radio"}), 0).export(tmp_path / "blind", {})
    blind = load_agent(tmp_path / "blind", ROAD)
    rows = np.random.default_rng(0).uniform(-1.0, 1.0, (50, len(vehicle_fields())))
    others = rows.copy()
    others[:, vehicle_fields()] = 0.5
    assert np.array_equal(blind.outputs(rows, None, None)[0], blind.outputs(others, None, None)[0])


def test_the_best_is_chosen_by_the_prices_of_the_scores():
    pytest.importorskip("stable_baselines3")
    from rss_gym.train.validation import Validator

    recipe = short()
    assert recipe.params.reward.collision_price_m == 10.0
    score = Validator(recipe.params, 2).score(make("none", recipe.params), "none")
    assert score.metrics["cost_m"].value >= 10_000.0 * score.metrics["collision_rate"].value > 0.0
