"""What strangers may try against a board: each is refused, set aside or harmless, and a sentence says so."""

import dataclasses
import json
import os
import pickle
import shutil
import struct
import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest

from rss_gym import baselines, observation
from rss_gym.core import SEED_LIMIT
from rss_gym.eval.board import breaks, chain, fly, gather, season, site, verdict
from rss_gym.eval.board.entry import FILES, read
from rss_gym.eval.board.fly import Places
from rss_gym.eval.board.limits import Limits, fly_here, fly_limited
from rss_gym.eval.board.pack import pack, unpack
from rss_gym.eval.board.standing import standings
from rss_gym.eval.episodes import Block, PolicyError, fly_all, start
from rss_gym.eval.reading import RecordError
from rss_gym.eval.suites import find
from rss_gym.params import ParamsError

AGENT = baselines.AGENTS["ppo-plane"]
HTML = "<script>alert(1)</script>&\"'"


def refused(folder, words):
    with pytest.raises(RecordError, match=words) as caught:
        read(folder)
    assert len(str(caught.value).splitlines()) == 1


def gathered(folder, known=()):
    return gather.gather(folder, known)


# Files that are not what they seem


@pytest.mark.parametrize("name", ["model.zip", "policy/model.pkl", "policy.onnx", "policy/weights.npz", "run.py", ".x"])
def test_no_other_file_is_part_of_an_entry(make_entry, name):
    folder = make_entry("a", AGENT)
    (folder / name).write_bytes(b"PK\x03\x04")
    refused(folder, "is no part of an entry")


def test_a_pickle_under_another_name_is_never_loaded(make_entry, tmp_path):
    class Trap:
        def __reduce__(self):
            return os.mkdir, (str(tmp_path / "sprung"),)

    folder = make_entry("a", AGENT)
    (folder / "policy" / "policy.safetensors").write_bytes(pickle.dumps(Trap()))
    with pytest.raises(ParamsError, match=r"policy\.safetensors"):
        fly.check_policy(read(folder), find("smoke-v0"))
    assert not (tmp_path / "sprung").exists()


@pytest.mark.parametrize("name", ["card.md", "entry.toml", "policy/policy.json"])
@pytest.mark.parametrize("kind", ["fifo", "link", "folder", "socket or device"])
def test_files_that_are_no_plain_files(make_entry, name, kind):
    folder = make_entry("a", AGENT)
    (folder / name).unlink()
    if kind == "fifo":
        os.mkfifo(folder / name)
    elif kind == "folder":
        (folder / name).mkdir()
    else:
        (folder / name).symlink_to("/dev/zero" if kind != "link" else "/etc/hostname")
    refused(folder, "not a plain file|symbolic link")


def test_a_linked_folder(make_entry, tmp_path):
    folder = make_entry("a", AGENT)
    shutil.move(folder / "policy", tmp_path / "elsewhere")
    (folder / "policy").symlink_to(tmp_path / "elsewhere")
    refused(folder, "no part of an entry")


@pytest.mark.parametrize(("name", "limit"), FILES.items())
def test_files_that_are_too_large(make_entry, name, limit):
    folder = make_entry("a", AGENT)
    with open(folder / name, "ab") as file:
        file.truncate(limit + 1)
    refused(folder, "bytes; it must have at most|is not TOML")


def weights(values, shape=None, dtype="F32"):
    data = np.asarray(values, np.float32).tobytes()
    header = {"0.weight": {"dtype": dtype, "shape": shape or list(np.shape(values)), "data_offsets": [0, len(data)]}}
    text = json.dumps(header).encode()
    return struct.pack("<Q", len(text)) + text + data


@pytest.mark.parametrize(
    "blob",
    [
        b"",
        struct.pack("<Q", 2**62),
        weights([], [0, 10**18]),
        weights([[1.0]]),
        weights([[np.nan]]),
    ],
    ids=["empty", "header", "shape", "others", "nan"],
)
def test_weights_that_are_none(make_entry, blob):
    folder = make_entry("a", AGENT)
    (folder / "policy" / "policy.safetensors").write_bytes(blob)
    with pytest.raises(ParamsError, match=r"policy\.safetensors"):
        fly.check_policy(read(folder), find("smoke-v0"))


