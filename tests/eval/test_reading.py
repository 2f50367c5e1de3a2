"""Records from strangers: what is wrong is refused in one sentence, quickly, without running or believing it."""

import io
import json
import os
import shutil
import struct
import time
import tracemalloc
import zipfile
import zlib

import numpy as np
import pytest

from rss_gym.eval import evaluate
from rss_gym.eval.reading import EPISODES_MAX, SCORES_BYTES_MAX, RecordError, load, parse, read_table
from rss_gym.eval.records import save, table_digest, write_table
from rss_gym.eval.table import TABLE
from rss_gym.params import ParamsError

N = 30
NONE, RULE = "tables/00-none.npz", "tables/01-orthogonal.npz"


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    return save(evaluate("orthogonal", episodes=N, progress=False), tmp_path_factory.mktemp("sound") / "run")


@pytest.fixture
def folder(sound, tmp_path):
    """A copy to spoil."""
    return shutil.copytree(sound, tmp_path / "run")


@pytest.fixture(autouse=True)
def quick():
    start = time.process_time()  # of this process, whatever else the machine does
    yield
    assert time.process_time() - start < 20.0


def refused(folder, *words):
    with pytest.raises(RecordError) as caught:
        load(folder)
    sentence = str(caught.value)
    assert "\n" not in sentence and len(sentence) < 1500, sentence
    for word in words:
        assert word in sentence, sentence
    return sentence


def change(folder, edit):
    """Apply `edit` to the record's JSON."""
    file = folder / "scores.json"
    content = json.loads(file.read_text())
    edit(content)
    file.write_text(json.dumps(content))


def test_a_sound_record_is_read(sound):
    record = load(sound)
    assert [policy.name for policy in record.policies] == ["none", "orthogonal"]
    assert record["orthogonal"].table.dtype == TABLE and len(record["orthogonal"].table) == N
    assert issubclass(RecordError, ParamsError)  # so that every command ends with the sentence and status 2


# The file


def test_what_is_not_a_record(tmp_path):
    refused(tmp_path / "nowhere", "nowhere", "not a folder")
    (tmp_path / "file").write_text("x")
    refused(tmp_path / "file", "not a folder")
    (tmp_path / "empty").mkdir()
    refused(tmp_path / "empty", "scores.json", "missing")


