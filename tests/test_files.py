"""Files appear whole or not at all."""

import errno
import os
import signal
import stat
import subprocess
import sys

import pytest

from rss_gym.files import MARK, new_folder, overwritten, replaced_folder, reserved, tidy, write_text
from rss_gym.params import ParamsError


def test_text_replaces_and_leaves_nothing_else(tmp_path):
    path = tmp_path / "channel.toml"
    path.write_text("old")
    assert write_text(path, "Ω = 1\n") == path
    assert path.read_bytes() == "Ω = 1\n".encode()
    assert stat.S_IMODE(path.stat().st_mode) == 0o644
    assert list(tmp_path.iterdir()) == [path]


def test_failure_keeps_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "channel.toml"
    path.write_text("old")

    def fail(*_):
        raise OSError("disk full")

    monkeypatch.setattr("os.replace", fail)
    with pytest.raises(ParamsError, match=r"channel\.toml.*disk full"):
        write_text(path, "new")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_missing_folder_is_named(tmp_path):
    with pytest.raises(ParamsError, match="missing"):
        write_text(tmp_path / "missing" / "a.toml", "")


def test_a_folder_is_replaced_whole(tmp_path):
    for text in ("one", "two"):
        with replaced_folder(tmp_path / "best") as new:
            (new / text).write_text(text)
    assert [path.name for path in tmp_path.rglob("*")] == ["best", "two"]


def test_a_folder_stays_when_the_new_one_fails(tmp_path):
    with replaced_folder(tmp_path / "best") as new:
        (new / "one").write_text("one")
    with pytest.raises(RuntimeError), replaced_folder(tmp_path / "best") as new:
        (new / "two").write_text("two")
        raise RuntimeError
    assert [path.name for path in tmp_path.rglob("*")] == ["best", "one"]


