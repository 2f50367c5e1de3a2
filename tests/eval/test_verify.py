"""`rss-gym verify`: what is true passes, and whatever was changed is named."""

import dataclasses
import importlib
import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from rss_gym import baselines, domain
from rss_gym.cli import main
from rss_gym.eval import evaluate, records
from rss_gym.eval.evaluate import score
from rss_gym.eval.metrics import defined_in
from rss_gym.eval.policies import Entry
from rss_gym.eval.reading import RecordError, definition, load
from rss_gym.eval.records import save, table_digest, write_table
from rss_gym.eval.suites import Suite
from rss_gym.eval.verify import report, sample, verify
from rss_gym.params import Params

METRICS = defined_in("air")

HERE = Path(__file__).parent
sys.path.append(str(HERE))
flyers = importlib.import_module("flyers")

N = 60


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    policies = {"none": "none", "orthogonal": "orthogonal", "mine": "flyers:Flyer", "object": flyers.Flyer()}
    return save(evaluate(policies, episodes=N, progress=False), tmp_path_factory.mktemp("sound") / "run")


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """Policies of the package, and a learned one by its folder, alone and inside a filter."""
    folder = shutil.copytree(baselines.AGENTS["ppo-plane"], tmp_path_factory.mktemp("plain") / "mine")
    policies = ["orthogonal", str(folder), f"cbf+{folder}"]
    run = save(evaluate(policies, episodes=10, progress=False), folder.parent / "run")
    shutil.rmtree(folder)
    return run


@pytest.fixture
def folder(sound, tmp_path):
    """A copy to spoil."""
    return shutil.copytree(sound, tmp_path / "run")


def change(folder, edit):
    file = folder / "scores.json"
    content = json.loads(file.read_text())
    edit(content)
    file.write_text(json.dumps(content))


def forge(folder, policy, column, episode, value, scored=True):
    """Change a value of a table and everything in the record that follows from it."""
    record = load(folder)
    index = [one.name for one in record.policies].index(policy)
    table = record.policies[index].table
    table[column][episode] = value
    stem = Path(record.policies[index].file).stem
    write_table(folder / "tables", stem, table, with_csv=False)
    change(folder, lambda content: content["policies"][index].update(table_sha256=table_digest(table)))
    if scored:
        record = load(folder)
        suite = definition(record)
        entries = [Entry(one.name, one.spec, None, suite.params) for one in record.policies]
        result = score(suite, record.seed, entries, [one.table for one in record.policies], record.reference, False)
        for number, one in enumerate(result.policies):
            metrics = {name: dataclasses.asdict(estimate) for name, estimate in one.metrics.items()}
            change(folder, lambda content, i=number, m=metrics: content["policies"][i].update(metrics=m))


def found(verdict):
    return [(one.policy, one.what, one.episode) for one in verdict.differences]


def test_a_true_record_is_verified(sound):
    verdict = verify(sound)
    assert verdict.outcome == "incomplete" and not verdict.differences and verdict.metrics == 4 * len(METRICS)
    assert not verdict.verified and set(verdict.status.values()) == {"sample", "not flown"}
    assert verdict.flown == {"none": 10, "orthogonal": 10}
    assert set(verdict.not_flown) == {"mine", "object"}
    assert "--trust" in verdict.not_flown["mine"] and "Flyer" in verdict.not_flown["object"]
    text = report(verdict)
    assert "NOT flown again: mine" in text and "INCOMPLETE: nothing differs" in text


def test_a_policy_of_the_package_needs_no_trust_however_it_is_named(tmp_path):
    """Level of information, options and another policy may stand behind its name."""
    names = ["none", "orca@oracle:radius_m=12", "cbf:radius_m=9+orthogonal:radius_m=60"]
    folder = save(evaluate(names, episodes=10, progress=False), tmp_path / "run")
    verdict = verify(folder)
    assert verdict.verified and verdict.flown == dict.fromkeys(names, 10) and not verdict.not_flown


