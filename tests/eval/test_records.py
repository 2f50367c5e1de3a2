"""What a run leaves in its folder."""

import csv
import json
import stat

import numpy as np
import pytest

from rss_gym.eval import evaluate, records
from rss_gym.eval.metrics import defined_in
from rss_gym.eval.reading import load
from rss_gym.eval.table import TABLE
from rss_gym.files import check_new
from rss_gym.params import Params, ParamsError

METRICS = defined_in("air")

HTML = "<script>alert('&\"')</script>/../.."


@pytest.fixture(scope="module")
def result():
    return evaluate({"none": "none", HTML: "orthogonal", "Ωμέγα": "brake"}, episodes=20, seed=3, progress=False)


@pytest.fixture
def folder(result, tmp_path):
    return records.save(result, tmp_path / "run", with_csv=True)


def test_the_record_is_as_documented(result, folder):
    content = json.loads((folder / "scores.json").read_text(encoding="utf-8"))
    assert (content["suite"], content["split"], content["seed"], content["episodes"]) == (
        "encounter-v0",
        "suite",
        3,
        20,
    )
    assert content["official"] is False and content["suite_hash"] == result.suite.hash
    assert content["reference"] == HTML and Params.from_dict(content["params"]) == result.suite.params
    assert {"rss-gym", "numpy", "numba", "python", "machine"} <= set(content["versions"])
    for policy, scored in zip(content["policies"], result.policies, strict=True):
        assert (policy["name"], policy["spec"]) == (scored.entry.name, scored.entry.spec)
        assert policy["information"] == "positions" and policy["hash"] == scored.entry.hash
        assert list(policy["metrics"]) == list(METRICS)
        for name, estimate in policy["metrics"].items():
            assert set(estimate) == {"value", "low", "high", "n", "unit"} and estimate["unit"] == METRICS[name].unit


def test_what_is_written_is_read(result, folder):
    record = load(folder)
    assert (record.suite, record.seed, record.episodes, record.reference) == ("encounter-v0", 3, 20, HTML)
    for policy, scored in zip(record.policies, result.policies, strict=True):
        assert policy.table.tobytes() == scored.table.tobytes() and policy.metrics == scored.metrics


def test_the_same_result_gives_the_same_bytes(result, folder, tmp_path):
    again = records.save(result, tmp_path / "again")
    assert (again / "scores.json").read_bytes() == (folder / "scores.json").read_bytes()


def test_names_make_harmless_files(folder):
    files = sorted(path.name for path in (folder / "tables").iterdir())
    assert [file for file in files if file.endswith(".npz")] == [
        "00-none.npz", "01--script-alert-script-..-...npz", "02--.npz",
    ]  # fmt: skip
    assert {path.name for path in folder.iterdir()} == {"scores.json", "tables"}


def test_tables_hold_no_objects_and_the_csv_says_the_same(result, folder):
    with np.load(folder / "tables" / "00-none.npz", allow_pickle=False) as arrays:
        for name in TABLE.names:
            assert np.array_equal(arrays[name], result.policies[0].table[name])
    with open(folder / "tables" / "00-none.csv", newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert header == list(TABLE.names) and len(rows) == 20
    column = header.index("min_separation_m")
    assert [float(row[column]) for row in rows] == result.policies[0].table["min_separation_m"].tolist()


def test_the_digest_is_of_rows_in_little_endian():
    table = np.zeros(2, TABLE)
    table["episode"], table["duration_s"] = [0, 1], 60.0
    assert records.table_digest(table) == records.table_digest(np.concatenate([table, table])[2:])
    assert records.table_digest(table) != records.table_digest(table[::-1])


def test_others_may_read_it(folder):
    assert stat.S_IMODE(folder.stat().st_mode) == 0o755


# Nothing half-written


def test_an_error_while_writing_leaves_nothing(result, tmp_path, monkeypatch):
    monkeypatch.setattr(records, "_write_json", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        records.save(result, tmp_path / "run")
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_is_one_sentence(result, tmp_path, monkeypatch):
    monkeypatch.setattr(np, "savez_compressed", lambda *_, **__: (_ for _ in ()).throw(OSError(28, "No space left")))
    with pytest.raises(ParamsError, match=r"cannot be written: .*No space left"):
        records.save(result, tmp_path / "run")
    assert list(tmp_path.iterdir()) == []


def test_an_empty_folder_may_be_filled_and_a_full_one_not(result, tmp_path):
    (tmp_path / "run").mkdir()
    records.save(result, tmp_path / "run")
    before = (tmp_path / "run" / "scores.json").read_bytes()
    with pytest.raises(ParamsError, match="exists and is not empty"):
        records.save(result, tmp_path / "run")
    assert (tmp_path / "run" / "scores.json").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_parents_are_made_only_with_their_content(result, tmp_path):
    assert check_new(tmp_path / "a" / "b" / "run") == tmp_path / "a" / "b" / "run"
    assert list(tmp_path.iterdir()) == []
    assert (records.save(result, tmp_path / "a" / "b" / "run") / "scores.json").exists()


@pytest.mark.parametrize("name", ["file", "file/run", "file/a/run", "x" * 5000, "nul\0l"])
def test_a_folder_that_cannot_be_is_refused(result, tmp_path, name):
    (tmp_path / "file").write_text("")
    with pytest.raises(ParamsError, match=r"is a file|cannot be written"):
        records.save(result, tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
