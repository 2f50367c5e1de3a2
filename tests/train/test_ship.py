"""Shipping agents: the folder holds the run's best policy, and a card that tells where it is from."""

import csv
import json
import shutil
from xml.etree import ElementTree

import pytest

from rss_gym.baselines import shipped
from rss_gym.baselines.agent import load
from rss_gym.params import Params, ParamsError
from rss_gym.train import recipe, run, ship


def test_the_folder_holds_the_best_policy_and_its_curves(tiny_run, tiny_agent):
    assert {file.name for file in tiny_agent.iterdir()} == {
        "policy.json", "policy.safetensors", "card.md", "curves.csv", "curves.svg"
    }  # fmt: skip
    assert load(tiny_agent).digest == load(tiny_run / "agent").digest
    with open(tiny_agent / "curves.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["seed"], row["steps"]) for row in rows] == [
        (seed, steps) for seed in ("0", "1048576") for steps in ("1024", "2048")
    ]
    with open(tiny_run / "seed-1" / "validation.csv", newline="") as file:
        own = list(csv.DictReader(file))
    assert [row["path_deviation_mean_m"] for row in rows[2:]] == [row["path_deviation_mean_m"] for row in own]
    drawn = ElementTree.parse(tiny_agent / "curves.svg").getroot()
    assert drawn.tag == "{http://www.w3.org/2000/svg}svg" and "shipped" in "".join(drawn.itertext())


def test_the_card_tells_what_the_run_knows(tiny_run, tiny_agent):
    text, document = (tiny_agent / "card.md").read_text(), json.loads((tiny_run / "run.json").read_text())
    assert "algorithm.n_epochs = 1" in text and "algorithm.learning_rate" not in text  # what differs from the recipe
    assert f"torch {document['versions']['torch']}" in text and "channels: paper" in text
    for index, seed in enumerate(document["seeds"]):
        kept = load(tiny_run / f"seed-{index}" / "best").document["training"]["validation"]
        line = next(line for line in text.splitlines() if line.startswith(f"| {seed} | {kept['steps']:,} |"))
        assert (
            f"{kept['cost_m']:.2f}" in line
            and f"{kept['collision_rate']:.2e}" in line
            and f"{kept['path_deviation_mean_m']:.2f}" in line
        )
    assert text.rstrip().endswith("- It has hardly been trained.")


@pytest.mark.slow
def test_the_cheapest_over_more_encounters_is_shipped(tiny_run, tmp_path):
    folder = ship.ship(tiny_run, "cheapest", into=tmp_path, encounters=300)
    made, document = run.read(tiny_run)
    seeds = ship.flown_again(ship.seeds_of(tiny_run, made, document["seeds"]), made, 300)
    marks = [seed.again["cost_m"] for seed in seeds]
    assert marks[0] < marks[1] and all(seed.again["episodes"] == 300 for seed in seeds)
    assert load(folder).digest == seeds[0].agent.digest
    text = (folder / "card.md").read_text()
    assert "the same 300 encounters" in text
    assert f"{seeds[0].again['collision_rate']:.2e}" in text and f"shipped: {seeds[0].number} |" in text


def test_what_the_card_says_of_other_worlds():
    params = Params.of(planar=False, intruders=3, intruders_min=1, channel=["clean", {"path_loss_factor": 2.5}])
    text = ship.described(params)
    for part in ("in space", "1 to 3", "clean", "1 of its own"):
        assert part in text
    plain, other = recipe.load("ppo"), recipe.load("ppo", {"curriculum": [{"start": 0.5, "comfort_m": 20.0}]})
    assert ship.changed(plain) == {} and "curriculum" in str(ship.changed(other))
    assert ship.later(other) == {"changes on the way": "from 50% of the steps on comfort_m"}


@pytest.mark.slow
def test_shipping_again_replaces_the_folder(tiny_run, tmp_path):
    ship.ship(tiny_run, "twice", "- First.", tmp_path)
    (tmp_path / "twice" / "left.txt").write_text("over")
    folder = ship.ship(tiny_run, "twice", "- Second.", tmp_path)
    assert "Second" in (folder / "card.md").read_text() and not (folder / "left.txt").exists()
    assert shipped.found(tmp_path) == {"twice": folder} and len(list(tmp_path.iterdir())) == 1


def test_only_a_finished_run_is_shipped(tiny_run, tmp_path):
    with pytest.raises(ParamsError, match="small letters"):
        ship.ship(tiny_run, "No Name", "", tmp_path)
    other = tmp_path / "run"
    shutil.copytree(tiny_run, other)
    document = json.loads((other / "run.json").read_text())
    document["recipe"]["recipe"]["steps"] += 1
    (other / "run.json").write_text(json.dumps(document))
    with pytest.raises(ParamsError, match="2048 of 2049 steps"):
        ship.ship(other, "early", "", tmp_path / "agents")
    shutil.copyfile(tiny_run / "run.json", other / "run.json")
    shutil.copyfile(other / "agent" / "policy.json", tmp_path / "policy.json")
    (other / "agent" / "policy.json").write_text((tmp_path / "policy.json").read_text() + "\n")
    with pytest.raises(ParamsError, match="not the best policy"):
        ship.ship(other, "foreign", "", tmp_path / "agents")
    assert not (tmp_path / "agents").exists() and run.read(other)