@pytest.mark.parametrize(
    ("data", "word"),
    [
        (b"", "not JSON"),
        (b"{", "not JSON"),
        (b"PK\x03\x04" + bytes(range(256)), "not JSON"),
        (b"\xef\xbb\xbf{}", "not JSON"),
        ('{"suite": "é"}'.encode("latin-1"), "not JSON"),
        (b"{}", "missing"),
        (b"[]", "must be a table"),
        (b"null", "must be a table"),
        (b'{"a": 1, "a": 2}', "'a' is given twice"),
        (b'{"a": NaN}', "NaN must be finite"),
        (b'{"a": -Infinity}', "-Infinity must be finite"),
        (b'{"a": 1e999}', "1e999 must be finite"),
        (b'{"a": ' + b"9" * 10_000 + b"}", "not JSON"),
        (b'{"suite": "x", "colour": 1}', "'colour' is unknown"),
        (b'{"\\ud800": 1}', "unknown"),
        (b"[" * 100_000 + b"]" * 100_000, "deeper than"),
        (b'{"a":' * 100_000 + b"1" + b"}" * 100_000, "deeper than"),
        (b'{"a": "' + b"[" * 100_000 + b'"}', "'a' is unknown"),  # brackets in a string are no depth
        (b'["' + b'\\"' * 1_000_000, "not JSON"),
        pytest.param(b'"' * (SCORES_BYTES_MAX - 1), "not JSON", marks=pytest.mark.slow),
        pytest.param(b"[]," * (SCORES_BYTES_MAX // 3), "not JSON", marks=pytest.mark.slow),
    ],
    ids=lambda value: None if isinstance(value, str) else repr(value[:20]),
)
def test_json_that_is_no_record(folder, data, word):
    (folder / "scores.json").write_bytes(data)
    refused(folder, "scores.json", word)


def test_truncated_json(folder):
    data = (folder / "scores.json").read_bytes()
    for length in range(0, len(data) - 2, len(data) // 50):
        (folder / "scores.json").write_bytes(data[:length])
        refused(folder, "scores.json")


def test_a_gigabyte_is_not_read(folder):
    with open(folder / "scores.json", "wb") as file:
        file.truncate(2**30)
    refused(folder, "scores.json", "1073741824 bytes", str(SCORES_BYTES_MAX))


def test_links_and_pipes_are_not_followed(folder, sound):
    (folder / "scores.json").unlink()
    (folder / "scores.json").symlink_to(sound / "scores.json")
    refused(folder, "scores.json", "symbolic link")
    (folder / "scores.json").unlink()
    os.mkfifo(folder / "scores.json")
    refused(folder, "scores.json", "not a plain file")


# The fields


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("schema", 1, ["schema = 1"]),
        ("schema", True, ["schema = True"]),
        ("suite", "", ["suite = ''"]),
        ("suite", "a\u001b[2J", ["suite = "]),
        ("suite", "x" * 300, ["suite = ", "200 printable"]),
        ("suite_hash", "0" * 63, ["suite_hash = ", "64 hex digits"]),
        ("suite_hash", "G" * 64, ["64 hex digits"]),
        ("suite_hash", "A" * 64, ["64 hex digits"]),
        ("suite_hash", "a" * 64 + "\n", ["64 hex digits"]),
        ("split", "test", ["split = 'test'", "validation"]),
        ("suite", [], ["suite = []"]),
        ("split", [], ["split = []"]),
        ("seed", -1, ["seed = -1", "2**63"]),
        ("seed", 2**63, ["seed = "]),
        ("seed", 0.0, ["seed = 0.0", "whole"]),
        ("seed", "0", ["seed = '0'"]),
        ("episodes", 0, ["episodes = 0"]),
        ("episodes", True, ["episodes = True"]),
        ("episodes", 10**15, ["episodes = ", str(EPISODES_MAX)]),
        ("episodes", N + 1, ["tables/00-none.npz", "column 'episode'"]),
        ("official", 1, ["official = 1"]),
        ("official", "yes", ["official = 'yes'"]),
        ("reference", "nobody", ["'nobody'", "none"]),
        ("families", ["crossing"], ["families = ['crossing']", "head-on"]),
        ("families", "mixed", ["families = 'mixed'"]),
        ("params", [], ["params = []"]),
        ("params.zone.range_error_m", -4.0, ["range_error_m", "-4.0"]),
        ("params.zone.range_error_m", 10**400, ["params"]),
        ("params.zone.range_error_m", "4", ["range_error_m", "'4'"]),
        ("params.zone.colour", 1, ["'colour'"]),
        ("params.zone", None, ["params.zone"]),
        ("params.encounter.families", ["crosing"], ["'crosing'", "did you mean"]),
        ("params.encounter.families", {"a": 1}, ["families"]),
        ("params.channels", "paper", ["params.channels = 'paper'", "list"]),
        ("params.channels", ["/etc/passwd"], ["params.channels", "tables"]),
        ("params.channels", [], ["params.channels"]),
        ("params.channels.0.packet_loss", 2, ["packet_loss", "2"]),
        ("versions", {"numpy": 2}, ["versions"]),
        ("versions", {"a" * 201: "1"}, ["versions"]),
        ("policies", {}, ["policies = {}"]),
        ("policies", [], ["policies = []"]),
        ("policies.0", None, ["policies[0] = None"]),
        ("policies.0.name", "nothing", ["'none'"]),
        ("policies.0.spec", "orthogonal", ["policies[0].spec = 'orthogonal'", "'none'"]),
        ("policies.1.name", "none", ["policies[1].", "'none'"]),
        ("policies.1.name", "a\nb", ["policies[1].name", "printable"]),
        ("policies.1.name", 5, ["policies[1].name = 5"]),
        ("policies.1.spec", "x" * 1001, ["policies[1].spec", "1000"]),
        ("policies.1.spec", "\ud800", ["policies[1].spec"]),
        ("policies.1.hash", "abc", ["policies[1].hash = 'abc'"]),
        ("policies.1.information", "radar", ["policies[1].information = 'radar'", "oracle, positions, ranges"]),
        ("policies.1.information", {}, ["policies[1].information"]),
        ("policies.1.metrics", [], ["policies[1].metrics"]),
        ("policies.1.metrics.collision_rat", {}, ["collision_rat", "did you mean 'collision_rate'"]),
        ("policies.1.metrics.collision_rate", 0.1, ["policies[1].metrics.collision_rate = 0.1"]),
        ("policies.1.metrics.collision_rate.value", "0", ["collision_rate.value = '0'", "finite number or null"]),
        ("policies.1.metrics.collision_rate.value", True, ["collision_rate.value = True"]),
        ("policies.1.metrics.collision_rate.value", 10**400, ["collision_rate.value"]),
        ("policies.1.metrics.collision_rate.low", 0.9, ["collision_rate.low = 0.9", "above high"]),
        ("policies.1.metrics.collision_rate.n", 1.5, ["collision_rate.n = 1.5"]),
        ("policies.1.metrics.collision_rate.n", -1, ["collision_rate.n = -1"]),
        ("policies.1.metrics.collision_rate.unit", "m", ["collision_rate.unit = 'm'", "'1'"]),
        ("policies.1.metrics.collision_rate.p", 1, ["collision_rate.p", "unknown"]),
        ("policies.1.table", "/etc/passwd", ["policies[1].table = '/etc/passwd'"]),
        ("policies.1.table", "../run/tables/01-orthogonal.npz", ["policies[1].table"]),
        ("policies.1.table", "tables/../tables/01-orthogonal.npz", ["policies[1].table"]),
        ("policies.1.table", "tables/01-orthogonal.npz\n", ["policies[1].table"]),
        ("policies.1.table", "tables\\01-orthogonal.npz", ["policies[1].table"]),
        ("policies.1.table", NONE, ["policies[1].table", "twice"]),
        ("policies.1.table", "tables/02-gone.npz", ["02-gone.npz", "missing"]),
        ("policies.1.table_sha256", "0" * 64, ["table_sha256", "digest of tables/01-orthogonal.npz"]),
    ],
    ids=str,
)
def test_a_wrong_field_is_named_with_its_value(folder, path, value, words):
    def edit(content):
        *parents, last = [int(part) if part.isdigit() else part for part in path.split(".")]
        for part in parents:
            content = content[part]
        content[last] = value

    change(folder, edit)
    refused(folder, str(folder), *words)


@pytest.mark.parametrize(
    "path", ["suite_hash", "reference", "params.zone.zone", "policies.0.table", "policies.0.metrics.faults.n"]
)
def test_a_missing_field_is_named(folder, path):
    def edit(content):
        *parents, last = [int(part) if part.isdigit() else part for part in path.split(".")]
        for part in parents:
            content = content[part]
        del content[last]

    change(folder, edit)
    refused(folder, "scores.json", path.rpartition(".")[2])


def test_a_thousand_policies_and_one(folder):
    change(folder, lambda content: content.update(policies=content["policies"][:1] * 1001))
    refused(folder, "policies", "1000")


def test_reading_opens_no_channel_file(folder, tmp_path):
    trap = tmp_path / "trap.toml"
    os.mkfifo(trap)  # to open it would wait for ever
    change(folder, lambda content: content["params"].update(channels=[str(trap)]))
    refused(folder, "params.channels")


def test_tables_without_end(folder):
    change(folder, lambda content: content.update(policies=content["policies"][:1] * 900, episodes=EPISODES_MAX))
    refused(folder, "900 policies", "bytes")


# Tables


def columns(folder, name=RULE):
    with np.load(folder / name) as arrays:
        return {name: arrays[name] for name in TABLE.names}


def write(folder, arrays, name=RULE, compression=zipfile.ZIP_DEFLATED):
    """A zip of these members: arrays, or bytes as they are."""
    with zipfile.ZipFile(folder / name, "w", compression) as archive:
        for member, value in arrays.items():
            if not isinstance(value, bytes):
                file = io.BytesIO()
                np.save(file, value, allow_pickle=True)
                value = file.getvalue()
            archive.writestr(member if "." in member else f"{member}.npy", value)


def header(descr, shape, version=(1, 0), fortran=False):
    text = repr({"descr": descr, "fortran_order": fortran, "shape": shape}).encode()
    text += b" " * (63 - (10 + len(text)) % 64) + b"\n"
    return b"\x93NUMPY" + bytes(version) + struct.pack("<H", len(text)) + text


class Trap:
    def __reduce__(self):
        return os._exit, (13,)


BODY = bytes(8 * N)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (np.array([Trap()] * N, dtype=object), ["closest_s"]),
        (header("|O", (N,)) + BODY, ["object", f"({N},)"]),
        (header("<f8", (N + 1,)) + BODY, [f"({N + 1},)", f"({N},)"]),
        (header("<f8", (1, N)) + BODY, [f"(1, {N})"]),
        (header("<f8", (-N,)) + BODY, ["closest_s"]),
        (header("<f8", (4 * 2**30,)) + BODY, [f"({4 * 2**30},)"]),  # claims 32 GiB
        (header("<f8", (2**62,)) + BODY, [f"({2**62},)"]),
        (header("<f8", (0, 10**18)) + BODY, ["closest_s"]),
        (header("<f8", (N,), fortran=True) + BODY, ["closest_s"]),
        (header("<i8", (N,)) + BODY, ["int64", "float64"]),
        (header(">f8", (N,)) + BODY, [">f8", "float64"]),
        (header([("a", "<f8")], (N,)) + BODY, ["closest_s"]),
        (header("<f8", (N,), version=(2, 0)) + BODY, ["(2, 0)"]),
        (header("<f8", (N,)) + BODY[:-1], ["closest_s"]),
        (header("<f8", (N,)) + BODY + b"\0", ["closest_s"]),
        (b"\x93NUMPY\x01\x00" + struct.pack("<H", 120) + b"__import__('os')._exit(13)".ljust(120) + BODY, ["header"]),
        (b"\x93NUMPY\x01\x00" + struct.pack("<H", 120) + b"(" * 120 + BODY, ["no array header"]),
        (b"\x93NUMPY\x01\x00" + struct.pack("<H", 65535) + BODY, ["no array header"]),
        (b"\x80\x04cos\n_exit\n" + BODY, ["npz"]),
        (bytes(10), ["closest_s", "10 bytes"]),
        (bytes(20_000_000), ["closest_s", "20000000 bytes"]),
        (np.full(N, np.nan), ["closest_s", "nan", "finite"]),
        (np.full(N, np.inf), ["closest_s", "inf", "finite"]),
        (np.full(N, -1.0), ["closest_s", "-1.0", "at least"]),
    ],
    ids=range(24),
)
def test_a_column_that_is_not_one(folder, value, words):
    write(folder, columns(folder) | {"closest_s": value})
    refused(folder, "01-orthogonal.npz", *words)


