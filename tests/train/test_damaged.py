"""Runs that something has happened to: every damage is one sentence that names the file, or does not matter."""

import json
import os
import pickle
import shutil

import pytest

pytest.importorskip("stable_baselines3", reason="stable-baselines3 (extra `train`) is not installed")

from rss_gym.cli import main

DEEP = "[" * 100_000
JSON = [b"", b"{", DEEP.encode(), b"[]", b"null", b"\xff\xfe\x00", b'{"format": 1}', b"9" * 10_000]


def edited(**changes):
    def damage(path):
        document = json.loads(path.read_text())
        for key, value in changes.items():
            if value is None:
                document.pop(key)
            else:
                document[key] = value
        path.write_text(json.dumps(document))

    return damage


def nested(path):
    path.write_text(path.read_text().replace('"recipe": {', f'"more": {DEEP[:50_000]}{"]" * 50_000}, "recipe": {{', 1))


def written(content):
    return lambda path: path.write_bytes(content)


RUN = {f"json {n}": written(content) for n, content in enumerate(JSON)}
RUN |= {
    "nested": nested,
    "versions": edited(versions=[]),
    "no versions": edited(versions=None),
    "recipe": edited(recipe=[]),
    "recipe of strings": edited(recipe="ppo"),
    "recipe without env": edited(recipe={"recipe": {}}),
    "recipe that nests": edited(recipe={"recipe": {"env": {"a": [1]}}}),
    "world": edited(world=3),
    "seeds": edited(seeds="012"),
    "many seeds": edited(seeds=[0] * 5000),
    "no seeds": edited(seeds=[]),
    "name": edited(name=None),
    "format": edited(format=99),
    "missing": lambda path: path.unlink(),
    "folder": lambda path: (path.unlink(), path.mkdir()),
    "link to nowhere": lambda path: (path.unlink(), path.symlink_to("nowhere")),
}
TABLES = {
    f"{name} {n}": (name, content)
    for name in ("progress.csv", "validation.csv")
    for n, content in enumerate([b"\xff\xfe\x00", b"a,b\n1,2\n", b"steps,time/total_timesteps\nx,y\n", b"\x00" * 100])
}


@pytest.fixture
def run(tiny_run, tmp_path):
    return shutil.copytree(tiny_run, tmp_path / "run", symlinks=True)


def one_sentence(status, err, *words):
    assert status in (1, 2) and "Traceback" not in err
    assert len(err) < 2500 and [line for line in err.splitlines() if line.startswith("rss-gym: ")], err
    assert all(word in err for word in words), err


@pytest.mark.parametrize("command", ["resume", "export"])
@pytest.mark.parametrize("damage", RUN)
def test_a_damaged_run_json(run, tmp_path, capsys, damage, command):
    RUN[damage](run / "run.json")
    given = {"resume": ["train", "--resume", str(run)], "export": ["export", str(run), "--out", str(tmp_path / "out")]}
    one_sentence(main(given[command]), capsys.readouterr().err, "run.json" if damage != "world" else "run")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("case", TABLES)
def test_a_damaged_table(run, capsys, case):
    name, content = TABLES[case]
    (run / "seed-0" / name).write_bytes(content)
    one_sentence(main(["train", "--resume", str(run)]), capsys.readouterr().err, name)


class Evil:
    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.mkdir, (str(self.path),)


@pytest.mark.parametrize("what", ["state", "model", "model that runs code", "model of another"])
def test_a_damaged_checkpoint(run, tmp_path, capsys, what):
    checkpoint, ran = run / "seed-0" / "checkpoint", tmp_path / "ran"
    if what == "state":
        (checkpoint / "state.json").write_text(DEEP)
    elif what == "model":
        (checkpoint / "model.zip").write_bytes(b"PK")
    else:
        import zipfile

        with zipfile.ZipFile(checkpoint / "model.zip", "w") as archive:
            evil = pickle.dumps(Evil(ran)) if "code" in what else b""
            for name in ("data", "policy.pth", "policy.optimizer.pth", "pytorch_variables.pth"):
                archive.writestr(name, evil)
    one_sentence(main(["train", "--resume", str(run)]), capsys.readouterr().err, "checkpoint")
    assert not ran.exists()


def test_an_agent_without_its_training_record(run, tmp_path, capsys):
    for place in (run / "agent", run / "seed-0" / "best", run / "seed-1" / "best"):
        edited(training={})(place / "policy.json")
    for given in (["export", str(run), "--out", str(tmp_path / "out")], ["train", "--resume", str(run)]):
        one_sentence(main(given), capsys.readouterr().err, "policy.json", "training")
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_link_in_place_of_the_agent(run, tmp_path):
    moved = shutil.move(run / "agent", tmp_path / "elsewhere")
    (run / "agent").symlink_to(moved)
    assert main(["train", "--resume", str(run)]) == 0
    assert (run / "agent").is_dir() and not (run / "agent").is_symlink()
    assert sorted(os.listdir(moved)) == sorted(os.listdir(run / "agent"))  # what the link led to is untouched


@pytest.mark.slow
def test_a_run_that_cannot_be_locked_is_trained_all_the_same(run, capsys, monkeypatch):
    import rss_gym.train.lock as lock

    def unable(_):
        raise OSError(38, "Function not implemented")

    monkeypatch.setattr(lock, "take", unable)
    assert main(["train", "--resume", str(run)]) == 0
    err = capsys.readouterr().err
    assert "cannot be locked (Function not implemented)" in err and "another process; end it" not in err


@pytest.mark.parametrize("source", ["nowhere", "nowhere.zip", "a/b/c"])
def test_export_of_nothing_runs_nothing(tmp_path, capsys, source):
    status = main(["export", str(tmp_path / source), "--out", str(tmp_path / "out")])
    out, err = capsys.readouterr()
    assert status == 2 and not out and "runs code" not in err and "No such file" in err
    assert not list(tmp_path.iterdir())