def test_all_of_it_by_workers(sound):
    verdict = verify(sound, every=True, trust=True, workers=2)
    assert not verdict.differences and verdict.flown == {"none": N, "orthogonal": N, "mine": N}
    assert verdict.status == {"none": "all", "orthogonal": "all", "mine": "all", "object": "not flown"}
    assert set(verdict.not_flown) == {"object"}


def test_a_changed_metric_is_named_with_both_values(folder):
    change(folder, lambda content: content["policies"][1]["metrics"]["path_deviation_mean_m"].update(value=0.125))
    verdict = verify(folder)
    assert found(verdict) == [("orthogonal", "path_deviation_mean_m.value", None)]
    assert verdict.differences[0].recorded == 0.125
    assert "policy 'orthogonal', path_deviation_mean_m.value: recorded 0.125, found " in report(verdict)


def test_one_bit_of_a_metric_is_seen(folder):
    def edit(content):
        cost = content["policies"][0]["metrics"]["cost_m"]
        cost["high"] = float(np.nextafter(cost["high"], np.inf))

    change(folder, edit)
    assert found(verify(folder)) == [("none", "cost_m.high", None)]


def test_a_metric_left_out_is_named(folder):
    change(folder, lambda content: content["policies"][1]["metrics"].pop("risk_ratio"))
    assert found(verify(folder)) == [("orthogonal", "risk_ratio", None)]


def test_a_table_without_its_metrics_is_seen(folder):
    forge(folder, "object", "zone_severity", 5, 0.9, scored=False)
    parts = {f"zone_severity.{part}" for part in ("value", "low", "high")}
    assert {what for _, what, _ in found(verify(folder))} == parts


def test_a_changed_row_is_found_by_flying_it_again(folder):
    forge(folder, "orthogonal", "manoeuvre_m", 17, 0.0)
    assert verify(folder, every=True).differences[0].found > 0.0
    assert found(verify(folder, every=True)) == [("orthogonal", "manoeuvre_m", 17)]
    # A sample finds it if it holds it, and another seed draws another.
    seeds = [seed for seed in range(20) if 17 in sample(load(folder), seed=seed)]
    assert 0 < len(seeds) < 20
    for seed in (seeds[0], next(seed for seed in range(20) if seed not in seeds)):
        assert bool(verify(folder, seed=seed).differences) == (seed in seeds)
    assert "episode 17, manoeuvre_m: recorded 0.0, found " in report(verify(folder, seed=seeds[0]))


def test_the_sample_is_one_percent_and_at_least_ten(sound):
    record = load(sound)
    assert len(sample(record)) == 10 == len(set(sample(record))) and sample(record) == sample(record)
    assert sample(record, seed=1) != sample(record)
    assert len({verify(record.folder).seed for _ in range(3)}) == 3  # by chance, and told
    large = dataclasses.replace(record, episodes=100_000)
    assert len(set(sample(large))) == 1000 and max(sample(large)) > 90_000
    assert sample(dataclasses.replace(record, episodes=7)) == range(7)
    assert sample(record, every=True) == range(N)


def test_a_changed_world_is_said_and_nothing_is_flown(folder, monkeypatch):
    monkeypatch.setattr(domain, "WORLD_VERSION", domain.WORLD_VERSION + 1)
    verdict = verify(folder)
    assert [what.split()[0] for _, what, _ in found(verdict)] == ["suite_hash"]
    assert "definition has changed" in report(verdict) and not verdict.flown and len(verdict.not_flown) == 4


def test_parameters_that_were_not_flown_are_said(folder):
    change(folder, lambda content: content["params"]["reward"].update(comfort_m=30.0))
    assert [what.split()[0] for _, what, _ in found(verify(folder))] == ["suite_hash"]


@pytest.mark.parametrize(("field", "value"), [("hash", "0" * 64), ("information", "ranges")])
def test_claims_about_a_policy(folder, field, value):
    change(folder, lambda content: content["policies"][1].update({field: value}))
    assert found(verify(folder)) == [("orthogonal", field, None)]


