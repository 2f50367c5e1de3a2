"""Files appear whole or not at all."""

import stat

import pytest

from rss_gym.files import write_text
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
