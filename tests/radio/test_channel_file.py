"""Channels written are the channels read."""

import dataclasses
import tempfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.params import CHANNELS, Channel, ParamsError, load_channel
from rss_gym.radio import save_channel

RADIOS = st.builds(
    Channel, **{f.name: st.floats(f.metadata["low"], f.metadata["high"]) for f in dataclasses.fields(Channel)}
)
PRINTABLE = st.text(st.characters(exclude_categories=("C", "Z")) | st.just(" "), max_size=60)


@given(RADIOS, PRINTABLE)
def test_round_trip(channel, comment):
    with tempfile.TemporaryDirectory() as folder:
        path = save_channel(channel, Path(folder) / "own.toml", comment)
        assert load_channel(path) == channel
        assert path.read_text(encoding="utf-8").startswith(f"# {comment}".rstrip() if comment else "[channel]")
        assert [file.name for file in Path(folder).iterdir()] == ["own.toml"]


@pytest.mark.parametrize("name", CHANNELS)
def test_presets_and_replacing(name, tmp_path):
    path = tmp_path / "own.toml"
    path.write_text("old")
    save_channel(load_channel(name), path, "two\nlines")
    assert load_channel(path) == load_channel(name)
    assert path.read_text().splitlines()[:3] == ["# two", "# lines", "[channel]"]


@pytest.mark.parametrize("comment", ["bell \a", "null \0", "x" * 20_000])
def test_bad_comment(comment, tmp_path):
    with pytest.raises(ParamsError, match="comment"):
        save_channel(Channel(), tmp_path / "own.toml", comment)
    assert list(tmp_path.iterdir()) == []


def test_bad_channel_and_path(tmp_path):
    with pytest.raises(ParamsError, match="Channel, got str"):
        save_channel("paper", tmp_path / "own.toml")
    (tmp_path / "folder.toml").mkdir()
    for path in (tmp_path / "missing" / "own.toml", tmp_path / "folder.toml", tmp_path / "nu\0ll.toml"):
        with pytest.raises(ParamsError, match="cannot be written"):
            save_channel(Channel(), path)
    assert [p.name for p in tmp_path.iterdir()] == ["folder.toml"]