def test_weights_with_a_value_that_is_not_finite(make_entry):
    folder = make_entry("a", AGENT)
    file = folder / "policy" / "policy.safetensors"
    data = bytearray(file.read_bytes())
    data[-4:] = struct.pack("<f", np.nan)
    file.write_bytes(data)
    with pytest.raises(ParamsError, match="not finite"):
        fly.check_policy(read(folder), find("smoke-v0"))


# Packed entries


def zipped(file, members):
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members:
            archive.writestr(name, data)
    return file


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize(
    "members",
    [
        [("../evil", b"x")],
        [("/etc/evil", b"x")],
        [("policy/../../evil", b"x")],
        [("entry.toml", b"a"), ("entry.toml", b"b")],
        [("card.md", b"0" * 10**6)],
        [("policy\\policy.json", b"x")],
    ],
    ids=["parent", "absolute", "inside", "twice", "bomb", "backslash"],
)
def test_packed_entries_stay_in_their_folder_and_bounds(tmp_path, members):
    file = zipped(tmp_path / "a.zip", members)
    (tmp_path / "into").mkdir()
    with pytest.raises(RecordError, match=r"no part of an entry|must have at most"):
        unpack(file, tmp_path / "into")
    assert not list((tmp_path / "into").iterdir()) and not (tmp_path / "evil").exists()


def test_packing_is_the_same_bytes_and_unpacks_to_the_same_entry(make_entry, tmp_path):
    folder = make_entry("a", AGENT)
    one, other = pack(folder, tmp_path / "one.zip"), pack(folder, tmp_path / "other.zip")
    assert one.read_bytes() == other.read_bytes()
    assert read(unpack(one, tmp_path / "into")).hash == read(folder).hash
    (tmp_path / "broken.zip").write_bytes(one.read_bytes()[:-30])
    with pytest.raises(RecordError, match="no packed entry"):
        unpack(tmp_path / "broken.zip", tmp_path / "into")


# Fields


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("format", "2", "format = 2 must be 1"),
        ("format", "true", "format = True must be 1"),
        ("name", "3", "name = 3"),
        ("author", '""', "author"),
        ("author", '"rss-gym"', "reserved"),
        ("author", '"a\\u202eb"', "printable"),
        ("date", '"2026-11-27"', "a date"),
        ("date", "nan", "a date"),
        ("licence", '"<b>"', "SPDX"),
        ("link", '"javascript:alert(1)"', "https://"),
        ("link", '"https://a/\\"onclick=x"', "https://"),
        ("suite", '"mine-v0"', "suite"),
        ("policy", '"os:system"', "code is not flown"),
        ("policy", '"/etc"', "code is not flown"),
        ("policy", '"folder"', "needs policy/policy.json"),
        ("extra", "1", "unknown"),
    ],
)
def test_every_field_has_its_rule(make_entry, change, field, value, words):
    folder = make_entry("a")
    change(folder, **{field: value})
    refused(folder, words)


@pytest.mark.parametrize("text", ["name = 1\nname = 2", "a = " + "[" * 3000, "\x00", "[[[", "\xff"])
def test_what_is_no_table(make_entry, text):
    folder = make_entry("a")
    (folder / "entry.toml").write_bytes(text.encode("latin-1"))
    refused(folder, "not TOML")


@pytest.mark.parametrize(
    "name",
    ["оrthogonal", "0rthogonal", "Ortho gonal", "orthogona1", "ppo-p1ane", "orth.ogonal", "OFFICIAL", "n0ne", "all",
     "smoke-vO", HTML, " x", "x" * 41, "a\tb", "ｆull", "𝒶gent"],
)  # fmt: skip
def test_names_that_imitate(make_entry, change, name):
    folder = make_entry("a")
    change(folder, name=json.dumps(name, ensure_ascii=False))
    refused(folder, "reserved|must be 2 to 40")


def test_names_that_read_like_a_rivals(make_entry):
    make_entry("a", name="clever-mind", author="Ada")
    make_entry("b", "orthogonal:radius_m=61", name="c1ever rnlnd", author="Bob")
    make_entry("c", "orthogonal:radius_m=62", name="other", author="Cy")
    found = gathered(make_entry("d", "orthogonal:radius_m=63", name="Clever.Mind", author="Dee").parent)
    assert len(found.entries) == 2 and len(found.refused) == 2 and all("reads like" in why for why in found.refused)


# Many entries, and those of others


