"""The study of learned drivers: paired differences from the rule, and what its criteria say of them."""

import numpy as np
import pytest

from rss_gym.baselines import AGENTS
from rss_gym.cli import main
from rss_gym.eval.studies.roads.learned import Driver, criteria, driver
from rss_gym.params import ParamsError, Reward


def table(collisions, deviation_m, n=400):
    """An episode table as far as the study reads it."""
    found = np.zeros(n, [("collision", bool), ("snmac", bool), ("deviation_mean_m", float)])
    found["collision"][:collisions] = found["snmac"][:collisions] = True
    found["deviation_mean_m"] = deviation_m + np.linspace(-1.0, 1.0, n)
    return found


@pytest.mark.parametrize(
    ("collisions", "deviation_m", "met"), [(5, 10.0, True), (5, 20.0, False), (39, 10.0, False), (60, 10.0, False)]
)
def test_both_have_to_be_better(collisions, deviation_m, met):
    prices = Reward(deviation_price=0.02, snmac_price_m=0.4, collision_price_m=8.0)  # 420 m for a collision
    seeing, blind = Driver("seeing", "", "", False, prices), Driver("blind", "", "", True, prices)
    tables = {"rule": table(40, 15.0), "seeing": table(collisions, deviation_m), "blind": table(100, 10.0)}
    first, ablation = criteria([seeing, blind], tables)
    assert first.met == met and ablation.met
    assert "collisions minus rule's" in first.measured
    mean_m = 10.0 - deviation_m + 420.0 * (100 - collisions) / 400
    assert ablation.measured.startswith(f"{mean_m:+.1f} [")
    tables["blind"] = tables["seeing"]
    assert not criteria([seeing, blind], tables)[1].met


def test_drivers_are_flown_on_their_road(tmp_path, capsys):
    pytest.importorskip("stable_baselines3")
    from rss_gym.train import recipe as recipes
    from rss_gym.train.learner import Learner

    for name, zeroed in (("one", "nothing"), ("two", "radio")):
        recipe = recipes.load("highway", {"recipe.env": "rss_gym/Merge-v0", "policy.zeroed": zeroed})
        Learner.new(recipe, 0).export(tmp_path / name, {"recipe": recipe.to_dict()})
    folders = [str(tmp_path / name) for name in ("one", "two")]
    prices = recipe.params.reward
    assert driver(folders[1]) == Driver("two without the radio", folders[1], "rss_gym/Merge-v0", True, prices)
    assert main(["study", "roads", "--episodes", "3", "--learned", *folders]) == 0
    said = capsys.readouterr().out
    assert "Learned drivers on merge-v0" in said and "`two without the radio` costs more than `one`" in said


def test_a_driver_of_the_air_is_refused():
    with pytest.raises(ParamsError, match="must hold a driver trained on"):
        driver(str(AGENTS["ppo-plane"]))
