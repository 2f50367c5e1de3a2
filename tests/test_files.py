"""Files appear whole or not at all."""

import stat

import pytest

from rss_gym.files import replaced_folder, tidy, write_text
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