def test_clones(make_entry, tmp_path):
    """500 copies of one entry are one; copies of a rival's policy (hijack) are refused, whatever they are called."""
    first = make_entry("a", name="clone-000", author="Author 000")
    text = (first / "entry.toml").read_text()
    for number in range(1, 500):
        folder = shutil.copytree(first, first.parent / f"a{number:03d}")
        changed = text.replace("clone-000", f"clone-{number:03d}").replace("Author 000", f"Author {number:03d}")
        (folder / "entry.toml").write_text(changed)
    found = gathered(first.parent)
    assert len(found.entries) == 1 and len(found.refused) == 499
    assert all("bit for bit" in why or "reads like" in why for why in found.refused)


def test_a_claimed_date_takes_nothing_from_anybody(make_entry):
    """Hijack by an earlier date: who arrived first keeps name and policy."""
    make_entry("001", name="honest", author="Ada", date="2026-11-27")
    make_entry("002", name="stolen", author="Bob", date="2020-01-01")
    found = gathered(make_entry("003", "orthogonal:radius_m=61", name="H0nest", author="Cy", date="2019-01-01").parent)
    assert [entry.name for entry in found.entries] == ["honest"] and len(found.refused) == 2


def test_one_entry_an_author_and_suite_counts(make_entry):
    make_entry("a", name="first try", date="2026-01-01")
    make_entry("b", "orthogonal:radius_m=61", name="second try", date="2026-01-02", author="ADA")
    make_entry("c", "orthogonal:radius_m=62", name="everywhere", suite="all", author="Bob")
    found = gathered(make_entry("d", "orthogonal:radius_m=63", name="somewhere", author="Bob").parent)
    assert {entry.name for entry in found.entries} == {"second try", "everywhere"} and len(found.refused) == 2


def test_a_bad_entry_does_not_block_the_others(make_entry, change):
    change(make_entry("a"), name='"none"')
    good = make_entry("b", author="Bob")
    (good.parent / "README").write_text("")
    (good.parent / "broken.zip").write_text("")
    found = gathered(good.parent)
    assert [entry.author for entry in found.entries] == ["Bob"] and len(found.refused) == 3


@pytest.mark.slow
def test_later_entries_do_not_probe_the_season_again(board, change):
    folder = shutil.copytree(board / "entries" / "a", board / "entries" / "a2")
    change(folder, policy='"orthogonal:radius_m=61"', name='"another"', date="2030-01-01")
    done = fly.fly(board / "entries", board / "season.json", board / "board", runner=fly_here, references=False)
    assert not done.appended and any("has an entry on smoke-v0 in this season already" in why for why in done.refused)


# Flights


def test_a_hung_or_costly_flight_ends_alone(board, change):
    folder = shutil.copytree(board / "entries" / "a", board / "entries" / "z")
    change(folder, policy='"orthogonal:radius_m=61"', name='"slow"', author='"Zed"')

    def runner(job):
        if job.name == "slow":
            raise PolicyError(f"it took too long in episode 3 of seed {job.seed}")
        return fly_here(job)

    done = fly.fly(board / "entries", board / "season.json", board / "board", runner=runner, references=False)
    (line,) = done.appended
    assert "too long" in line["failed"] and "public" not in line
    levels = standings(chain.read(board / "board" / "board.jsonl"), "first", "smoke-v0")
    (row,) = levels["not flown to the end"]
    assert row.place is None and "too long" in row.why_not and len(levels["positions"]) == 3


def test_no_sentence_tells_a_sealed_seed(board, change):
    folder = shutil.copytree(board / "entries" / "a", board / "entries" / "z")
    change(folder, policy='"orthogonal:radius_m=61"', name='"curious"', author='"Zed"')
    seed = season.sealed_seed(season.secret_of(board / "season.json"), "smoke-v0")

    def runner(job):
        if job.seed == seed and job.name == "curious":
            raise PolicyError(f"episode 7 of seed {job.seed}")
        return fly_here(job)

    fly.fly(board / "entries", board / "season.json", board / "board", runner=runner, references=False)
    text = (board / "board" / "board.jsonl").read_text()
    assert "(sealed)" in text and str(seed) not in text
    assert season.secret_of(board / "season.json") not in text


def test_too_little_memory_kills_a_child_only(flown):
    job = fly.Job("smoke-v0", find("smoke-v0").hash, "none", "none", "suite", 0, 0, 2)
    with pytest.raises(PolicyError, match="entry 'none'"):
        fly_limited(job, Limits(memory_bytes=2**26))


