"""Values of Python and NumPy as JavaScript: their kinds, as literals, and zeroed arrays and records."""

from __future__ import annotations

import base64
import math
from typing import Any

import numpy as np

from rss_gym.javascript.kinds import BOOL, FLOAT, INT, Array, Kind, Named, Record, TranslationError, Tuple, Wide

EXACT = 2**53  # whole numbers below it are doubles
TYPED = {"f8": "Float64Array", "f4": "Float32Array", "i8": "Float64Array", "u8": "BigUint64Array", "b1": "Uint8Array"}
PACKED = 64  # numbers from which an array is written in base 64


def typed(dtype: np.dtype) -> str:
    """Class of the array of JavaScript that holds numbers of a dtype."""
    name = dtype.str[1:]
    if name not in TYPED:
        raise TranslationError(f"arrays of {dtype} are not known")
    return TYPED[name]


def kind_of(value: Any) -> Kind:
    """Kind of a value of Python or NumPy."""
    if isinstance(value, (bool, np.bool_)):
        return BOOL
    if isinstance(value, np.uint64):
        return Wide(False)
    if isinstance(value, (int, np.int64)):
        return INT if abs(int(value)) < EXACT else Wide(True)
    if isinstance(value, float):  # np.float64 is one
        return FLOAT
    if isinstance(value, np.ndarray):
        return Array(value.dtype, value.shape)
    if isinstance(value, np.void):
        return Record(value.dtype)
    if isinstance(value, tuple):
        kinds = tuple(kind_of(item) for item in value)
        names = getattr(value, "_fields", None)
        return Named(tuple(zip(names, kinds, strict=True))) if names else Tuple(kinds)
    raise TranslationError(f"values of type {type(value).__name__} are not known")


def literal(value: Any) -> str:
    """The expression that gives a value; a new object at each evaluation."""
    kind = kind_of(value)
    if kind == BOOL:
        return "true" if value else "false"
    if isinstance(kind, Wide):
        return f"{hex(int(value))}n" if value >= 0 else f"(-{hex(-int(value))}n)"
    if kind == INT:
        return str(int(value)) if value >= 0 else f"({int(value)})"
    if kind == FLOAT:
        return of_float(float(value))
    if isinstance(kind, Record):
        return "{" + ", ".join(f"{name}: {literal(value[name])}" for name in value.dtype.names) + "}"
    if isinstance(kind, Named):
        return "{" + ", ".join(f"{name}: {literal(getattr(value, name))}" for name, _ in kind.fields) + "}"
    if isinstance(kind, Tuple):
        return "[" + ", ".join(map(literal, value)) + "]"
    return of_array(value)


def of_float(value: float) -> str:
    """A float64, exactly."""
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "Infinity" if value > 0 else "(-Infinity)"
    return repr(value) if math.copysign(1.0, value) > 0 else f"({value!r})"


def of_array(value: np.ndarray) -> str:
    """An array; long ones of floats in base 64, as float32 where those hold the same values."""
    if value.dtype.names is not None:
        return "[" + ", ".join(literal(item) for item in value.ravel()) + "]"
    if value.dtype == np.float64 and value.size >= PACKED:
        narrow = value.astype("<f4")
        same = np.array_equal(narrow.astype(np.float64), value)
        raw = (narrow if same else value.astype("<f8")).tobytes()
        code = f'$unpacked("{base64.b64encode(raw).decode()}", {"Float32Array" if same else "Float64Array"})'
    else:
        code = f"{typed(value.dtype)}.of({', '.join(_item(item) for item in value.ravel())})"
    return code if value.ndim < 2 else f"$shaped({code}, {list(value.shape)})"


def _item(item: Any) -> str:
    return str(int(item)) if isinstance(item, np.bool_) else literal(item)


def fresh(dtype: np.dtype, shape: tuple[int, ...]) -> str:
    """The expression that gives a new array of zeros; of records too."""
    count = math.prod(shape)
    if dtype.names is None:
        return f"new {typed(dtype)}({count})"
    return f"Array.from({{length: {count}}}, () => ({fresh_record(dtype)}))"


def fresh_record(dtype: np.dtype) -> str:
    """The expression that gives a new record of zeros."""
    fields = []
    for name in dtype.names or ():
        part = dtype[name]
        if part.subdtype is not None:
            fields.append(f"{name}: {fresh(*part.subdtype)}")
        elif part.names is not None:
            fields.append(f"{name}: {fresh_record(part)}")
        else:
            fields.append(f"{name}: {literal(np.zeros((), part)[()])}")
    return "{" + ", ".join(fields) + "}"