@pytest.mark.parametrize(
    ("column", "row", "value", "words"),
    [
        ("episode", 3, 4, ["row 3 is 4", "row's number"]),
        ("family", 0, 99, ["'family'", "99"]),
        ("family", 0, -1, ["'family'", "-1"]),
        ("channel", 1, 1, ["'channel'", "at most 0"]),
        ("duration_s", 2, 0.0, ["'duration_s'", "above zero"]),
        ("flown_s", 5, 1e6, ["'flown_s'"]),
        ("collision", 7, None, ["'collision'", "min_separation_m", "4.5"]),
        ("min_separation_m", 7, 0.1, ["'collision'", "4.5"]),
        ("zone_severity", 3, 1.5, ["'zone_severity'", "at most 1"]),
        ("cost_m", 4, 0.5, ["'cost_m'", "row 4 is 0.5", "the cost of deviation_mean_m, snmac and collision"]),
        ("snmac", 6, None, ["'cost_m'", "row 6"]),
        ("duration_s", 9, 1e4, ["'duration_s'", "episode 9", "00-none.npz", "the same for every policy"]),
    ],
)
def test_rows_that_no_flight_has(folder, column, row, value, words):
    arrays = columns(folder)
    arrays[column][row] = ~arrays[column][row] if value is None else value
    write(folder, arrays)
    table = np.zeros(N, TABLE)
    for name in TABLE.names:
        table[name] = arrays[name]
    change(folder, lambda content: content["policies"][1].update(table_sha256=table_digest(table)))
    refused(folder, "01-orthogonal.npz", *words)