@pytest.mark.slow
def test_a_child_flies_the_same(flown):
    job = fly.Job("smoke-v0", find("smoke-v0").hash, "orthogonal", "x", "suite", 0, 3, 5)
    assert np.array_equal(fly_limited(job), fly_here(job))
    with pytest.raises(PolicyError, match="unknown"):
        fly_limited(dataclasses.replace(job, spec="nobody"))


@pytest.mark.parametrize(
    ("policy", "words"), [("cbf+cbf+cbf+orthogonal", "3 filters"), ("folder", "numbers; it must have at most")]
)
def test_costly_policies(make_entry, monkeypatch, policy, words):
    folder = make_entry("a", AGENT if policy == "folder" else policy)
    monkeypatch.setattr(fly, "MADDS_MAX", 100)
    with pytest.raises(ParamsError, match=words):
        fly.check_policy(read(folder), find("smoke-v0"))


def test_a_policy_that_does_not_fit(make_entry, flown, tmp_path):
    make_entry("a", baselines.AGENTS["ppo-range"])
    shutil.copytree(flown, tmp_path / "copy")
    done = fly.fly(
        tmp_path / "entries", tmp_path / "copy" / "season.json", tmp_path / "copy" / "board", runner=fly_here,
        references=False,
    )  # fmt: skip
    assert not done.appended and len(done.refused) == 1


# Scores


def places(board):
    lines = chain.read(board / "board" / "board.jsonl")
    seed = season.sealed_seed(season.secret_of(board / "season.json"), "smoke-v0")
    found = standings(lines, "first", "smoke-v0", Places.of(board / "board", board / "season.json"), seed)
    return {row.line["entry"]["name"]: row for rows in found.values() for row in rows}


def test_fleeing_leads_nothing(flown):
    """A policy of two weights that flies 900 m aside has no collision, and the dearest deviation."""
    rows = places(flown)
    assert rows["Fleeing"].place == 3 and rows["Fleeing"].more is not None and rows["Fleeing"].more[0] > 0.0


def memoriser(folder, suite, count):
    """Make the entry's network know each public encounter by the planned speed, which the flight does not change.

    Three ReLUs make a bump at the speed of every encounter in which `none` collides; there it flies to the right.
    """
    column = [field.name for field in observation.fields(suite.params)].index("cruise_mps")
    block = Block(suite.split, suite.seed, range(count))
    speeds = start(suite.params, block).observations[:, column].astype(np.float64)
    collided = fly_all(baselines.make("none", suite.params), "none", suite.params, block)["collision"].astype(bool)
    width = np.diff(np.sort(speeds)).min() / 2.0
    known = speeds[collided]
    inputs = len(observation.fields(suite.params))
    first, bias, last = np.zeros((inputs, 3 * len(known))), np.zeros(3 * len(known)), np.zeros((3 * len(known), 2))
    first[column] = 1.0 / width
    for k, speed in enumerate(known):
        bias[3 * k : 3 * k + 3] = -(speed + width * np.array([-1.0, 0.0, 1.0])) / width
        last[3 * k : 3 * k + 3, 1] = 1.0, -2.0, 1.0
    file = folder / "policy" / "policy.json"
    document = json.loads(file.read_text())
    document["network"] |= {"layers": [3 * len(known)], "activation": "relu"}
    file.write_text(json.dumps(document))
    save_file(
        {"0.weight": first, "0.bias": bias, "1.weight": last, "1.bias": np.zeros(2)},
        folder / "policy" / "policy.safetensors",
    )


def save_file(tensors, path):
    header, data = {}, b""
    for name, values in sorted(tensors.items()):
        raw = np.asarray(values, np.float32).tobytes()
        header[name] = {"dtype": "F32", "shape": list(values.shape), "data_offsets": [len(data), len(data) + len(raw)]}
        data += raw
    text = json.dumps(header).encode()
    path.write_bytes(struct.pack("<Q", len(text)) + text + data)


