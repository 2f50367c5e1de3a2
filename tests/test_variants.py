"""The script of `make variants`: names it knows, and rows from the folders of runs."""

import csv

import pytest
import variants

from rss_gym.eval.intervals import clopper_pearson
from rss_gym.params import ParamsError
from rss_gym.train import recipe


@pytest.fixture
def runs(tmp_path, monkeypatch):
    """Runs and README of the test; nothing is trained."""
    monkeypatch.setattr(variants, "ROOT", tmp_path)
    monkeypatch.setattr(variants, "RUNS", tmp_path / "runs")
    monkeypatch.setattr(variants.run, "start", lambda *given, **options: pytest.fail("a training was started"))
    (tmp_path / "README.md").write_text("above\n<!-- variants -->\nto be replaced\n<!-- /variants -->\nbelow\n")
    return tmp_path / "runs"


def flown(folder, *seeds, finished=True):
    """A run whose seeds were validated so: lists of (collisions, episodes, deviation)."""
    for index, rows in enumerate(seeds):
        (folder / f"seed-{index}").mkdir(parents=True)
        with open(folder / f"seed-{index}" / "validation.csv", "w", newline="") as file:
            csv.writer(file).writerows([("collisions", "episodes", "path_deviation_mean_m"), *rows])
    if finished:
        (folder / "agent").mkdir()


def test_every_variant_is_a_recipe_of_its_own():
    made = [recipe.load(variants.RECIPE, changes).to_dict() for _, _, changes in variants.VARIANTS.values()]
    assert all(one not in made[:index] for index, one in enumerate(made))


def test_a_row_is_of_the_last_validation_of_each_seed(runs):
    flown(runs / "base", [(9, 1000, 3.0), (2, 1000, 7.04)], [(0, 500, 8.16)])
    name, rates, deviations = variants.row("base")
    high = clopper_pearson(0, 500).high
    assert name == "the recipe" and deviations == "7.0, 8.2"
    first, second = rates.split("; ")
    assert first.startswith("2.0e-03 [") and second == f"0.0e+00 [0.0e+00, {high:.1e}]"


def test_finished_runs_are_written_and_not_trained_again(runs):
    flown(runs / "base", [(2, 1000, 7.0)])
    flown(runs / "no-range", [(3, 1000, 7.0)], finished=False)
    assert variants.main(["base"]) == 0
    text = (runs.parent / "README.md").read_text()
    assert "| the recipe | 2.0e-03 [" in text and "zeroed" not in text and "to be replaced" not in text
    assert text.startswith("above\n") and text.endswith("below\n")


def test_a_missing_run_is_started_with_its_change_and_seeds(runs, monkeypatch):
    started = []
    monkeypatch.setattr(variants.run, "start", lambda *given, **options: started.append(given))
    variants.train("no-imitation")
    ((made, folder, seeds, workers),) = started
    assert made.imitation.episodes == 0 and folder == runs / "no-imitation"
    assert (seeds, workers) == (3, variants.WORKERS)


def test_an_interrupted_run_goes_on(runs, monkeypatch):
    flown(runs / "ls", [(3, 1000, 7.0)], finished=False)
    resumed = []
    monkeypatch.setattr(variants.run, "resume", lambda folder, *given, **options: resumed.append(folder))
    assert variants.train("ls") == runs / "ls" and resumed == [runs / "ls"]


def test_an_unknown_name_is_refused_before_anything_is_trained(runs, capsys):
    flown(runs / "base", [(2, 1000, 7.0)])
    assert variants.main(["base", "no-radios"]) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("error: variant 'no-radios' is unknown; did you mean 'no-radio'?")
    assert captured.err.count("\n") == 1 and captured.out == ""
    assert "to be replaced" in (runs.parent / "README.md").read_text()
    with pytest.raises(ParamsError, match="variant '--help-me' is unknown"):
        variants.chosen(["--help-me"])
    assert variants.chosen([]) == list(variants.VARIANTS) and variants.chosen(["ls", "base"]) == ["ls", "base"]
