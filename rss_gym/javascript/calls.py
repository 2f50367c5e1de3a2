"""Functions of Python, `math` and NumPy that kernels call, as JavaScript."""

from __future__ import annotations

import builtins
import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from rss_gym.javascript.arithmetic import as_bigint, as_number, truth, wrapped
from rss_gym.javascript.arrays import length
from rss_gym.javascript.kinds import BOOL, FLOAT, INT, Array, Number, TranslationError, Value, Wide, described


def _by_name(name: str) -> Callable[..., Value]:
    def call(x: Value) -> Value:
        return Value(f"{name}({as_number(x).code})", FLOAT)

    return call


def _least(name: str) -> Callable[..., Value]:
    def call(*values: Value) -> Value:
        if len(values) < 2:
            raise TranslationError("min and max are known for two numbers and more")
        numbers = [as_number(value) for value in values]
        code = functools.reduce(lambda a, b: f"{name}({a}, {b})", [number.code for number in numbers])
        return Value(code, INT if all(number.kind == INT for number in numbers) else FLOAT)

    return call


def _size_of(x: Value) -> Value:
    if isinstance(x.kind, Wide):
        return Value(f"$abs({x.code})", x.kind)
    number = as_number(x)
    return Value(f"Math.abs({number.code})", number.kind)


def _whole(x: Value) -> Value:
    """`int(x)` and `np.int64(x)`."""
    if isinstance(x.kind, Wide):
        return x if x.kind.signed else Value(wrapped(x.code, Wide(True)), Wide(True))
    number = as_number(x)
    return Value(f"(Math.trunc({number.code}) + 0)", INT) if number.kind == FLOAT else number  # + 0: no negative zero


def _unsigned(x: Value) -> Value:
    if x.kind == Wide(False):
        return x
    whole = _whole(x)
    if whole.constant is not None and whole.constant >= 0:
        return Value(f"{int(whole.constant)}n", Wide(False))
    return Value(wrapped(as_bigint(whole), Wide(False)), Wide(False))


def _float(x: Value) -> Value:
    number = as_number(x)
    return Value(number.code, FLOAT, None if number.constant is None else float(number.constant))


def _narrow(x: Value) -> Value:
    return Value(f"Math.fround({as_number(x).code})", FLOAT)


def _floor(x: Value) -> Value:
    """`math.floor`, a whole number, which has no negative zero."""
    return Value(f"(Math.floor({as_number(x).code}) + 0)", INT)


def _new(count: Value) -> Value:
    if count.kind != INT:
        raise TranslationError("np.empty and np.zeros are known for one axis of float64")
    return Value(f"new Float64Array({count.code})", Array(np.dtype(np.float64), (_known(count),)))


def _known(count: Value) -> int | None:
    return None if count.constant is None else int(count.constant)


FUNCTIONS: dict[Any, Callable[..., Value]] = {
    math.sqrt: _by_name("Math.sqrt"),
    np.sqrt: _by_name("Math.sqrt"),
    math.floor: _floor,
    np.floor: _by_name("Math.floor"),
    np.ceil: _by_name("Math.ceil"),
    builtins.min: _least("$min"),
    builtins.max: _least("$max"),
    builtins.abs: _size_of,
    builtins.int: _whole,
    np.int64: _whole,
    np.uint64: _unsigned,
    builtins.float: _float,
    np.float64: _float,
    np.float32: _narrow,
    builtins.bool: lambda x: Value(truth(x), BOOL),
    math.isfinite: lambda x: Value(f"Number.isFinite({as_number(x).code})", BOOL),
    np.isfinite: lambda x: Value(f"Number.isFinite({as_number(x).code})", BOOL),
    builtins.len: length,
    np.empty: _new,
    np.zeros: _new,
}


def is_known(function: Any) -> bool:
    """Whether this is one of the functions above."""
    try:
        return function in FUNCTIONS
    except TypeError:  # of what has no hash
        return False


def reinterpreted(value: Value, to: Any) -> Value:
    """`value.view(to)`: the same 64 bits as another type."""
    if to is np.float64 and isinstance(value.kind, Wide):
        return Value(f"$double({value.code})", FLOAT)
    if to is np.int64 and value.kind == FLOAT:
        return Value(f"$bits({value.code})", Wide(True))
    if (to is np.int64 and value.kind == INT) or not isinstance(value.kind, (Number, Wide)):
        raise TranslationError(f"{described(value.kind)} has no view")
    raise TranslationError(f"a view of {described(value.kind)} as {getattr(to, '__name__', to)} is not known")
