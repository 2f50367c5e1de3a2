"""Files and tables of a stranger: plain files only, no larger than they may be, and JSON without surprises."""

from __future__ import annotations

import json
import math
import re
import stat
from pathlib import Path
from typing import Any, BinaryIO

from rss_gym import schema
from rss_gym.eval.records import SCORES
from rss_gym.params import ParamsError
from rss_gym.schema import Schema, shown

DEPTH_MAX = 16


class RecordError(ParamsError):
    """A record that is not one, or not intact; the sentence names file, field, value and what would be right."""


def parse(data: bytes, file: str) -> Any:
    """JSON without NaN, infinities, duplicate keys or deep nesting.

    Raises
    ------
    RecordError
        For anything else; `file` is named in the sentence.
    """

    def pairs(items: list[tuple[str, Any]]) -> dict[str, Any]:
        table: dict[str, Any] = {}
        for key, value in items:
            if key in table:
                raise RecordError(f"{file}: field {shown(key)} is given twice in one table; it must be given once")
            table[key] = value
        return table

    def number(text: str) -> float:
        value = float(text)
        if not math.isfinite(value):
            raise RecordError(f"{file}: number {text[:40]} must be finite")
        return value

    try:
        text = data.decode("utf-8")
        _check_depth(text, file)
        return json.loads(text, object_pairs_hook=pairs, parse_float=number, parse_constant=number)
    except RecordError:
        raise
    except ValueError as error:  # not UTF-8, not JSON, or a whole number of thousands of digits
        raise RecordError(f"{file} is not JSON: {error}") from error


def _check_depth(text: str, file: str) -> None:
    depth, quoted = 0, False
    for match in re.finditer(r'\\.|["\[\]{}]', text):
        token = match[0]
        if token == '"':
            quoted = not quoted
        elif not quoted and token in "[{":
            depth += 1
            if depth > DEPTH_MAX:
                raise RecordError(f"{file} nests tables and lists deeper than {DEPTH_MAX}; a record does not")
        elif not quoted and token in "]}":
            depth -= 1


def read_file(file: Path, limit: int) -> bytes:
    """What a plain file of at most `limit` bytes holds."""
    with opened(file, limit) as stream:
        return stream.read(limit)


def opened(file: Path, limit: int) -> BinaryIO:
    """A plain file of at most `limit` bytes, opened."""
    try:
        info = file.lstat()
        if stat.S_ISLNK(info.st_mode):
            raise RecordError(f"{file} is a symbolic link; a record holds plain files and folders")
        if not stat.S_ISREG(info.st_mode):
            raise RecordError(f"{file} is not a plain file")
        if info.st_size > limit:
            raise RecordError(f"{file} has {info.st_size} bytes; it must have at most {limit}")
        return file.open("rb")
    except FileNotFoundError:
        raise RecordError(f"{file} is missing; a record holds {SCORES} and its tables") from None
    except OSError as error:
        raise RecordError(f"{file} cannot be read: {error}") from error


def checked(file: str, where: str, value: Any, fields: Schema) -> dict[str, Any]:
    """As `rss_gym.schema.checked`, which raises RecordError here."""
    return schema.checked(file, where, value, fields, RecordError)
