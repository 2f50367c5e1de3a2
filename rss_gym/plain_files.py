"""Reading of files that may be anything: plain files only, no longer than they may be, as bytes, TOML or JSON."""

from __future__ import annotations

import json
import os
import re
import stat
import tomllib
from pathlib import Path
from typing import Any

from rss_gym.errors import ParamsError

KEYS_MAX = 8  # parts of a dotted key: tomllib takes memory with the square of them
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_DEEP = re.compile(rf"(?<![\w\"'-]){_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{KEYS_MAX}}}")


def read_plain(path: str | os.PathLike[str], limit: int) -> bytes:
    """What a plain file, or a link to one, of at most `limit` bytes holds.

    Raises
    ------
    ParamsError
        For a folder, a device, a pipe or a longer file, in words that go on after the file's name.
    OSError
        If it cannot be read.
    """
    # A pipe without a writer would wait for one.
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with open(descriptor, "rb") as file:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise ParamsError("is not a plain file")
        content = file.read(limit + 1)
    if len(content) > limit:
        raise ParamsError(f"is larger than {limit:,} bytes, which is more than it may hold")
    return content


def read_toml(path: str | os.PathLike[str], limit: int) -> dict[str, Any]:
    """The tables of a TOML file in UTF-8, with or without a byte order mark.

    Raises
    ------
    ParamsError
        As `read_plain`, and for what is not TOML.
    """
    try:
        text = read_plain(path, limit).decode("utf-8-sig")
        if _DEEP.search(text):
            raise ParamsError(f"has a key of more than {KEYS_MAX} parts")
        return tomllib.loads(text)
    except ParamsError:
        raise
    except (OSError, ValueError, RecursionError) as error:  # tomllib: its own, endless numbers, deep nesting
        raise ParamsError(f"is not readable TOML: {_said(error)}") from error


def read_json(path: str | os.PathLike[str], limit: int) -> Any:
    """The content of a JSON file in UTF-8, with or without a byte order mark.

    Raises
    ------
    ParamsError
        As `read_plain`, and for what is not JSON.
    """
    try:
        return json.loads(read_plain(path, limit).decode("utf-8-sig"))
    except ParamsError:
        raise
    except (OSError, ValueError, RecursionError) as error:
        raise ParamsError(f"is not readable JSON: {_said(error)}") from error


def named(path: str | os.PathLike[str], error: ParamsError) -> ParamsError:
    """The same error with the file's name in front."""
    return type(error)(f"{str(Path(path))!r} {error}")


def _said(error: Exception) -> str:
    """The error without the file's name, which stands before it."""
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return " ".join(str(text).split())[:300]
