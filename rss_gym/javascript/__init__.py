"""Translates the package's compiled kernels to JavaScript, from the same source and with the same bits.

A kernel is a Python function of numbers, arrays and records that Numba compiles. `Program` reads its source and writes
a JavaScript function that does the same operations in the same order. Both are IEEE 754 doubles without fused or
reordered operations, so both give the same bits. What the translator does not know it refuses, by name and line.

How values are kept:

===================================  =============================================
Python, as Numba types it            JavaScript
===================================  =============================================
float64, and int64 below 2^53        number
uint64, and int64 that holds bits    BigInt
bool                                 boolean; in an array, 0 or 1
array of float64, of int64           Float64Array, row by row
array of float32, uint64, bool       Float32Array, BigUint64Array, Uint8Array
record                               object; its arrays as above
array of records                     Array of objects, row by row
tuple                                Array
===================================  =============================================
"""

from rss_gym.javascript.kinds import TranslationError
from rss_gym.javascript.program import Program
from rss_gym.javascript.values import fresh, kind_of, literal

__all__ = ["Program", "TranslationError", "fresh", "kind_of", "literal"]