@pytest.mark.parametrize("renames", [0, 1, 2])
def test_tidy_after_an_end_at_any_moment(tmp_path, monkeypatch, renames):
    """The old folder or the new one is there, whichever rename was the last."""
    with replaced_folder(tmp_path / "best") as new:
        (new / "old").write_text("old")
    (tmp_path / ".mine").write_text("not ours")
    new = tmp_path / ".best-x1" / "best"
    new.mkdir(parents=True)
    (new / "new").write_text("new")
    moves = [(tmp_path / "best", tmp_path / ".best.old"), (new, tmp_path / "best")]
    for source, target in moves[:renames]:
        source.rename(target)
    (tmp_path / ".table.csv-x2").write_text("half")
    tidy(tmp_path, "best", "table.csv")
    found = sorted(path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*"))
    assert found == [".mine", "best", "best/new" if renames == 2 else "best/old"]


# -- folders that are held --------------------------------------------------------------------------------------------


def names(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*"))


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
@pytest.mark.parametrize("mask", [0o022, 0o077, 0o027, 0o002])
def test_permissions_are_those_that_the_user_asks_for(tmp_path, mask):
    before = os.umask(mask)
    try:
        with new_folder(tmp_path / "run") as folder:
            (folder / "tables").mkdir()
            write_text(folder / "scores.json", "{}")
        with replaced_folder(tmp_path / "best") as folder:
            write_text(folder / "a", "")
    finally:
        os.umask(before)
    for path in (tmp_path / "run", tmp_path / "run" / "tables", tmp_path / "best"):
        assert stat.S_IMODE(path.stat().st_mode) == 0o777 & ~mask, path
    for path in (tmp_path / "run" / "scores.json", tmp_path / "best" / "a"):
        assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~mask, path


def places(tmp_path):
    """Ways to name a new folder: missing, below missing ones, empty, a link to an empty one, below a link."""
    (tmp_path / "empty").mkdir()
    (tmp_path / "target").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "target")
    return [tmp_path / name for name in ("missing", "a/b/c", "empty", "link", "link/below")]


@pytest.mark.parametrize("number", range(5))
def test_results_come_into_the_folder_that_was_named(tmp_path, number):
    out = places(tmp_path)[number]
    with reserved(out), new_folder(out) as folder:
        (folder / "tables").mkdir()
        (folder / "tables" / "a").write_text("1")
        (folder / "scores.json").write_text("2")
    assert names(out) == ["scores.json", "tables", "tables/a"]


@pytest.mark.parametrize("number", range(5))
def test_an_error_leaves_what_was_there(tmp_path, number):
    out = places(tmp_path)[number]
    before = names(tmp_path)
    with pytest.raises(RuntimeError), reserved(out), new_folder(out) as folder:
        (folder / "scores.json").write_text("2")
        raise RuntimeError
    assert names(tmp_path) == before


HOLD = """
import sys, time
from rss_gym.files import new_folder, reserved
with reserved(sys.argv[1]), new_folder(sys.argv[1]) as folder:
    (folder / "half").write_text("x")
    print("held", flush=True)
    time.sleep(3600)
"""


@pytest.fixture
def holder(tmp_path):
    """Another process that holds the folder `run`."""
    process = subprocess.Popen([sys.executable, "-c", HOLD, tmp_path / "run"], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "held\n"
    yield process
    process.kill()
    process.communicate()


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_a_second_run_into_the_same_folder_is_refused_at_its_start(tmp_path, holder):
    with pytest.raises(ParamsError, match="being written by another process"), reserved(tmp_path / "run"):
        pytest.fail("both hold it")
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    assert MARK in os.listdir(tmp_path / "run") and len(os.listdir(tmp_path / "run")) == 2
    with new_folder(tmp_path / "run") as folder:  # what was left is cleared
        (folder / "whole").write_text("y")
    assert names(tmp_path) == ["run", "run/whole"]


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_what_others_put_beside_the_leftovers_stays(tmp_path, holder):
    (tmp_path / "run" / "mine").write_text("precious")
    holder.kill()
    holder.wait()
    with pytest.raises(ParamsError, match="not empty"), new_folder(tmp_path / "run"):
        pass
    assert (tmp_path / "run" / "mine").read_text() == "precious"


def test_results_that_cannot_be_moved_are_kept_and_their_place_is_named(tmp_path, monkeypatch):
    replace, moves = os.replace, []

    def fail(source, target):
        moves.append(target)
        if len(moves) == 2:
            raise OSError(errno.ENOSPC, "No space left on device")
        replace(source, target)

    monkeypatch.setattr("os.replace", fail)
    with pytest.raises(ParamsError, match="No space left on device; the results are in") as caught:
        with new_folder(tmp_path / "run") as folder:
            for name in "abc":
                (folder / name).write_text(name)
    place = str(caught.value).rpartition("the results are in ")[2].strip("'")
    assert sorted(os.listdir(place)) == ["b", "c"] and (tmp_path / "run" / "a").read_text() == "a"
    with pytest.raises(ParamsError, match="not empty"), new_folder(tmp_path / "run"):
        pass


def test_overwritten_folder_is_replaced_or_comes_back(tmp_path):
    out = tmp_path / "run"
    for text in ("one", "two"):
        with overwritten(out), new_folder(out) as folder:
            (folder / "scores.json").write_text(text)
        assert names(tmp_path) == ["run", "run/scores.json"] and (out / "scores.json").read_text() == text
    with pytest.raises(RuntimeError), overwritten(out), new_folder(out):
        raise RuntimeError
    assert (out / "scores.json").read_text() == "two"
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "thesis.tex").write_text("precious")
    with pytest.raises(ParamsError, match="is not overwritten"), overwritten(tmp_path / "home"):
        pass
    assert (tmp_path / "home" / "thesis.tex").read_text() == "precious"


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_an_old_folder_comes_back_after_a_kill(tmp_path):
    with new_folder(tmp_path / "run") as folder:
        (folder / "scores.json").write_text("old")
    more = "from rss_gym.files import overwritten\nwith overwritten(sys.argv[1]), reserved"
    code = HOLD.replace("with reserved", more)
    process = subprocess.Popen([sys.executable, "-c", code, tmp_path / "run"], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "held\n"
    process.kill()
    process.communicate()
    with pytest.raises(RuntimeError), overwritten(tmp_path / "run"):
        assert not (tmp_path / "run").exists()
        raise RuntimeError
    assert (tmp_path / "run" / "scores.json").read_text() == "old"


@pytest.mark.skipif(sys.platform == "win32", reason="no such limits")
def test_a_full_disk_leaves_no_half_file(tmp_path):
    code = (
        "import resource, signal, sys\n"
        "from rss_gym.files import new_folder, write_text\n"
        "from rss_gym.params import ParamsError\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
        "try:\n"
        "    with new_folder(sys.argv[1]) as folder:\n"
        "        write_text(folder / 'a', 'x' * 100)\n"
        "        write_text(folder / 'b', 'x' * 100_000)\n"
        "except ParamsError as error:\n"
        "    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code, tmp_path / "run"], capture_output=True, text=True, check=True)
    assert "cannot be written" in done.stdout and "File too large" in done.stdout and not list(tmp_path.iterdir())


@pytest.mark.parametrize("aim", ["gone", "loop", "file", "deep/er"])
def test_a_link_to_no_folder_is_named_as_one(tmp_path, aim):
    (tmp_path / "file").write_text("")
    link = tmp_path / "loop"
    link.symlink_to(aim)
    with pytest.raises(ParamsError, match=r"loop' is a (symbolic link to .* no folder|file)"), new_folder(link):
        pass
    assert link.is_symlink() and sorted(path.name for path in tmp_path.iterdir()) == ["file", "loop"]


def test_a_link_is_not_overwritten_and_not_told_to_be(tmp_path):
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "scores.json").write_text("{}")
    link = tmp_path / "link"
    link.symlink_to("old")
    with pytest.raises(ParamsError, match="is a symbolic link") as caught, overwritten(link), new_folder(link):
        pass
    assert "--overwrite" not in str(caught.value) and (tmp_path / "old" / "scores.json").read_text() == "{}"


def test_a_folder_without_a_name_is_refused():
    with pytest.raises(ParamsError, match="name of the output folder is empty"), new_folder(""):
        pass
