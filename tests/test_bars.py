"""The script of `make bars`: a plan that cannot be misread, verdicts worked out by hand, and a flight that goes on."""

import json
import sys
from dataclasses import asdict, replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from safetensors.numpy import save_file
from scipy import stats

from rss_gym import baselines
from rss_gym.baselines.policy_files import Network
from rss_gym.eval.curve import Points
from rss_gym.eval.metrics import Estimate
from rss_gym.eval.suites import find
from rss_gym.params import ParamsError

sys.path.append(str(Path(__file__).resolve().parent.parent / "docs"))

import bars
import bars_asked
import bars_page
import bars_plan
import opponents

N = 2000
SMALL = """
sealed = ""
alpha = 0.05

[agents.one]
suite = "encounter-v0"
policy = "brake"
seeds = ["right-turn", "brake"]
encounters = 16
seed_encounters = 8
opponents = [
  { group = "rule", policy = "orthogonal", encounters = 8, radius_m = [40, 60], lookahead_s = [0.5] },
  { group = "others", policy = "mvp", encounters = 12, radius_m = [25] },
  { group = "constant", policy = "constant", encounters = 8 },
]
worlds = [{ name = "late", encounters = 8, changes = { families = "late-turn" } }]
bars = [
  { kind = "fewer-events", asked = "fewer", against = ["rule", "others"], events = ["collision", "snmac"] },
  { kind = "fewer-events", asked = "fewer at equal deviation", against = ["rule"], equal_deviation = true },
  { kind = "deviation-of-best", asked = "a third", against = ["rule"], share = 0.3333 },
  { kind = "collisions-at-deviation", asked = "every seed", against = ["rule"], every_seed = true },
  { kind = "deviation-at-collisions", asked = "a fifth", aim = true, against = ["rule"], share = 0.2 },
  { kind = "conflicts-left", asked = "few left", most = 1e-4 },
  { kind = "at-most", asked = "risk", world = "late", metric = "risk_ratio", most = 0.05 },
]

[[ablations]]
what = "least squares"
policy = "orthogonal"
suite = "encounter-v0"
encounters = 8
changes = { estimator = "ls" }
"""