def test_bytes_that_are_no_truth_values(folder):
    write(folder, columns(folder) | {"fault": header("|b1", (N,)) + b"\x02" * N})
    refused(folder, "01-orthogonal.npz", "'fault'", "0 or 1")


def without(arrays, name):
    return {key: value for key, value in arrays.items() if key != name}


@pytest.mark.parametrize(
    ("edit", "word"),
    [
        (lambda arrays: without(arrays, "snmac"), "members"),
        (lambda arrays: arrays | {"extra": arrays["snmac"]}, "members"),
        (lambda arrays: without(arrays, "snmac") | {"SNMAC": arrays["snmac"]}, "snmac"),
        (lambda arrays: without(arrays, "snmac") | {"../snmac.npy": b""}, "snmac"),
        (lambda arrays: without(arrays, "snmac") | {"/etc/x.npy": b""}, "snmac"),
        (lambda arrays: {f"{i}.npy": b"" for i in range(300)}, "300 members"),
        (lambda arrays: {}, "0 members"),
    ],
    ids=["missing", "more", "case", "parent", "absolute", "many", "empty"],
)
def test_members_are_the_columns(folder, edit, word):
    write(folder, edit(columns(folder)))
    refused(folder, "01-orthogonal.npz", word)


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_member_given_twice(folder):
    arrays = without(columns(folder), "snmac")
    with zipfile.ZipFile(folder / RULE, "w") as archive:
        for name in (*arrays, "family"):
            archive.writestr(f"{name}.npy", header("<f8", (N,)) + BODY)
    refused(folder, "01-orthogonal.npz", "members")