def test_a_network_that_has_memorised_the_public_encounters_is_seen_and_does_not_count(make_entry, tmp_path):
    make_entry("a")
    memoriser(make_entry("z", AGENT, name="memory", author="Zed"), find("smoke-v0"), 100)
    file, board = tmp_path / "season.json", tmp_path / "board"
    season.new(file, "first", ["smoke-v0"], 100, 100)
    fly.fly(tmp_path / "entries", file, board, runner=fly_here, references=False)
    (rows,) = standings(chain.read(board / chain.BOARD), "first", "smoke-v0").values()
    honest, memory = rows
    public, sealed = (memory.line[kind]["metrics"]["collision_rate"]["value"] for kind in ("public", "sealed"))
    assert public <= 0.01 and sealed >= 0.2
    assert memory.line["entry"]["name"] == "memory" and memory.alarm and not honest.alarm


def test_flying_exactly_as_another_is_no_place_of_its_own(board, change):
    folder = shutil.copytree(board / "entries" / "a", board / "entries" / "z")
    change(folder, policy='"orthogonal:radius_m=60.0"', name='"same flights"', author='"Zed"')
    fly.fly(board / "entries", board / "season.json", board / "board", runner=fly_here, references=False)
    assert places(board)["same flights"].why_not == "not ranked: it flies exactly as wide-turner"


def test_an_entry_with_faults_has_no_place(board, change):
    folder = shutil.copytree(board / "entries" / "a", board / "entries" / "z")
    change(folder, policy='"orthogonal:radius_m=61"', name='"faulty"', author='"Zed"')

    def runner(job):
        table = fly_here(job)
        table["fault"][:1] = job.name == "faulty"
        return table

    fly.fly(board / "entries", board / "season.json", board / "board", runner=runner, references=False)
    assert places(board)["faulty"].place is None and "2 faults" in places(board)["faulty"].why_not


# Seasons and lines


def test_the_secret_is_the_one_committed_to(board):
    (board / "season.json.secret").write_text("0" * 64)
    for action in (season.secret_of, season.close):
        with pytest.raises(RecordError, match="not the one of the season's commitment"):
            action(board / "season.json")
    content = json.loads((board / "season.json").read_text())
    (board / "season.json").write_text(json.dumps(content | {"secret": "1" * 64}))
    with pytest.raises(RecordError, match="commitment"):
        season.load(board / "season.json")


def test_a_foreign_world_under_a_suites_name(board):
    content = json.loads((board / "season.json").read_text())
    content["suites"][0]["hash"] = "0" * 64
    (board / "season.json").write_text(json.dumps(content))
    with pytest.raises(ParamsError, match="not defined as in the season"):
        fly.fly(board / "entries", board / "season.json", board / "board", runner=fly_here)


def test_a_sealed_seed_cannot_be_relabelled():
    seeds = {season.sealed_seed(f"{secret:064x}", suite) for secret in (1, 2) for suite in ("a", "b")}
    assert len(seeds) == 4 and all(0 <= seed < SEED_LIMIT for seed in seeds)


@pytest.mark.parametrize("how", ["score", "name", "out", "order", "twice", "resigned", "not json"])
def test_no_line_can_be_changed(board, how):
    file = board / "board" / "board.jsonl"
    lines = file.read_bytes().splitlines()
    if how in ("score", "name"):
        content = json.loads(lines[1])
        content["entry"]["name"] = "winner"
        lines[1] = json.dumps(content).encode()
    elif how == "out":
        del lines[1]
    elif how == "order":
        lines[0], lines[1] = lines[1], lines[0]
    elif how == "twice":
        lines.insert(1, lines[1])
    elif how == "resigned":  # by somebody with a key of his own
        from rss_gym.eval.board.signing import signed

        content = json.loads(lines[2])
        bare = {name: value for name, value in content.items() if name not in ("signature", "public_key")}
        lines[2] = json.dumps(signed(bare | {"faults": 0}, b"\1" * 32)).encode()
    else:
        lines[1] = b"{"
    file.write_bytes(b"\n".join(lines) + b"\n")
    with pytest.raises(RecordError):
        chain.read(file)


def test_a_board_signed_by_somebody_else_is_not_continued(board):
    (board / "board.key").unlink()
    with pytest.raises(RecordError, match="line 1: the signature is not that of key"):
        fly.fly(board / "entries", board / "season.json", board / "board", runner=fly_here)