@pytest.fixture
def plan_file(tmp_path):
    """The small plan in a file."""
    path = tmp_path / "plan.toml"
    path.write_text(SMALL)
    return path


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Records go to a folder of the test, flights are made in this process."""
    monkeypatch.setattr(bars, "RUNS", tmp_path / "runs")
    monkeypatch.setattr(bars, "WORKERS", 1)
    return tmp_path / "runs"


def flight(name, collided, deviation_m=10.0, snmac=(), n=N, metrics=None):
    """Flights that collide in the encounters given; `none` collides in the first 800."""

    def events(numbers):
        out = np.zeros(n, bool)
        out[[number for number in numbers if number < n]] = True
        return out

    rate = len(list(collided)) / n
    estimates = {
        "collision_rate": Estimate(rate, 0.5 * rate, max(2.0 * rate, 1e-3), n, "1"),
        "path_deviation_mean_m": Estimate(deviation_m, deviation_m, deviation_m, n, "m"),
    }
    deviations_m = deviation_m + np.random.default_rng(sum(map(ord, name))).normal(size=n)
    points = Points(events(collided), deviations_m - np.mean(deviations_m) + deviation_m)
    row = opponents.Row(name, n, estimates | (metrics or {}))
    return bars_asked.Flight(row, points, events(snmac), events(range(800)))


def flown(agent, *others, seeds=(), worlds=None):
    return bars_asked.Flown(flight("none", range(800)), agent, tuple(seeds), {"rule": list(others)}, worlds or {})


# The plan


def test_the_plan_of_the_repository_can_be_flown_once_its_agents_are_there():
    plan = bars_plan.load(bars.PLAN)
    assert {agent.suite for agent in plan.agents} == {"encounter-v0", "encounter3d-v0", "range-only-v0"}
    for agent in plan.agents:
        assert agent.seeds and agent.bars
        world = find(agent.suite).params
        for grid in agent.opponents:
            for spec in grid.specs:
                baselines.make(spec, world)
    assert all(agent.split == "suite" for agent in plan.agents if agent.policy)


def test_the_pages_have_the_places_that_are_written():
    for file, name in ((bars.DOCS / "agents.md", "tables"), (bars.ROOT / "README.md", "agents")):
        text = file.read_text(encoding="utf-8")
        assert text.count(f"<!-- {name} -->\n") == text.count(f"\n<!-- /{name} -->") == 1


def test_a_grid_is_every_combination():
    grid = bars_plan.Grid(group="g", policy="orca", encounters=1, options={"radius_m": [20, 2.5], "sigmas": [1]})
    assert grid.specs == ["orca:radius_m=20,sigmas=1", "orca:radius_m=2.5,sigmas=1"]
    assert bars_plan.Grid(group="g", policy="orca", encounters=1).specs == ["orca"]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('sealed = ""', "", "the head lacks the field 'sealed'"),
        ("alpha = 0.05", "alpha = 5", "alpha must lie between 0 and 1, got 5.0"),
        ("alpha = 0.05", "alpha = true", "alpha must be a number, got True"),
        ("seed_encounters", "seed_encounter", "[agents.one] has no field 'seed_encounter'; did you mean 'seed_enc"),
        ("encounters = 16", 'encounters = "16"', "encounters must be a whole number >= 0, got '16'"),
        ("encounters = 16", "encounters = -1", "encounters must be a whole number >= 0, got -1"),
        ("encounters = 16", "encounters = 0", "[agents.one]: encounters must be at least 1, got 0"),
        ("encounters = 16\n", "", "lacks the field 'encounters', those of policy 'brake'"),
        ('["right-turn", "brake"]', "[]", "seeds must name at least one policy folder"),
        ('policy = "brake"', "", "worlds need policy"),
        ('"encounter-v0"\npolicy', '"encounter"\npolicy', "suite 'encounter' is unknown"),
        ("encounters = 16", 'encounters = 16\nsplit = "test"', "split 'test' is unknown"),
        ("radius_m = [25]", 'radius_m = ["a"]', "radius_m must be a list of numbers"),
        ('"mvp", encounters = 12, radius_m = [25]', '"orthogonal", encounters = 1, radius_m=[60], lookahead_s=[0.5]',
         "'orthogonal:radius_m=60,lookahead_s=0.5' is given twice"),
        ('"deviation-of-best"', '"deviation-best"', "kind 'deviation-best' is unknown; did you mean 'deviation-of-b"),
        ('against = ["rule"], share = 0.3333', 'against = ["rules"], share = 1', "group 'rules' is unknown; did you"),
        (', against = ["rule"], share = 0.3333', ", share = 1", "against must name groups"),
        ('world = "late"', 'world = "later"', "world 'later' is unknown; did you mean 'late'"),
        ('"risk_ratio"', '"risk"', "metric 'risk' is unknown"),
        ('"snmac"]', '"nmac"]', "event 'nmac' is unknown; did you mean 'snmac'"),
        (', most = 1e-4', "", "lacks the field 'most'"),
        ('families = "late-turn"', 'family = "late-turn"', "no parameter 'family'; did you mean 'families'"),
        ('estimator = "ls"', 'estimator = "lsq"', "estimator = 'lsq' is unknown"),
        ("worlds = [{", "worlds = [5, {", "[agents.one]: worlds must be a list of tables, got [5, "),
        ("alpha = 0.05", "alpha = ", "cannot be read"),
    ],
)  # fmt: skip
def test_a_plan_that_is_wrong_is_refused_in_a_sentence(old, new, words, plan_file):
    assert SMALL.count(old) >= 1
    plan_file.write_text(SMALL.replace(old, new, 1))
    with pytest.raises(ParamsError) as error:
        bars_plan.load(plan_file)
    assert words in str(error.value) and str(error.value).startswith("plan plan.toml")


# What is asked


def test_events_are_compared_by_mcnemar_on_the_encounters_that_both_flew():
    bar = bars_asked.FewerEvents(asked="", against=("rule",), events=("collision", "snmac"))
    agent, rule = flight("a", range(0, 10), snmac=range(0, 30)), flight("r", range(5, 40), snmac=range(0, 90), n=1000)
    collisions, snmacs = bar.findings(flown(agent, rule)).found
    assert collisions.p == pytest.approx(stats.binomtest(5, 35, 0.5).pvalue)
    assert collisions.value.value == pytest.approx((5 - 30) / 1000) and collisions.value.n == 1000
    assert snmacs.p == pytest.approx(stats.binomtest(0, 60, 0.5).pvalue)


def test_settings_that_deviate_less_are_named_and_not_compared():
    bar = bars_asked.FewerEvents(asked="", against=("rule",), equal_deviation=True)
    agent = flight("a", range(3), 10.0)
    settings = [flight("less", range(1), 9.0), flight("equal", range(60), 10.01), flight("more", range(70), 12.0)]
    findings = bar.findings(flown(agent, *settings))
    assert [item.what.split("`")[1] for item in findings.found] == ["equal", "more"]
    assert findings.remarks == ["not compared, as they deviate less: `less`"]
    alone = bar.findings(flown(agent, settings[0]))
    assert alone.found == []
    judged = bars_page.Judged("a", bar, alone, (), ())
    assert judged.verdict == "missed" and "nothing to compare" in judged.outcome


def test_with_best_only_the_best_setting_counts():
    bar = bars_asked.FewerEvents(
        asked="", against=("rule",), events=("collision", "snmac"), equal_deviation=True, best=True
    )
    settings = [flight("safe", range(10), 12.0), flight("risky", range(100), 12.0)]
    findings = bar.findings(flown(flight("a", [], 4.0), *settings))
    assert [item.what.split("`")[1] for item in findings.found] == ["safe", "safe"]
    assert bar.findings(flown(flight("a", [], 20.0), *settings)).found == []


def test_the_deviation_is_compared_with_that_of_the_rule_at_its_best():
    bar = bars_asked.DeviationOfBest(asked="", against=("rule",), share=0.5)
    settings = [flight("safe", range(10), 10.0), flight("risky", range(100), 2.0)]
    (finding,) = bar.findings(flown(flight("a", [], 4.0), *settings)).found
    assert "`safe`, its best" in finding.what
    assert finding.value.value == pytest.approx(4.0 - 0.5 * 10.0)
    assert finding.holds(0.01, 0.05) and not finding.holds(0.06, 0.05)


def test_the_best_deviates_least_of_those_not_told_from_the_safest():
    """Against 10 collisions, 14 others have p = 2 / 2^4 at least; 60 are told apart."""
    safest, tied, apart = flight("safest", range(10), 9.0), flight("tied", range(14), 6.0), flight("b", range(70), 3.0)
    assert bars_asked.best_of([apart, safest, tied]) is tied
    assert bars_asked.best_of([apart, safest]) is safest


def test_the_safest_setting_is_not_one_that_was_flown_seldom():
    """0 of 20 bounds the rate by 0.14, 10 of 2000 by 0.009; from 0 of 20 not even 60 of 2000 would be told."""
    seldom, often = flight("seldom", [], 30.0, n=20), flight("often", range(10), 10.0)
    assert bars_asked.best_of([seldom, often, flight("risky", range(40, 100), 5.0)]) is often


def test_every_seed_stands_beside_the_curve():
    bar = bars_asked.CollisionsAtDeviation(asked="", against=("rule",), every_seed=True)
    seeds = [flight("s0", range(4), 12.0), flight("s1", range(100), 8.0)]
    settings = [flight("r1", range(100), 8.0), flight("r2", range(25), 16.0)]
    better, equal = bar.findings(flown(seeds[0], *settings, seeds=seeds)).found
    assert better.value.value == pytest.approx(0.002 - 0.025, rel=1e-6)
    assert better.holds(better.p, 0.05)
    assert equal.value.value == pytest.approx(0.0, abs=1e-12)
    assert not equal.holds(equal.p, 0.05)


def test_deviation_at_the_same_safety():
    bar = bars_asked.DeviationAtCollisions(asked="", against=("rule",), share=0.5)
    settings = [flight("r1", range(100), 8.0), flight("r2", range(25), 16.0)]
    (finding,) = bar.findings(flown(flight("a", range(50), 3.0), *settings)).found
    assert finding.value.value == pytest.approx(3.0 - 0.5 * 12.0, rel=1e-6)


def test_conflicts_left_are_bounded_on_one_side():
    bar = bars_asked.ConflictsLeft(asked="", most=0.004)
    (none_left,) = bar.findings(flown(flight("a", range(1500, 1600)))).found
    assert none_left.value.high == pytest.approx(1.0 - 0.05 ** (1 / 800))
    assert none_left.value.n == 800 and none_left.holds(None, 0.05)
    (one_left,) = bar.findings(flown(flight("a", [799]))).found
    assert one_left.value.high > 0.004 and not one_left.holds(None, 0.05)


def test_a_metric_holds_if_its_whole_interval_does():
    bar = bars_asked.AtMost(asked="", metric="risk_ratio", most=0.05, world="w")

    def holds(value, high):
        metrics = {"risk_ratio": Estimate(value, 0.0, high, N, "1")}
        worlds = {"w": flight("a", [], metrics=metrics)}
        (finding,) = bar.findings(flown(None, worlds=worlds)).found
        return finding.holds(None, 0.05)

    assert holds(0.04, 0.05)
    assert not holds(0.04, 0.051) and not holds(None, None) and not holds(0.04, None)


def test_one_comparison_of_two_bars_counts_once_in_holms_family(plan_file):
    every = bars_asked.FewerEvents(asked="every", against=("rule",))
    equal = bars_asked.FewerEvents(asked="equal", against=("rule",), equal_deviation=True)
    plan = bars_plan.load(plan_file)
    plan = replace(plan, agents=(replace(plan.agents[0], bars=(every, equal)),))
    agent = flight("a", [], 10.0)
    settings = [flight("near", range(6), 11.0), flight("far", range(60), 12.0)]  # p = 2 / 2^6 alone
    first, second = bars_page.judge(plan, {"one": flown(agent, *settings)})
    assert first.adjusted == second.adjusted == pytest.approx((2 / 2**6, 4 / 2**60))
    assert (first.verdict, first.holds) == ("met", (True, True))
    worse = bars_page.judge(plan, {"one": flown(agent, flight("near", range(5), 11.0), settings[1])})
    assert [item.verdict for item in worse] == ["missed", "missed"]
    assert worse[0].outcome.startswith("1 of 2 comparisons hold; not: collisions against `near`: 0 alone against 5")


def test_an_aim_is_reached_or_not_and_no_bar():
    bar = bars_asked.ConflictsLeft(asked="", most=0.5, aim=True)
    findings = bar.findings(flown(flight("a", [])))
    assert bars_page.Judged("a", bar, findings, (None,), (True,)).verdict == "reached"
    assert bars_page.Judged("a", bar, findings, (None,), (False,)).verdict == "not reached"


def test_a_curve_is_drawn_through_settings_that_are_not_beaten():
    flights = [flight("r1", range(9), 9.0), flight("r2", range(80), 4.0), flight("r3", range(90), 5.0)]
    assert [row.spec for row in bars_page.best_curve(flights)] == ["r2", "r1"]


# The flight


def test_a_draft_flies_judges_and_goes_on(plan_file, here, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    bars.run(plan_file, draft=12)
    page = (here / "draft" / "agents.md").read_text()
    assert "A draft" in page and "| `one` | fewer | " in page and "## Ablations" in page and "least squares" in page
    ablations = page.partition("## Ablations")[2].partition("## ")[0]
    assert ablations.count("\n| `") == 1 and "one, seed" not in ablations
    assert page.count("**met**") + page.count("**missed**") == 6
    assert page.count("reached**") == 1
    svg = (here / "draft" / "agents.svg").read_text()
    assert ElementTree.fromstring(svg).tag == "{http://www.w3.org/2000/svg}svg" and "agents, each seed" in svg
    # The policy handed on and the rule `mvp` share a record of 12, the rest one of 8.
    records = {path.name.rpartition("-")[0]: path for path in here.iterdir() if path.name != "draft"}
    assert sorted(records) == ["ablation-0", "one-12", "one-8", "one-late"]
    scores = json.loads((records["one-12"] / "scores.json").read_text())
    assert [item["name"] for item in scores["policies"]] == ["none", "one, seed 1", "mvp:radius_m=25"]
    assert (records["one-12"] / bars.FLOWN_FOR).read_text() == "draft"
    # Again: from the records alone.
    monkeypatch.setattr(bars.Job, "evaluate", lambda job: pytest.fail(f"{job.name} was flown again"))
    bars.run(plan_file, draft=12)
    assert (here / "draft" / "agents.md").read_text() == page
    assert "4 jobs, 4 of them flown before" in capsys.readouterr().out


def test_a_flight_writes_the_pages_and_tells_for_which_plan(plan_file, here, monkeypatch):
    pytest.importorskip("matplotlib")
    docs = here.parent / "docs"
    docs.mkdir()
    for file, name in ((docs / "agents.md", "tables"), (here.parent / "README.md", "agents")):
        file.write_text(f"above\n<!-- {name} -->\nto be replaced\n<!-- /{name} -->\nbelow\n")
    sealed = bars.seal([])  # of no learned policy
    plan_file.write_text(SMALL.replace('sealed = ""', f'sealed = "{sealed}"'))
    for name, value in (("PLAN", plan_file), ("DOCS", docs), ("ROOT", here.parent)):
        monkeypatch.setattr(bars, name, value)
    for commit in ("first", "second"):
        monkeypatch.setattr(bars, "committed", lambda git, commit=commit: commit)
        bars.run(plan_file, draft=0)
        page, readme = (docs / "agents.md").read_text(), (here.parent / "README.md").read_text()
        assert f"of commit `{commit}`" in page and "to be replaced" not in page + readme and "above" in page
        assert ("other plans: first" in page) == (commit == "second")
    assert "| `one` | 16 |" in readme and "of 6 bars met" in readme
    assert (docs / "agents.svg").exists()


def test_the_policy_handed_on_is_one_of_the_seeds(plan_file):
    (agent,) = bars_plan.load(plan_file).agents
    assert bars.part(agent, 100).shipped == "one, seed 1"
    with pytest.raises(ParamsError, match="'none' is none of the seeds"):
        bars.part(replace(agent, policy="none"), 100)


def test_a_record_is_named_by_what_defines_it(plan_file):
    (agent,) = bars_plan.load(plan_file).agents
    job = bars.part(agent, 100).own[0]
    others = [
        replace(job, seed=1),
        replace(job, episodes=15),
        replace(job, changes={"estimator": "ls"}),
        replace(job, suite=replace(job.suite, split="validation")),
        replace(job, policies={"one, seed 1": "right-turn"}),
    ]
    assert len({item.folder for item in (job, *others)}) == 6
    assert replace(job).folder == job.folder


def test_the_seal_is_that_of_the_numbers_wherever_they_lie(tmp_path):
    world = find("encounter-v0").params
    network = Network((2,))

    def learned(name, weight):
        folder = tmp_path / name
        folder.mkdir()
        tensors = {key: np.full(shape, weight, np.float32) for key, shape in network.shapes(world).items()}
        save_file(tensors, folder / "policy.safetensors")
        content = {"format": 1, "network": asdict(network), "interface": world.interface.to_dict(), "training": {}}
        (folder / "policy.json").write_text(json.dumps(content | {"observation": network.inputs(world)}))
        return bars.Job(name, find("encounter-v0"), 0, 4, {"learned": str(folder)})

    first, same, other = learned("first", 0.1), learned("same", 0.1), learned("other", 0.2)
    assert bars.seal([first]) == bars.seal([same]) == bars.seal([first, same]) != bars.seal([other])
    assert replace(first, name="x").folder == replace(same, name="x").folder != replace(other, name="x").folder
    assert first.cost == 4 * (1.0 + bars.LEARNED_COST)


def test_another_plan_or_other_agents_are_refused(plan_file, monkeypatch):
    pytest.importorskip("matplotlib")
    with pytest.raises(ParamsError, match="can only be flown as a --draft"):
        bars.run(plan_file, draft=0)
    monkeypatch.setattr(bars, "PLAN", plan_file)
    with pytest.raises(ParamsError, match=r"sealed = '' must be '[0-9a-f]{16}', the digest of the agents named"):
        bars.run(plan_file, draft=0)


def test_changes_that_are_not_committed_are_refused():
    def git(status):
        return lambda *arguments: status if arguments[0] == "status" else "abc\n"

    assert bars.committed(git("")) == "abc"
    with pytest.raises(ParamsError, match=r"docs/bars\.toml, eval/curve\.py: changes that are not committed"):
        bars.committed(git(" M docs/bars.toml\n?? eval/curve.py\n"))