@pytest.mark.parametrize("kind", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_other_compression_is_refused(folder, kind):
    write(folder, columns(folder), compression=kind)
    refused(folder, "01-orthogonal.npz", "compressed")


def test_tables_may_be_stored_plainly(folder):
    write(folder, columns(folder), compression=zipfile.ZIP_STORED)
    assert len(load(folder).policies) == 2


def test_a_bomb_is_not_inflated(folder):
    packed = zlib.compressobj(9, wbits=-15)
    data = packed.compress(header("<f8", (N,)) + bytes(50_000_000)) + packed.flush()
    write(folder, columns(folder))
    # Swap in megabytes of zeros that the directory says are a column of the right size.
    with zipfile.ZipFile(folder / RULE, "a") as archive:
        info = archive.getinfo("closest_s.npy")
        info.compress_size = len(data)
        info.header_offset = archive.start_dir
        archive.fp.seek(archive.start_dir)
        archive.fp.write(info.FileHeader(zip64=False) + data)
        archive.start_dir = archive.fp.tell()
        archive._didModify = True
    tracemalloc.start()
    refused(folder, "01-orthogonal.npz", "CRC")
    assert tracemalloc.get_traced_memory()[1] < 12_000_000
    tracemalloc.stop()


@pytest.mark.parametrize("place", [0, 1, 30, 500, -1, -10, -22, -40, -100])
def test_a_flipped_byte_is_found(folder, place):
    data = bytearray((folder / RULE).read_bytes())
    data[place] ^= 0xFF
    (folder / RULE).write_bytes(data)
    try:
        table = load(folder)["orthogonal"].table
    except RecordError:
        return
    assert table_digest(table) == load(folder)["orthogonal"].table_sha256  # a byte that means nothing


def test_truncated_tables(folder):
    data = (folder / RULE).read_bytes()
    for length in range(0, len(data), len(data) // 40):
        (folder / RULE).write_bytes(data[:length])
        refused(folder, "01-orthogonal.npz")


@pytest.mark.parametrize("data", [b"", b"PK\x05\x06" + bytes(18), b"x" * 1000, b"PK\x05\x06" * 300])
def test_foreign_tables(folder, data):
    (folder / RULE).write_bytes(data)
    refused(folder, "01-orthogonal.npz")


def test_a_directory_elsewhere_is_refused(folder):
    data = (folder / RULE).read_bytes()
    for tail in (b"\0", b"PK\x06\x07" + bytes(16)):
        (folder / RULE).write_bytes(data[:-22] + tail + data[-22:])
        refused(folder, "01-orthogonal.npz", "directory")
    (folder / RULE).write_bytes(b"#!/bin/sh\n" + data)
    refused(folder, "01-orthogonal.npz", "directory")


def test_a_large_file_is_not_opened(folder):
    with open(folder / RULE, "r+b") as file:
        file.truncate(2**34)
    refused(folder, "01-orthogonal.npz", "bytes")


def test_linked_tables_are_refused(folder, sound):
    (folder / RULE).unlink()
    (folder / RULE).symlink_to(sound / RULE)
    refused(folder, "01-orthogonal.npz", "symbolic link")
    shutil.rmtree(folder / "tables")
    (folder / "tables").symlink_to(sound / "tables")
    refused(folder, "tables", "symbolic link")
    (folder / "tables").unlink()
    (folder / "tables").mkdir()
    os.mkfifo(folder / NONE)
    refused(folder, "00-none.npz", "not a plain file")


def test_a_table_on_its_own(tmp_path):
    table = np.zeros(5, TABLE)
    write_table(tmp_path, "t", table, with_csv=False)
    assert read_table(tmp_path / "t.npz", 5).tobytes() == table.tobytes()
    with pytest.raises(RecordError, match="column"):
        read_table(tmp_path / "t.npz", 6)


def test_parse_alone():
    assert parse(b'{"a": [1, 2.5, null, true, "\\u00e9"]}', "x") == {"a": [1, 2.5, None, True, "é"]}