def test_a_rule_change_flies_again_and_appends(board, monkeypatch):
    before = (board / "board" / "board.jsonl").read_bytes()
    monkeypatch.setattr(verdict, "RULES", verdict.RULES + 1)
    done = fly.fly(None, board / "season.json", board / "board", runner=fly_here, references=False)
    assert not done.appended
    shutil.rmtree(board / "season.private" / "work")
    done = fly.fly(board / "entries", board / "season.json", board / "board", runner=fly_here, references=False)
    assert not done.refused, done.refused
    assert len(done.appended) == 3 and (board / "board" / "board.jsonl").read_bytes().startswith(before)


def test_deleted_and_replaced_entries(board, change):
    """The lines and the board's copies stay; a replaced copy is noticed where it would be flown."""
    shutil.rmtree(board / "entries")
    (board / "entries").mkdir()
    fly.fly(board / "entries", board / "season.json", board / "board", runner=fly_here, references=False)
    assert set(places(board)) == {"wide-turner", "ppo copy", "Fleeing"}
    file = attack(board, entry='"wide-turner"')
    for copy in (board / "board" / "entries").iterdir():
        (copy / "card.md").write_text("changed")
    with pytest.raises(ParamsError, match="not what was flown"):
        breaks.fly(file, board / "season.json", board / "board", fly_here)


# Breaks


def attack(board, **fields):
    lines = {
        "format": 1, "entry": '"Fleeing"', "suite": '"smoke-v0"', "author": '"Eve"', "date": "2026-11-27", "seed": 5,
        "episodes": "[0, 1, 2]", "family": '""', "channel": '""',
    } | fields  # fmt: skip
    (board / "break.toml").write_text("".join(f"{key} = {value}\n" for key, value in lines.items()))
    return board / "break.toml"


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("channel", '"/dev/zero"'),
        ("channel", '"../x.toml"'),
        ("family", '"nobody"'),
        ("episodes", "[]"),
        ("episodes", "5"),
        ("episodes", "[1, 1]"),
        ("episodes", "true"),
        ("episodes", "1_000_000_000"),
        ("seed", "-1"),
        ("suite", '"x"'),
        ("entry", '"nobody"'),
        ("more", "1"),
    ],
)
def test_breaks_have_rules_too(board, field, value):
    with pytest.raises(RecordError):
        breaks.fly(attack(board, **{field: value}), board / "season.json", board / "board", fly_here)


def test_a_break_is_flown_and_listed_only_if_it_is_worse(board):
    """Slander: a claim against an entry counts for nothing, its own flights do."""
    before = len(chain.read(board / "board" / "board.jsonl"))
    same = attack(board, entry='"wide-turner"', seed=0, episodes="[3]")
    line = breaks.fly(same, board / "season.json", board / "board", lambda job: free(fly_here(job)))
    assert not line["worse"] and len(chain.read(board / "board" / "board.jsonl")) == before
    line = breaks.fly(attack(board, family='"crossing"', author='"<b>"'), board / "season.json", board / "board", dear)
    assert line["worse"] and len(chain.read(board / "board" / "board.jsonl")) == before + 1


def free(table):
    table["cost_m"] = table["deviation_mean_m"] = 0.0
    return table


def dear(job):
    assert dict(job.changes) == {"families": "crossing"} and job.numbers == (0, 1, 2)
    table = fly_here(job)
    table["cost_m"] += 1e5
    return table


# Pages


def test_html_in_every_field_is_text(flown, board, change):
    folder = shutil.copytree(board / "entries" / "a", board / "entries" / "z")
    change(folder, policy='"orthogonal:radius_m=61"', name='"html"', author=json.dumps(HTML))
    (folder / "card.md").write_text(HTML + "[x](javascript:1)")
    fly.fly(board / "entries", board / "season.json", board / "board", runner=fly_here, references=False)
    breaks.fly(
        attack(board, author=json.dumps(HTML), family='"crossing"'), board / "season.json", board / "board", dear
    )
    out = site.build(board / "board", [board / "season.json"], board / "site", count=0).parent
    pages = [*out.rglob("*.html"), out / "feed.xml"]
    assert len(pages) == 8 and ElementTree.fromstring((out / "feed.xml").read_text(encoding="utf-8")) is not None
    assert "picked one by one" in (out / "first-smoke-v0.html").read_text(encoding="utf-8")
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert "<script" not in text and "alert(1)</script>" not in text and "Bob <b>" not in text
    assert sum("&lt;script&gt;" in page.read_text(encoding="utf-8") for page in pages) >= 4
