"""`board.jsonl`: signed lines, each with the SHA-256 of the line before; nothing in it is ever changed."""

from __future__ import annotations

import hashlib
import json
import os
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rss_gym.eval.board.signing import check_signature, signed
from rss_gym.eval.reading.plain import RecordError, opened, parse
from rss_gym.files import write_bytes

BOARD = "board.jsonl"
START = "0" * 64
BYTES_MAX = 2**28


def read(path: str | os.PathLike[str], public_key: str | None = None) -> list[dict[str, Any]]:
    """The lines of a board, their order and signatures checked.

    Parameters
    ----------
    path : path
        A file that does not exist holds no lines.
    public_key : str, optional
        Hexadecimal; default: that of the first line, which every other must have too.

    Raises
    ------
    RecordError
        If a line is not JSON, is not what was signed, or does not follow the one before it.
    """
    lines = _lines(Path(path))
    previous, found = START, []
    for number, line in enumerate(lines, 1):
        where = f"{path}, line {number}"
        content = parse(line, where)
        if not isinstance(content, dict) or content.get("previous") != previous:
            raise RecordError(f"{where} does not follow the line before it: a line was changed, added or taken out")
        public_key = public_key or str(content.get("public_key"))
        check_signature(content, public_key, where)
        found.append(content)
        previous = hashlib.sha256(line).hexdigest()
    return found


def head(path: str | os.PathLike[str]) -> str:
    """The hash of the last line: who keeps it can see later whether anything before it was changed."""
    lines = _lines(Path(path))
    return hashlib.sha256(lines[-1]).hexdigest() if lines else START


def append(path: str | os.PathLike[str], content: dict[str, Any], key: bytes) -> dict[str, Any]:
    """Sign a line, put it at the end, and return it; the file is seen with it or without it, never with a half."""
    file = Path(path)
    line = signed(content | {"previous": head(file), "time": datetime.now(UTC).isoformat(timespec="seconds")}, key)
    data = json.dumps(line, sort_keys=True, allow_nan=False).encode() + b"\n"
    before = b"".join(one + b"\n" for one in _lines(file))
    write_bytes(file, before + data)
    return line


def _lines(path: Path) -> list[bytes]:
    if not path.exists() and not path.is_symlink():
        return []
    with opened(path, BYTES_MAX) as stream:
        return stream.read(BYTES_MAX).splitlines()
