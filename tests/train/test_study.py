"""`rss-gym study learning`: what a section says of its trainings, and that a kept training is not done again."""

import csv
from dataclasses import dataclass, field

import pytest

pytest.importorskip("stable_baselines3")

from rss_gym.eval.metrics import Estimate
from rss_gym.train.recipe import load
from rss_gym.train.study import ablations, curves, page, radios
from rss_gym.train.study.training import Trained, Trainer

METRICS = ("cost_m", "collision_rate", "path_deviation_mean_m", "unnecessary_manoeuvre_rate", "risk_ratio")


@dataclass
class Told:
    """A trainer whose costs are told to it: those of agents by recipe, of scripted policies by name."""

    costs: dict
    cpu_s: float = 50.0
    episodes: int = 100
    asked: list = field(default_factory=list)

    def train(self, name, changes=None, seeds=None):
        self.asked.append((name, changes))
        rows = [{"steps": "0", "cpu_s": "0", "cost_m": "9"}, {"steps": "10", "cpu_s": str(self.cpu_s), "cost_m": "4"}]
        return [Trained(number, f"{name}/{number}", rows) for number in range(seeds or 2)]

    def score(self, policies, suite, **changes):
        self.asked.append((suite, changes))
        found = {}
        for name, policy in policies.items():
            value = self.costs.get(str(policy).split("/")[0], 8.0)
            found[name] = {metric: Estimate(value, value - 1.0, value + 1.0, 100, "m") for metric in METRICS}
        return found


@pytest.mark.parametrize(
    ("cost", "cpu_s", "met"), [(3.0, 50.0, True), (9.0, 50.0, False), (3.0, 500.0, False)], ids=["", "dear", "slow"]
)
def test_a_criterion_of_the_curves_needs_every_seed_to_be_cheap_and_soon(cost, cpu_s, met):
    told = Told({"pathwise": cost, "mpc": 4.0}, cpu_s)
    (criterion,) = [one for one in curves.section(told).criteria if "`pathwise`" in one.text]
    assert criterion.met == met
    assert ("5 of 5" in criterion.measured) == (cost < 4.0) and f"after {cpu_s:.0f} s" in criterion.measured
    assert "`mpc`, 4.0 m" in criterion.text


def test_an_ablation_flies_in_the_world_that_it_was_trained_in():
    told = Told({"pathwise": 4.0})
    text = ablations.ablations(told).markdown
    assert ("pathwise", {"recipe.steps": ablations.AGENT_STEPS, "world.estimator": "ls"}) in told.asked and (
        "encounter-v0",
        {"estimator": "ls"},
    ) in told.asked
    assert ("encounter-v0", {"track_range": False}) in told.asked
    assert "4.00 (+0.00)" in text and text.count("| imitation |") == ablations.SEEDS + 1


@pytest.mark.parametrize(
    "recipe, steps, table",
    [
        (ablations.AGENT, ablations.AGENT_STEPS, ablations.WITHOUT),
        (ablations.LEARNER, ablations.LEARNER_STEPS, ablations.WITH),
        (ablations.AGENT, ablations.AGENT_STEPS, ablations.RARE),
    ],
)
def test_every_change_is_one_of_its_recipe(recipe, steps, table):
    assert len({str(load(recipe, {"recipe.steps": steps, **change}).to_dict()) for change in table.values()}) == len(
        table
    )


def test_prices_of_the_training_are_not_those_of_the_flights():
    told = Told({})
    ablations.changes(told)
    flown = [changes for what, changes in told.asked if what == "encounter-v0"]
    assert [changes for changes in flown if changes] == [{"decision_s": 1.0}]


def test_the_radios_are_flown_one_by_one_beside_the_cheapest_scripted_policy_of_each():
    told = Told({"pathwise-radios": 0.005, "mpc": 4.0})
    section = radios.section(told)
    assert [changes for _, changes in told.asked if changes and "channel" in changes] == [
        {"channel": radios.CHANNELS[radio]} for radio in radios.RADIOS
    ]
    assert all(criterion.met for criterion in section.criteria) and "mpc" in section.text
    worse = radios.section(Told({"pathwise-radios": 9.0})).criteria
    assert [criterion.text for criterion in worse if criterion.met] == [
        "paper: at most 1.2 times the cost of the agent trained on it alone"
    ]


def test_the_new_radios_are_none_of_those_trained_on():
    new, trained = radios.CHANNELS[radios.NEW], load("pathwise-radios", {}).params.channels
    assert len(new) == 20 and not set(new) & set(trained)


def test_the_chart_has_a_line_for_every_recipe_and_the_page_names_its_command():
    svg = curves.chart(Told({}))
    assert svg.startswith("<svg") and all(f">{name}</text>" in svg for name in curves.BARS)
    assert "`rss-gym study learning --sections ablations" in page({"ablations": ablations.ablations(Told({}))})


@pytest.mark.slow
def test_a_training_is_kept_and_its_cpu_time_counted(tmp_path):
    trainer = Trainer(tmp_path, 1, 1, 20, shrink=10)
    small = {"recipe.steps": 20_000, "vec.n_envs": 16, "imitation.episodes": 0}
    (first,) = trainer.train("pathwise", small)
    (folder,) = tmp_path.iterdir()
    before = (folder / "run.json").stat().st_mtime_ns
    assert trainer.train("pathwise", small) == [first]
    assert [*tmp_path.iterdir()] == [folder] and (folder / "run.json").stat().st_mtime_ns == before
    assert 0.0 < first.cpu_s < 600.0 and first.decisions >= 2000
    with open(first.folder.parent / "validation.csv", newline="") as file:
        spent = [float(row["cpu_s"]) for row in csv.DictReader(file)]
    assert spent == sorted(spent)
    assert trainer.score({"it": first.folder}, "encounter-v0")["it"]["cost_m"].n == 20
