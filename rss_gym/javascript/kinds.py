"""What the translator knows of a value: its kind, and the JavaScript expression that gives it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np


class TranslationError(Exception):
    """Source that the translator does not know; the sentence names function, line and what stands there."""


class Kind:
    """Base of the kinds."""


@dataclass(frozen=True)
class Number(Kind):
    """A number of JavaScript, or a boolean: `name` is float, int (below 2^53) or bool."""

    name: str


@dataclass(frozen=True)
class Wide(Kind):
    """A whole number of 64 bits, a BigInt."""

    signed: bool


@dataclass(frozen=True)
class Record(Kind):
    """A record, an object with the fields of a dtype."""

    dtype: np.dtype


@dataclass(frozen=True)
class Array(Kind):
    """An array of numbers or records; the length of an axis is None where only the value knows it."""

    dtype: np.dtype
    shape: tuple[int | None, ...]


@dataclass(frozen=True)
class Tuple(Kind):
    """A tuple, an Array of JavaScript."""

    items: tuple[Kind, ...]


@dataclass(frozen=True)
class Named(Kind):
    """A named tuple, an object."""

    fields: tuple[tuple[str, Kind], ...]


@dataclass(frozen=True)
class Known(Kind):
    """A function, module or type: known when the program is translated, and no value of it."""

    value: Any


@dataclass(frozen=True)
class Lost(Kind):
    """What a name holds where two ways meet that keep it in different ways: nothing that may be read."""

    ways: str


@dataclass(frozen=True)
class Nothing(Kind):
    """What a function without a value returns."""


FLOAT, INT, BOOL, NOTHING = Number("float"), Number("int"), Number("bool"), Nothing()


@dataclass(frozen=True)
class Value:
    """An expression: its code in JavaScript, its kind, and what it is if that is known when it is translated."""

    code: str
    kind: Kind
    constant: int | float | None = None


def of_element(dtype: np.dtype) -> Kind:
    """Kind of an array's element or a record's field."""
    if dtype.subdtype is not None:
        return Array(dtype.subdtype[0], dtype.subdtype[1])
    if dtype.names is not None:
        return Record(dtype)
    kinds: dict[str, Kind] = {"f8": FLOAT, "f4": FLOAT, "i8": INT, "u8": Wide(False), "b1": BOOL}
    name = dtype.str[1:]
    if name not in kinds:
        raise TranslationError(f"values of type {dtype} are not known")
    return kinds[name]


def joined(one: Kind, two: Kind) -> Kind | None:
    """Kind of a value that has either kind; None if they are kept in different ways."""
    if one == two:
        return one
    if isinstance(one, Number) and isinstance(two, Number):
        return None if BOOL in (one, two) else FLOAT
    if isinstance(one, Array) and isinstance(two, Array) and one.dtype == two.dtype:
        if len(one.shape) != len(two.shape):
            return None
        return Array(one.dtype, tuple(a if a == b else None for a, b in zip(one.shape, two.shape, strict=True)))
    if isinstance(one, Tuple) and isinstance(two, Tuple) and len(one.items) == len(two.items):
        items = [joined(a, b) for a, b in zip(one.items, two.items, strict=True)]
        return None if None in items else Tuple(tuple(item for item in items if item is not None))
    return None


def described(kind: Kind) -> str:
    """A kind in a sentence."""
    if isinstance(kind, Number):
        return kind.name
    if isinstance(kind, Wide):
        return "int64 bits" if kind.signed else "uint64"
    if isinstance(kind, Array):
        return f"array {kind.shape} of {'records' if kind.dtype.names else kind.dtype}"
    if isinstance(kind, Known):
        return f"{getattr(kind.value, '__name__', kind.value)!r}"
    return type(kind).__name__.lower()
