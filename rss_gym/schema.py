"""What the fields of a file and the parameters of a call may hold: each has a kind, which says what would be right.

A schema is a mapping from the name of a field to its kind. `checked` finds a table of a file to have these fields and
no others; its one sentence names file, field, value and what would be right, and the nearest name where one is unknown.
`argument` does the same for one value that a caller gives.
"""

from __future__ import annotations

import numbers
import re
import reprlib
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from rss_gym.errors import ParamsError, suggestion

NAME_MAX = 200  # characters of a name that are compared with the known ones


class Kind(NamedTuple):
    """What one value may be.

    Attributes
    ----------
    test : callable
        Whether a value is of this kind.
    right : str
        The words for what is.
    known : callable, optional
        The names, where it is one of some: called when they are needed.
    plain : callable
        Makes of a value of this kind the one that is kept: of NumPy's scalars those of Python.
    """

    test: Callable[[Any], bool]
    right: str
    known: Callable[[], Iterable[str]] | None = None
    plain: Callable[[Any], Any] = lambda value: value


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
    kind: Any = numbers.Integral  # NumPy's scalars too, as a sweep hands them over

    def test(value: Any) -> bool:
        return isinstance(value, kind) and not isinstance(value, bool) and low <= value <= high

    return Kind(test, words or f"a whole number in [{low}, {high}]", plain=int)


def real(low: float = -1e300, high: float = 1e300, words: str = "") -> Kind:
    """A finite number in [low, high]."""
    kind: Any = numbers.Real

    def test(value: Any) -> bool:  # NaN is in no range
        return isinstance(value, kind) and not isinstance(value, bool) and bool(low <= value <= high)

    return Kind(test, words or f"a number in [{low:g}, {high:g}]", plain=float)


def truth() -> Kind:
    """True or false."""
    return Kind(lambda value: isinstance(value, (bool, np.bool_)), "true or false", plain=bool)


def text() -> Kind:
    """Any text."""
    return Kind(lambda value: isinstance(value, str), "a text")


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
    right = words or "one of " + ", ".join(known)
    return Kind(lambda value: isinstance(value, str) and value in known, right, lambda: known)


def table(words: str) -> Kind:
    """A table, whose fields have a schema of their own."""
    return Kind(lambda value: isinstance(value, dict), words)


def listed(low: int, high: int, words: str, of: Kind | None = None) -> Kind:
    """A list of `low` to `high` values, each of the kind `of` if one is given."""

    def test(value: Any) -> bool:
        whole = isinstance(value, (list, tuple)) and low <= len(value) <= high
        return whole and (of is None or all(map(of.test, value)))

    return Kind(test, words)


def optional(kind: Kind, words: str = "") -> Kind:
    """Null, or a value of a kind."""

    def plain(value: Any) -> Any:
        return None if value is None else kind.plain(value)

    right = words or f"null, or {kind.right}"
    return kind._replace(test=lambda value: value is None or kind.test(value), right=right, plain=plain)


def checked(
    file: str, where: str, value: Any, schema: Schema, error: type[ParamsError] = ParamsError
) -> dict[str, Any]:
    """The table itself, found to have the fields of a schema and no others.

    Parameters
    ----------
    file : str
        Named first in the sentence; empty where the caller names it.
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
    first = f"{file}: " if file else ""
    if not isinstance(value, dict):
        raise error(f"{first}{where or 'the whole'} = {shown(value)} must be a table with {', '.join(schema)}")
    refuse_unknown(file, where, value, schema, error)
    for name, kind in schema.items():
        path = f"{where}.{name}" if where else name
        if name not in value:
            raise error(f"{first}{path} is missing; it must be {kind.right}")
        if not kind.test(value[name]):
            unknown = unknown_name(path, value[name], kind)
            raise error(f"{first}{unknown or f'{path} = {shown(value[name])} must be {kind.right}'}")
    return value


def argument(name: str, value: Any, kind: Kind) -> Any:
    """The value that a caller gives, found to be of a kind, as it is kept.

    Raises
    ------
    ParamsError
        If it is of another.
    """
    if not kind.test(value):
        raise ParamsError(unknown_name(name, value, kind) or f"{name} must be {kind.right}, got {shown(value)}")
    return kind.plain(value)


def unknown_name(path: str, value: Any, kind: Kind) -> str:
    """The sentence about a name that is not among the known ones; empty where something else is wrong."""
    if kind.known is None or not isinstance(value, str):
        return ""
    return f"{path} = {shown(value)} is unknown{suggestion(value[:NAME_MAX], kind.known())}"


def refuse_unknown(
    file: str, where: str, value: Mapping[str, Any], known: Iterable[str], error: type[ParamsError] = ParamsError
) -> None:
    """Refuse a field that is not among those known, in a sentence with the nearest one."""
    names = list(known)
    for name in value:
        if name not in names:
            path = f"{where}.{name}" if where else name
            first = f"{file}: " if file else ""
            raise error(f"{first}field {shown(path)} is unknown{suggestion(name[:NAME_MAX], names)}")
