"""`rss-gym export`, and the evaluator on what it writes."""

import json
import re
import shutil
import zipfile

import pytest

pytest.importorskip("sb3_contrib", reason="sb3-contrib (extra `train`) is not installed")

from stable_baselines3 import A2C

from rss_gym import baselines
from rss_gym.baselines.agent import load
from rss_gym.cli import main
from rss_gym.params import Params, ParamsError
from rss_gym.sb3 import make_vec_env
from rss_gym.train import recipe, run
from rss_gym.train.convert import export_model, kind_of
from rss_gym.train.learner import Learner

FILES = ("policy.json", "policy.safetensors")


def call(capsys, *arguments):
    status = main(list(arguments))
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def refused(capsys, *arguments):
    status, out, err = call(capsys, *arguments)
    assert status == 2 and not out
    lines = [line for line in err.strip().splitlines() if not line.startswith("Reading ")]
    assert len(lines) == 1
    return lines[0]


@pytest.fixture(scope="module")
def finished(small, tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "run"
    run.start(recipe.load("ppo", small), folder, show=False)
    return folder


@pytest.fixture
def folder(finished, tmp_path):
    """A policy folder of one's own."""
    return shutil.copytree(finished / "agent", tmp_path / "mine")


def test_a_run_gives_its_agent(capsys, finished, tmp_path):
    status, out, err = call(capsys, "export", str(finished), "--out", str(tmp_path / "agent"))
    assert status == 0 and "1,000 observations" in out and not err
    difference = float(out.splitlines()[0].rpartition(" ")[2])
    assert 0.0 < difference <= 1e-5
    for file in FILES:
        assert (tmp_path / "agent" / file).read_bytes() == (finished / "agent" / file).read_bytes()


def test_a_run_under_way_gives_its_best_so_far(capsys, finished, tmp_path):
    shutil.copytree(finished, tmp_path / "run")
    shutil.rmtree(tmp_path / "run" / "agent")
    assert call(capsys, "export", str(tmp_path / "run"), "--out", str(tmp_path / "agent"))[0] == 0
    load(tmp_path / "agent")
    shutil.rmtree(tmp_path / "run" / "seed-0" / "best")
    assert "no agent yet" in refused(capsys, "export", str(tmp_path / "run"), "--out", str(tmp_path / "other"))


def test_a_model_gives_the_policy_of_its_run(capsys, finished, tmp_path):
    model = str(finished / "seed-0" / "best.zip")
    status, out, err = call(capsys, "export", model, "--out", str(tmp_path / "agent"))
    assert status == 0 and "runs code" in err and float(out.splitlines()[0].rpartition(" ")[2]) <= 1e-5
    assert (tmp_path / "agent" / FILES[1]).read_bytes() == (finished / "agent" / FILES[1]).read_bytes()


@pytest.mark.parametrize("name", ["ppo", "recurrent-ppo", "sac"])
def test_the_algorithm_is_told_by_the_file(name, tmp_path):
    changes = {"vec.n_envs": 4, "policy.net_arch": [8], "vec.stack": 2, "world.intruders": 2}
    changes |= {"algorithm.buffer_size": 64} if name == "sac" else {"algorithm.n_steps": 2048}
    learner = Learner.new(recipe.load(name, changes), 0)
    learner.save_model(tmp_path / "model.zip")
    assert kind_of(tmp_path / "model.zip") == name
    assert export_model(tmp_path / "model.zip", tmp_path / "agent", world={"intruders": 2}) <= 1e-5
    agent = load(tmp_path / "agent", Params.of(intruders=2))
    assert agent.network.stack == 2
    with pytest.raises(ParamsError, match=r"--env.*--set") as caught:
        export_model(tmp_path / "model.zip", tmp_path / "other", world={"intruders": 3})
    assert "\n" not in str(caught.value)


def test_bad_models_are_refused_in_one_sentence(capsys, tmp_path):
    out = str(tmp_path / "agent")
    model = A2C("MlpPolicy", make_vec_env("rss_gym/Encounter-v0", 2, seed=0), device="cpu")
    model.save(tmp_path / "a2c.zip")
    assert "--algorithm" in refused(capsys, "export", str(tmp_path / "a2c.zip"), "--out", out)
    assert "cannot be read as SAC" in refused(
        capsys, "export", str(tmp_path / "a2c.zip"), "--algorithm", "sac", "--out", out
    )
    (tmp_path / "text.zip").write_text("no archive")
    assert "not a model of SB3" in refused(capsys, "export", str(tmp_path / "text.zip"), "--out", out)
    with zipfile.ZipFile(tmp_path / "empty.zip", "w"):
        pass
    assert "not a model of SB3" in refused(capsys, "export", str(tmp_path / "empty.zip"), "--out", out)
    assert "not a model of SB3" in refused(capsys, "export", str(tmp_path / "none.zip"), "--out", out)
    assert "did you mean 'ppo'" in refused(capsys, "export", "x.zip", "--algorithm", "pppo", "--out", out)
    assert "did you mean" in refused(capsys, "export", "x.zip", "--env", "rss_gym/Encounter-v1", "--out", out)
    assert "did you mean 'intruders'" in refused(capsys, "export", "x.zip", "--set", "intrudres=2", "--out", out)
    assert "not the folder of a run" in refused(capsys, "export", str(tmp_path), "--out", out)
    assert not (tmp_path / "agent").exists()


def test_options_of_a_model_are_not_for_a_run(capsys, finished, tmp_path):
    words = refused(capsys, "export", str(finished), "--env", "rss_gym/Encounter-v0", "--out", str(tmp_path / "agent"))
    assert "a run knows its own world" in words


def test_a_folder_is_a_policy(folder):
    policy = baselines.make(str(folder), Params())
    assert policy.digest == load(folder).digest and policy.params == Params()
    for name in ("model.zip", "model.pkl", "a:b.pt"):
        with pytest.raises(ParamsError, match="rss-gym export"):
            baselines.make(name)


def evaluated(capsys, folder, out, *more):
    arguments = ["--policy", str(folder), "--episodes", "60", "--out", str(out), *more]
    return call(capsys, "eval", *arguments)


@pytest.mark.slow
def test_scores_of_a_folder_are_verified_and_listed(capsys, folder, tmp_path):
    record = tmp_path / "record"
    status, out, _ = evaluated(capsys, folder, record, "--workers", "2")
    assert status == 0 and re.search(r"\bmine  ", out)
    status, out, _ = call(capsys, "verify", str(record), "--all")
    assert status == 0 and "flown again: 60 encounters of each of none, mine" in out
    assert call(capsys, "leaderboard", str(record), "--out", str(tmp_path / "site"))[0] == 0


@pytest.mark.slow
def test_agents_of_runs_go_by_the_names_of_the_runs(capsys, folder, tmp_path):
    runs = [shutil.copytree(folder, tmp_path / name / "agent") for name in ("first", "second")]
    status, out, _ = evaluated(capsys, runs[0], tmp_path / "record", "--policy", str(runs[1]), "orthogonal")
    assert status == 0 and all(re.search(rf"\b{name}  ", out) for name in ("first", "second", "orthogonal"))
    assert call(capsys, "verify", str(tmp_path / "record"), "--all")[0] == 0


@pytest.mark.slow
def test_a_folder_that_changed_is_not_verified(capsys, folder, finished, tmp_path):
    record = tmp_path / "record"
    assert evaluated(capsys, folder, record)[0] == 0
    document = json.loads((folder / "policy.json").read_text())
    document["training"]["seed"] = 7
    (folder / "policy.json").write_text(json.dumps(document))
    status, out, _ = call(capsys, "verify", str(record))
    assert status == 0  # the record has the files that were flown
    copy = next((record / "policies").iterdir())
    shutil.rmtree(copy)
    shutil.copytree(folder, copy)
    status, out, _ = call(capsys, "verify", str(record))
    assert status == 1 and "is not the policy that was recorded" in out and "differs: policy 'mine', hash" in out
    assert "hash" in refused(capsys, "leaderboard", str(record), "--out", str(tmp_path / "site"))


def test_a_folder_by_a_name_of_ones_own(folder):
    from rss_gym.eval import evaluate

    result = evaluate({"first": str(folder), "second": str(folder)}, episodes=20, progress=False)
    one, two = (scored for scored in result.policies if scored.entry.name != "none")
    assert one.entry.hash == two.entry.hash and one.table.tobytes() == two.table.tobytes()


def test_bad_folders_are_one_sentence(capsys, folder, tmp_path):
    record = tmp_path / "record"

    def words(*more):
        return refused(capsys, "eval", "--policy", str(folder), "--episodes", "9", "--out", str(record), *more)

    assert "information" in words("--information", "ranges")
    (folder / "policy.safetensors").write_bytes(b"nothing")
    assert "policy.safetensors" in words()
    (folder / "policy.json").unlink()
    assert "unknown" in words()
    assert "rss-gym export" in refused(capsys, "eval", "--policy", "model.zip", "--out", str(record))
    assert not record.exists()
