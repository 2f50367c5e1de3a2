"""What is not finite is never a score: actions are faults shown in red, a state ends the run with a sentence."""

import importlib
import io
import pickle
import sys
from pathlib import Path

import numpy as np
import pytest

from rss_gym import core
from rss_gym.cli import main
from rss_gym.core import NotFiniteError
from rss_gym.eval import evaluate, ranking, report, text
from rss_gym.eval.records import save
from rss_gym.eval.verify import verify

sys.path.append(str(Path(__file__).parent))
flyers = importlib.import_module("flyers")

SENTENCE = r"episode 7 of seed 0, split 'suite', is not finite"


class Nans:
    """Never a number."""

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.full((len(observation), 2), np.nan), state


@pytest.fixture(scope="module")
def result():
    policies = {"none": "none", "orca": "orca", "nan": Nans(), "now and then": flyers.NanOnce()}
    return evaluate(policies, episodes=60, progress=False)


def test_a_policy_that_returns_nan_is_not_ranked_though_it_flies_as_none(result):
    assert result["nan"]["faults"].value == 60 and 0 < result["now and then"]["faults"].value < 30
    assert np.array_equal(result.policies[2].table["cost_m"], result.policies[0].table["cost_m"])
    places = ranking.of(result)["positions"]
    assert [place.name for place in places] == ["orca", "none", "nan", "now and then"]
    assert [place.place for place in places] == [1, 2, None, None]


def test_the_terminal_shows_it_in_red(result):
    lines = text.table(result, colour=True).splitlines()
    red = [line for line in lines if line.startswith(text.RED) and line.endswith(text.PLAIN)]
    assert len(red) == 4 and sum(text.RED in line for line in lines) == 4
    assert "NOT RANKED: nan: in 60 encounters it gave an action that is not finite" in red[2]
    assert "NOT RANKED: now and then" in red[3] and "faults" in lines[0]
    assert red[0].removesuffix(text.PLAIN).split()[-1] == "60"
    assert "\x1b" not in text.table(result)


def test_colours_are_for_terminals_that_want_them(monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    monkeypatch.delenv("NO_COLOR", raising=False)
    assert text.coloured(Terminal()) and not text.coloured(io.StringIO())
    monkeypatch.setenv("NO_COLOR", "1")
    assert not text.coloured(Terminal())


def test_the_page_shows_it_in_red(result):
    page = report.markup(result, None)
    assert '<p class="fault">nan is not ranked: 60 faults' in page
    assert page.count('<tr class="fault"><th scope="row"><span class="who"><span class="dot fault">') >= 4
    charts = page[page.index("<svg") : page.rindex("</svg>")]
    assert "var(--red)" in charts
    assert ".fault { --colour: var(--red); }" in page


def test_the_table_has_places_costs_and_differences(result):
    head, _, first, second, *_ = text.table(result).splitlines()
    assert head.split()[:4] == ["policy", "information", "cost,", "m"] and "more than the first, m" in head
    assert first.startswith("1*") and " orca " in first and second.startswith("2") and " none " in second
    difference = next(place.difference for place in ranking.of(result, differences=True)["positions"][1:])
    assert f"{difference.value:+.2f} [{difference.low:+.2f}, {difference.high:+.2f}]" in second


# A state that is not finite


@pytest.fixture
def broken(monkeypatch):
    """A world that breaks in episode 7 of seed 0."""
    step = core.Batch.step

    def breaks(self, actions, mask):
        step(self, actions, mask)
        if 7 in self.episode["number"].tolist():
            raise NotFiniteError("suite", 0, 7)

    monkeypatch.setattr(core.Batch, "step", breaks)


def test_the_error_travels_between_processes():
    error = pickle.loads(pickle.dumps(NotFiniteError("suite", 3, 7)))
    assert isinstance(error, NotFiniteError) and str(error) == str(NotFiniteError("suite", 3, 7))


def test_it_ends_an_evaluation(broken):
    evaluate("none", episodes=7, progress=False)
    with pytest.raises(NotFiniteError, match=SENTENCE):
        evaluate("none", episodes=8, progress=False)


@pytest.mark.slow
def test_a_worker_passes_it_on(monkeypatch):
    """The policy raises it, as the world of a worker would: it is no fault of the policy's."""
    with pytest.raises(NotFiniteError, match=SENTENCE):
        evaluate("flyers:Breaker", episodes=20, workers=2, progress=False)


def test_the_command_says_it_in_one_sentence(broken, tmp_path, capsys):
    status = main(["eval", "--policy", "none", "--episodes", "8", "--out", str(tmp_path / "run")])
    captured = capsys.readouterr()
    assert status == 1 and not captured.out and len(captured.err.strip().splitlines()) == 1
    assert "episode 7 of seed 0" in captured.err and not list(tmp_path.iterdir())


def test_it_is_no_verdict_on_a_record(tmp_path, monkeypatch):
    folder = save(evaluate("orca", episodes=10, progress=False), tmp_path / "run")
    monkeypatch.setattr(core.Batch, "step", lambda *_: (_ for _ in ()).throw(NotFiniteError("suite", 0, 7)))
    with pytest.raises(NotFiniteError, match=SENTENCE):
        verify(folder)