def test_another_rule_than_the_one_named(folder):
    def edit(content):
        content["policies"][1]["spec"] = "orthogonal:radius_m=20"

    change(folder, edit)
    what = [what for _, what, _ in found(verify(folder))]
    assert "hash" in what and "deviation_mean_m" in what


def test_a_false_official_run(folder):
    change(folder, lambda content: content.update(official=True))
    assert found(verify(folder)) == [(None, "official", None)]


def test_an_official_run(tmp_path):
    folder = save(evaluate("none", suite="smoke-v0", progress=False), tmp_path / "run")
    assert load(folder).official and verify(folder).verified
    change(folder, lambda content: content.update(official=False))
    assert found(verify(folder)) == [(None, "official", None)]


def test_suites_of_ones_own_and_changed_ones(tmp_path):
    own = Suite("mine-v0", "", Params.of(planar=False, channel="quadcopter"), episodes=12, split="validation")
    assert verify(save(evaluate("none", suite=own, episodes=10, progress=False), tmp_path / "own")).verified
    changed = evaluate("orthogonal", episodes=10, progress=False, channel=["paper", "clean"], families="crossing")
    assert verify(save(changed, tmp_path / "changed"), every=True).verified


def test_a_stranger_runs_no_code(folder, tmp_path, monkeypatch):
    (tmp_path / "trap.py").write_text(f"import os\nos.mkdir({str(tmp_path / 'sprung')!r})\n")
    monkeypatch.syspath_prepend(tmp_path)
    change(folder, lambda content: content["policies"][2].update(spec="trap:policy"))
    assert "--trust" in verify(folder).not_flown["mine"] and not (tmp_path / "sprung").exists()
    assert "trap" in verify(folder, trust=True).not_flown["mine"] and (tmp_path / "sprung").exists()


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ("gone_module:policy", "gone_module"),
        ("flyers:missing", "missing"),
        ("flyers:unmade", "no weights"),
        ("nobody", "not in the record"),
        ("orthogonal:x=1", "no option 'x'"),
    ],
)
def test_policies_that_are_gone_are_named(folder, spec, words):
    change(folder, lambda content: content["policies"][2].update(spec=spec))
    verdict = verify(folder, trust=True)
    assert verdict.outcome == "incomplete" and words in verdict.not_flown["mine"]


def test_a_policy_that_depends_on_its_company_is_found(tmp_path):
    folder = save(evaluate("flyers:Crowd", episodes=40, progress=False), tmp_path / "run")
    assert not verify(folder, trust=True).verified
    assert verify(folder, trust=True, every=True).verified  # in the same company


def test_a_policy_that_fails_now_does_not_hide_the_others(folder):
    def edit(content):
        content["policies"][2].update(spec="flyers:Raiser")

    change(folder, edit)
    verdict = verify(folder, trust=True)
    assert set(verdict.flown) == {"none", "orthogonal"}
    assert {(policy, what) for policy, what, _ in found(verdict)} == {("mine", "hash"), ("mine", "flights")}
    assert "lost the way" in report(verdict)


def test_an_invented_table_is_no_verified_record(folder):
    """Of a policy that cannot be flown again."""
    record = load(folder)
    mine = record["object"]
    mine.table[:] = record["orthogonal"].table  # flights that hold together, and that it has not flown
    write_table(folder / "tables", Path(mine.file).stem, mine.table, with_csv=False)
    change(folder, lambda content: content["policies"][3].update(table_sha256=table_digest(mine.table)))
    forge(folder, "object", "fault", 0, False)
    verdict = verify(folder)
    assert verdict.outcome == "incomplete" and verdict.status["object"] == "not flown" and not verdict.verified
    assert main(["verify", str(folder)]) == 3


