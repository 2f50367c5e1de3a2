"""Functions that the tests of the translator translate: each holds a few constructs."""

from math import floor, isfinite, sqrt

import numpy as np

TABLE = np.array([0.5, 1.5, np.inf, -0.0])
WORDS = np.array([1, 2, 3], dtype=np.int64)
WIDE = np.uint64(0xD2511F53)
SMALL = 2.0**-32
POINT = np.dtype([("x", np.float64), ("n", np.int64), ("key", np.uint64), ("on", np.bool_), ("v", np.float64, (2, 3))])


def arithmetic(x, y):
    a, b = x + y, x - y
    a, b = b, a * 0.5
    c = -a / y if y != 0.0 else abs(x)
    return min(a, b, c), max(a, b), sqrt(abs(a)), c * SMALL


def whole(n, m):
    q, r = n // m, n % m
    return q, r, n >> 2, n & 3, (n | 1) - 5, int(-2.5), floor(n / m), -n, n / m


def bits(x):
    pattern = np.float64(x).view(np.int64)
    high = np.int64(pattern & -0x100000000).view(np.float64)
    return high, np.int64((pattern >> 52) & 2047), (1023 + int(floor(abs(x)) % 8)) << 52


def unsigned(key, n):
    word = (WIDE * (key & np.uint64(0xFFFFFFFF))) ^ np.uint64(n)
    low = word & np.uint64(0xFFFFFFFF)
    return word, np.float64(low) * SMALL, np.int64(low) & 255, TABLE[np.int64(low) & 3]


def loops(n):
    total, seen = 0.0, 0
    for i in range(n):
        if i % 3 == 0:
            continue
        for side in (-1.0, 1.0):
            total += side * i * i + TABLE[1]
        if i > 8:
            break
        seen = i
    else_ = 0
    while True:
        else_ += 1
        if else_ >= seen or not (0 <= else_ < 20):
            break
    for j in range(10, n, 4):
        total += j
    return total, seen, else_, i if n > 0 else 0


def records(point, rows):
    point.x, point.n, point.on = point.v[1, 2], 7.9, point.x > 1.0
    point.key = np.uint64(point.n)
    point.on |= point.x < 0.0
    point.v[0, 0] = point.v[0, 1] = point.x
    view = point.v[1]
    view[0] += 2.0
    rows[1, 1:] = 4.0
    rows[0, :] = point.x
    a, b = first(point.v)
    return a + b + len(rows) + rows.shape[1] + rows.size + view[0] + (1.0 if point.on else 0.0)


def first(v):
    return v[0, 0], v[1][0]


def nested(pairs, k):
    (a, b), c = pairs, pairs[1]
    return a[0] + b[k] * c[1] + c[k]


def versions(x, n):
    x = int(x)
    for i in range(n):
        j = np.uint64(i)
        x += int(np.float64(j))
    for j in range(n):
        x += j
    return x


def finite(x):
    return isfinite(x) and x == x, np.float32(x), np.ceil(x)


def function(var, this):
    new = var + this
    return new
