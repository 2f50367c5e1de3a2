"""Elements and views of arrays and tuples."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rss_gym.javascript.arithmetic import as_number
from rss_gym.javascript.kinds import (
    BOOL,
    INT,
    Array,
    Number,
    TranslationError,
    Tuple,
    Value,
    Wide,
    described,
    joined,
    of_element,
)


@dataclass(frozen=True)
class Slice:
    """`start:stop` in an index; None where it is left out."""

    start: Value | None = None
    stop: Value | None = None


def length(array: Value, axis: int = 0) -> Value:
    """Length of an axis."""
    if isinstance(array.kind, Tuple) and axis == 0:
        return Value(str(len(array.kind.items)), INT, len(array.kind.items))
    if not isinstance(array.kind, Array) or axis >= len(array.kind.shape):
        raise TranslationError(f"{described(array.kind)} has no length along axis {axis}")
    known = array.kind.shape[axis]
    if known is not None:
        return Value(str(known), INT, known)
    return Value(f"{array.code}.length" if len(array.kind.shape) == 1 else f"{array.code}.shape[{axis}]", INT)


def size(array: Value) -> Value:
    """Number of elements."""
    kind = array.kind
    if not isinstance(kind, Array):
        raise TranslationError(f"{described(kind)} has no size")
    known = [n for n in kind.shape if n is not None]
    if len(known) == len(kind.shape):
        return Value(str(math.prod(known)), INT, math.prod(known))
    return Value(f"{array.code}.length", INT)


def place(index: Value) -> Value:
    """A whole number as an index; those below zero, which Python counts from the end, are refused if constant."""
    if not (isinstance(index.kind, Wide) or index.kind == INT):
        raise TranslationError(f"{described(index.kind)} is no index")
    if index.constant is not None and index.constant < 0:
        raise TranslationError("negative indices are not known")
    return as_number(index)


def element_of_tuple(value: Value, index: Value) -> Value:
    """One item of a tuple; by an index that varies only where all items are of one kind."""
    assert isinstance(value.kind, Tuple)
    at, items = place(index), value.kind.items
    if at.constant is not None:
        if at.constant >= len(items):
            raise TranslationError(f"index {at.constant} is beyond a tuple of {len(items)}")
        return Value(f"{value.code}[{at.constant}]", items[int(at.constant)])
    kind = items[0] if items else None
    for item in items[1:]:
        kind = joined(kind, item) if kind is not None else None
    if kind is None:
        raise TranslationError("an index that varies needs a tuple of items of one kind")
    return Value(f"{value.code}[{at.code}]", kind)


def offset(array: Value, indices: list[Value]) -> str:
    """Code of where an element, or the view that the first indices choose, begins."""
    assert isinstance(array.kind, Array)
    terms = []
    for axis, index in enumerate(indices):
        at, rest = place(index), range(axis + 1, len(array.kind.shape))
        strides = [length(array, after) for after in rest]
        stride = math.prod(int(step.constant) for step in strides if step.constant is not None)
        open_ = [step.code for step in strides if step.constant is None]
        if at.constant is not None and not open_:
            if at.constant * stride:
                terms.append(str(int(at.constant) * stride))
            continue
        factors = [at.code, *([str(stride)] if stride != 1 else []), *open_]
        terms.append(" * ".join(factors))
    return " + ".join(terms) or "0"


def element(array: Value, indices: list[Value]) -> Value:
    """One element, or the view of the rest where axes are left over."""
    kind = array.kind
    assert isinstance(kind, Array)
    if len(indices) > len(kind.shape):
        raise TranslationError(f"{len(indices)} indices for {described(kind)}")
    at = offset(array, indices)
    if len(indices) == len(kind.shape):
        code, found = f"{array.code}[{at}]", of_element(kind.dtype)
        return Value(f"({code} !== 0)" if found == BOOL else code, found)
    rest = kind.shape[len(indices) :]
    if None in rest and len(rest) > 1:
        raise TranslationError("a view with an axis of unknown length is not known")
    whole = str(math.prod(size for size in rest if size is not None))
    count = length(Value(array.code, kind), len(kind.shape) - 1).code if None in rest else whole
    part = "slice" if kind.dtype.names else "subarray"
    start = at if at.isdigit() else f"({at})"
    return Value(f"{array.code}.{part}({start}, {start} + {count})", Array(kind.dtype, rest))


def view(array: Value, indices: list[Value], slices: list[Slice]) -> tuple[Value, Slice]:
    """The view that leading indices choose, and the one slice of its only axis, or of all its axes."""
    kind = array.kind
    if not isinstance(kind, Array) or kind.dtype.names is not None:
        raise TranslationError(f"slices of {described(kind)} are not known")
    whole = all(part.start is None and part.stop is None for part in slices)
    if len(indices) + len(slices) > len(kind.shape):
        raise TranslationError(f"{len(indices) + len(slices)} indices for {described(kind)}")
    base = element(array, indices) if indices else array
    if whole:
        return base, Slice()
    assert isinstance(base.kind, Array)
    if len(base.kind.shape) != 1:
        raise TranslationError("slices of several axes are known as whole axes only")
    return base, slices[0]


def bounds(array: Value, part: Slice) -> list[str]:
    """Code of the start, and of the stop if there is one, of a slice."""
    start = place(part.start).code if part.start else "0"
    return [start, *([place(part.stop).code] if part.stop else [])]


def sliced(array: Value, part: Slice) -> Value:
    """A view of a stretch of an array."""
    kind = array.kind
    assert isinstance(kind, Array)
    if part.start is None and part.stop is None:
        return array
    return Value(f"{array.code}.subarray({', '.join(bounds(array, part))})", Array(kind.dtype, (None,)))


def is_of_numbers(kind: Array) -> bool:
    """Whether the elements are numbers, not records."""
    return isinstance(of_element(np.dtype(kind.dtype)), (Number, Wide))