def test_learned_policies_travel_in_the_record(plain):
    verdict = verify(plain)
    assert verdict.verified and set(verdict.status.values()) == {"all"} and len(verdict.status) == 4
    assert sorted(path.name for path in (plain / "policies").iterdir()) == [
        one.folder.split("/")[1] for one in load(plain).policies if one.folder
    ]


def test_no_path_of_a_record_is_opened(plain, tmp_path):
    """Not even that of a policy which is there."""
    folder = shutil.copytree(plain, tmp_path / "run")
    agent = shutil.copytree(baselines.AGENTS["ppo-plane"], tmp_path / "agent")
    change(folder, lambda content: content["policies"][2].update(spec=str(agent), folder=None))
    verdict = verify(folder)
    assert verdict.outcome == "incomplete" and "not in the record" in verdict.not_flown["mine"]


def test_a_replaced_policy_is_no_verified_one(plain, tmp_path):
    folder = shutil.copytree(plain, tmp_path / "run")
    (other,) = (one.folder for one in load(folder).policies if one.name == "mine")
    document = folder / other / "policy.json"
    document.write_text(document.read_text() + "\n")
    verdict = verify(folder)
    assert verdict.outcome == "differs" and "not the policy that was recorded" in verdict.not_flown["mine"]
    document.unlink()
    with pytest.raises(RecordError, match=r"policy.json is missing"):
        verify(folder)
    document.symlink_to("/etc/hostname")
    with pytest.raises(RecordError, match="symbolic link"):
        verify(folder)


def test_files_under_the_name_of_a_policy_of_the_package(plain, tmp_path):
    folder = shutil.copytree(plain, tmp_path / "run")
    change(folder, lambda content: content["policies"][2].update(spec="orthogonal"))
    assert "brings files under that name" in verify(folder).not_flown["mine"]


# The command


def run(capsys, *arguments):
    status = main(["verify", *map(str, arguments)])
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def test_the_command_says_yes(sound, plain, capsys):
    status, out, err = run(capsys, plain)
    assert status == 0 and not err and out.endswith("verified: nothing differs\n") and "--seed" in out
    status, out, err = run(capsys, sound)
    assert status == 3 and not err and "INCOMPLETE" in out


def test_the_command_says_no(folder, capsys):
    forge(folder, "none", "zone_severity", 3, 0.0)
    status, out, _ = run(capsys, folder, "--all")
    assert status == 1 and "policy 'none', episode 3, zone_severity: recorded 0.0, found " in out


def test_the_command_speaks_json(folder, capsys):
    forge(folder, "none", "zone_severity", 3, 0.0)
    status, out, _ = run(capsys, folder, "--all", "--json")
    content = json.loads(out)
    assert status == 1 and content["verified"] is False and content["flown"] == {"none": N, "orthogonal": N}
    (difference,) = content["differences"]
    assert (difference["policy"], difference["what"], difference["episode"]) == ("none", "zone_severity", 3)


def test_the_command_ends_with_a_sentence(folder, capsys):
    (folder / "scores.json").write_text("[" * 100_000)
    status, out, err = run(capsys, folder)
    assert status == 2 and not out and len(err.splitlines()) == 1 and "deeper" in err


def test_records_of_other_versions_are_compared_too(folder):
    change(folder, lambda content: content["versions"].update(numpy="1.0", numba="1.0"))
    verdict = verify(folder)
    assert not verdict.differences and set(verdict.versions) == {"numpy", "numba"}
    assert records.versions()["numpy"] == verdict.versions["numpy"][1]


def test_a_worker_that_dies_is_not_held_against_the_record(sound, capsys, monkeypatch):
    from rss_gym.eval import verify as module
    from rss_gym.eval.episodes import WorkerError

    def die(*_, **__):
        raise WorkerError("a worker process died (out of memory)")
        yield

    monkeypatch.setattr(sys.modules["rss_gym.eval.verify"], "fly_blocks", die)
    assert main(["verify", str(sound), "--workers", "2"]) == 3
    out, err = capsys.readouterr()
    assert not out and "could not be checked, which says nothing about it" in err and module
