"""A channel written as the TOML that `rss_gym.params.load_channel` reads."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path

from rss_gym.files import write_text
from rss_gym.params import Channel, ParamsError

COMMENT_MAX = 16384  # characters; the reader takes files up to 64 KiB


def save_channel(channel: Channel, path: str | os.PathLike[str], comment: str = "") -> Path:
    """Write a channel, every field of it, under a temporary name and rename it; an old file is replaced.

    Parameters
    ----------
    channel : Channel
        What to write; floats keep every digit.
    path : str or path
        The file, by custom `*.toml`; its folder must exist.
    comment : str
        Lines put above the table, each behind a `#`.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    ParamsError
        If `channel` is no Channel, the comment holds control characters or is too long, or the file cannot be written.
    """
    if not isinstance(channel, Channel):
        raise ParamsError(f"channel must be a Channel, got {type(channel).__name__}")
    lines = comment.splitlines()
    if len(comment) > COMMENT_MAX or not all(line.replace("\t", " ").isprintable() for line in lines):
        raise ParamsError(f"comment must be printable text of at most {COMMENT_MAX} characters, got {comment[:80]!r}")
    fields = [f"{item.name} = {getattr(channel, item.name)!r}" for item in dataclasses.fields(channel)]
    above = [f"# {line}".rstrip() for line in lines]
    return write_text(path, "\n".join([*above, "[channel]", *fields, ""]))
