"""Contracts over the shipped agents, and over one made for the test, so that they are tried before any is shipped."""

import csv
import json
import re

import pytest

from rss_gym import baselines
from rss_gym.baselines import AGENTS, shipped
from rss_gym.baselines.agent import Agent
from rss_gym.cli import main
from rss_gym.domain import AIR, domain_of, domain_of_id
from rss_gym.eval import evaluate, records, verify
from rss_gym.eval.policies import entry
from rss_gym.ids import IDS
from rss_gym.listing import listing
from rss_gym.params import Params, ParamsError
from rss_gym.testing import check_policy

SIZE_MAX = 1 << 20  # bytes of a folder
MADE = "made-for-the-test"


@pytest.fixture(params=[*AGENTS, MADE])
def name(request, monkeypatch):
    """Of each shipped agent, and of the one made here."""
    if request.param == MADE:
        monkeypatch.setitem(AGENTS, MADE, request.getfixturevalue("tiny_agent"))
    return request.param


@pytest.fixture
def made(monkeypatch, tiny_agent):
    """The name of the one made here."""
    monkeypatch.setitem(AGENTS, MADE, tiny_agent)
    return MADE


def home(name):
    """The world of the id that the agent was trained in."""
    domain = domain_of_id(shipped.home(name))
    return domain.params(domain.ids[shipped.home(name)])


@pytest.mark.slow
def test_it_loads_in_its_own_world_and_is_small(name):
    agent = baselines.make(name, home(name))
    assert isinstance(agent, Agent) and agent.params == home(name)
    assert sum(file.stat().st_size for file in AGENTS[name].iterdir()) < SIZE_MAX
    assert {file.name for file in AGENTS[name].iterdir()} == {
        "policy.json", "policy.safetensors", "card.md", "curves.csv", "curves.svg"
    }  # fmt: skip
    assert re.fullmatch("[a-z][a-z0-9-]+", name) and name not in baselines.POLICIES


def test_its_card_names_recipe_seeds_and_limits(name):
    text, training = (AGENTS[name] / "card.md").read_text(), baselines.make(name, home(name)).document["training"]
    assert f"`{training['name']}`" in text and f"`{shipped.home(name)}`" in text
    assert f"shipped: {training['seed']} |" in text
    with open(AGENTS[name] / "curves.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    for seed in {row["seed"] for row in rows}:
        assert re.search(rf"^\| {seed} \| [\d,]+ \|", text, re.MULTILINE)
    kept = [row for row in rows if row["seed"] == str(training["seed"]) and row["best"] == "1"][-1]
    assert int(kept["steps"]) == training["validation"]["steps"]
    assert len(text.partition("## Limits")[2].strip().splitlines()) >= 3
    assert baselines.make(name, home(name)).digest in text  # the card of these files


def test_where_it_cannot_fly_is_one_sentence(name):
    for keywords in IDS.values():
        params = Params.of(**keywords)
        if name in baselines.able(params):
            assert entry(name, params).params == params
            continue
        with pytest.raises(ParamsError, match=name) as caught:
            entry(name, params)
        assert "\n" not in str(caught.value)
    assert name in baselines.able(home(name))


def test_its_own_information_alone_may_be_named(name):
    own = home(name).interface.information
    assert baselines.make(f"{name}@{own}", home(name)).params == home(name)
    for level in {"oracle", "positions", "ranges"} - {own}:
        with pytest.raises(ParamsError, match=f"{name}.*cannot fly on information '{level}'.*'{own}'"):
            baselines.make(f"{name}@{level}", home(name))
    with pytest.raises(ParamsError, match="it has none"):
        baselines.make(f"{name}:radius_m=3", home(name))
    with pytest.raises(ParamsError, match="unknown"):
        baselines.make(f"{name}@nowhere", home(name))


def test_it_keeps_the_contract_of_a_policy(name):
    check_policy(baselines.make(name, home(name)), home(name))


def test_name_and_folder_are_one_policy_for_the_records(name):
    params, folder = home(name), str(AGENTS[name])
    assert (
        entry(name, params).hash
        == entry(folder, params).hash
        == entry(f"{name}@{params.interface.information}", params).hash
    )
    assert entry(name, params).name == name and entry(name, params).hash != entry("none", params).hash
    if domain_of(params) is AIR:
        assert entry(f"cbf+{name}", params).hash == entry(f"cbf+{folder}", params).hash != entry(name, params).hash


def test_it_is_listed(name, capsys):
    assert shipped.home(name) in listing()["policies"][name] and baselines.describe()[name]["summary"].endswith(".")
    assert main(["list", "--json"]) == 0 and name in json.loads(capsys.readouterr().out)["policies"]


def test_records_of_it_are_flown_again_and_another_policy_is_noticed(made, tmp_path, monkeypatch, capsys):
    out = tmp_path / "record"
    assert main(["eval", "--policy", made, f"cbf+{made}", "--episodes", "20", "--out", str(out)]) == 0
    assert made in capsys.readouterr().out
    verdict = verify.verify(out, every=True)
    assert verdict.verified and verdict.flown == {"none": 20, made: 20, f"cbf+{made}": 20}
    other = tmp_path / "other"
    other.mkdir()
    for file in ("policy.json", "policy.safetensors"):
        (other / file).write_bytes((AGENTS[made] / file).read_bytes())
    (other / "policy.json").write_text((other / "policy.json").read_text() + "\n")
    monkeypatch.setitem(AGENTS, made, other)
    verdict = verify.verify(out)
    assert not verdict.verified and "not the policy that was recorded" in verdict.not_flown[made]


def test_a_folder_of_that_name_is_not_taken_for_it(made, tmp_path, monkeypatch):
    (tmp_path / made).mkdir()
    (tmp_path / made / "policy.json").write_text("{}")
    monkeypatch.chdir(tmp_path)
    assert not baselines.is_folder(made) and baselines.is_known(made) and not baselines.is_code(f"{made}:x")
    assert baselines.is_folder(f"./{made}") and baselines.make(made).digest


@pytest.mark.slow
def test_all_flies_it(made, tmp_path):
    result = evaluate("all", episodes=4)
    assert made in [scored.entry.name for scored in result.policies]
    assert records.save(result, tmp_path / "all").is_dir()
    with pytest.raises(ParamsError, match=f"did you mean '{made}'"):
        baselines.make(made[:-1])
