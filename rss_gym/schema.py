"""What the tables of a file may hold: a schema names each field, its kind, and thereby what would be right.

A schema is a mapping from the name of a field to its kind. `checked` finds a table to have these fields and no others;
its one sentence names file, field, value and what would be right, and the nearest name where one is unknown.
"""

from __future__ import annotations

import math
import re
import reprlib
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from rss_gym.errors import ParamsError, suggestion

NAME_MAX = 200  # characters of a name that are compared with the known ones


class Kind(NamedTuple):
    """What one value may be: a test, and the words for what passes it."""

    test: Callable[[Any], bool]
    right: str


Schema = Mapping[str, Kind]

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 80
_SHORT.maxlevel = 2


def shown(value: Any) -> str:
    """A value from a file, short and printable."""
    return _SHORT.repr(value)


def version(*read: int) -> Kind:
    """The version of a format, one of those that are read."""
    right = f"{' or '.join(map(str, read))}, which this version reads"
    return Kind(lambda value: type(value) is int and value in read, right)


def whole(low: int, high: int, words: str = "") -> Kind:
    """A whole number in [low, high]."""
    right = words or f"a whole number in [{low}, {high}]"
    return Kind(lambda value: type(value) is int and low <= value <= high, right)


def real(low: float = -1e300, high: float = 1e300, words: str = "") -> Kind:
    """A finite number in [low, high]."""

    def test(value: Any) -> bool:
        return type(value) in (int, float) and low <= value <= high and math.isfinite(value)

    return Kind(test, words or f"a number in [{low:g}, {high:g}]")


def truth() -> Kind:
    """True or false."""
    return Kind(lambda value: isinstance(value, bool), "true or false")


def line(length: int, least: int = 1, words: str = "") -> Kind:
    """A line of at most so many printable characters."""

    def test(value: Any) -> bool:
        if not isinstance(value, str) or len(value) > length or not value.isprintable():
            return False
        return least == 0 or bool(value.strip())

    span = f"{least} to {length}" if least else f"at most {length}"
    return Kind(test, words or f"{span} printable characters")


def matching(pattern: str, words: str) -> Kind:
    """A text that a regular expression describes from its beginning to its end."""
    return Kind(lambda value: isinstance(value, str) and re.fullmatch(pattern, value) is not None, words)


HEX = matching("[0-9a-f]{64}", "64 hex digits")


def one_of(names: Iterable[str], words: str = "") -> Kind:
    """One of these names."""
    known = tuple(names)
    return Kind(lambda value: isinstance(value, str) and value in known, words or "one of " + ", ".join(known))


def table(words: str) -> Kind:
    """A table, whose fields have a schema of their own."""
    return Kind(lambda value: isinstance(value, dict), words)


def listed(low: int, high: int, words: str, of: Kind | None = None) -> Kind:
    """A list of `low` to `high` values, each of the kind `of` if one is given."""

    def test(value: Any) -> bool:
        return isinstance(value, list) and low <= len(value) <= high and (of is None or all(map(of.test, value)))

    return Kind(test, words)


def optional(kind: Kind, words: str = "") -> Kind:
    """Null, or a value of a kind."""
    return kind._replace(test=lambda value: value is None or kind.test(value), right=words or f"null, or {kind.right}")


def checked(
    file: str, where: str, value: Any, schema: Schema, error: type[ParamsError] = ParamsError
) -> dict[str, Any]:
    """The table itself, found to have the fields of a schema and no others.

    Parameters
    ----------
    file : str
        Named in the sentence.
    where : str
        Path of the table in the file; empty for the whole.
    value : object
        What the file holds there.
    schema : mapping
        Field -> kind.
    error : type
        What is raised.

    Raises
    ------
    ParamsError
        If anything else is there.
    """
    if not isinstance(value, dict):
        raise error(f"{file}: {where or 'the whole'} = {shown(value)} must be a table with {', '.join(schema)}")
    refuse_unknown(file, where, value, schema, error)
    for name, kind in schema.items():
        path = f"{where}.{name}" if where else name
        if name not in value:
            raise error(f"{file}: {path} is missing; it must be {kind.right}")
        if not kind.test(value[name]):
            raise error(f"{file}: {path} = {shown(value[name])} must be {kind.right}")
    return value


def refuse_unknown(
    file: str, where: str, value: Mapping[str, Any], known: Iterable[str], error: type[ParamsError] = ParamsError
) -> None:
    """Refuse a field that is not among those known, in a sentence with the nearest one."""
    names = list(known)
    for name in value:
        if name not in names:
            path = f"{where}.{name}" if where else name
            raise error(f"{file}: field {shown(path)} is unknown{suggestion(name[:NAME_MAX], names)}")
