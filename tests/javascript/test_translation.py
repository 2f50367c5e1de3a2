"""Every construct that the translator knows gives what Python gives; what it does not know it refuses by name."""

import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
import kernels
from translated import run, shown

from rss_gym.javascript import Program, TranslationError, fresh, kind_of, literal
from rss_gym.javascript.kinds import FLOAT, INT, Wide

CALLS = {
    "arithmetic": [(1.5, -2.25), (0.0, 0.0), (-0.0, 3.0), (1e300, 1e-300), (math.nan, 1.0), (math.inf, 2.0)],
    "loops": [(0,), (1,), (5,), (40,)],
    "versions": [(3.7, 4), (-3.7, 0)],
    "finite": [(1.25,), (math.inf,), (math.nan,), (0.1,)],
    "function": [(1.0, 2.0)],
}


@pytest.mark.parametrize("name", CALLS)
def test_as_python(name):
    function = getattr(kernels, name)
    if name == "loops":
        calls = CALLS[name][1:]  # without a turn Python has no `i`
    else:
        calls = CALLS[name]
    assert run(function, *calls) == [shown(function(*call)) for call in calls]


def test_whole_numbers_round_as_python_does():
    calls = [(7, 2), (-7, 2), (7, -2), (-8, 4), (0, 5), (123456789, 1000)]
    found = run(kernels.whole, *calls)
    assert found == [shown(kernels.whole(*call)) for call in calls]


def test_bits_of_doubles():
    found = run(kernels.bits, (1.5,), (-2.75e10,), (5e-324,))
    for (x,), (high, exponent, word) in zip([(1.5,), (-2.75e10,), (5e-324,)], found, strict=True):
        expected = kernels.bits(x)
        assert high == shown(float(expected[0]))
        assert (int(exponent), int(word)) == (int(expected[1]), int(expected[2]))


def test_unsigned_words_wrap():
    keys = [np.uint64(0), np.uint64(2**64 - 1), np.uint64(0x123456789ABCDEF)]
    found = run(kernels.unsigned, *[(key, 9) for key in keys])
    for key, (word, share, low, entry) in zip(keys, found, strict=True):
        expected = kernels.unsigned(key, 9)
        assert (int(word), int(low)) == (int(expected[0]), int(expected[2]))
        assert (share, entry) == (shown(float(expected[1])), shown(float(expected[3])))


def point():
    records = np.rec.array(np.zeros(1, kernels.POINT))
    records["v"] = np.arange(6.0).reshape(2, 3)
    records["x"] = 3.0
    return records[0]


def test_records_and_views_change_in_place():
    fields = "[$args[0].x, $args[0].n, $args[0].key, $args[0].on, [...$args[0].v], [...$args[1]]]"
    one, rows = point(), np.ones((2, 3))
    changed, returned = run(kernels.records, (one, rows), after=f"$results.push({fields}.map($shown));")
    assert returned == shown(float(kernels.records(one, rows)))
    assert changed == [
        shown(float(one.x)), shown(7.0), "7", shown(bool(one.on)),
        shown(one.v.ravel().tolist()), shown(rows.ravel().tolist()),
    ]  # fmt: skip


def test_tuples_in_tuples():
    pairs = ((1.0, 2.0), (3.0, 4.0))
    assert run(kernels.nested, (pairs, 0), (pairs, 1)) == [shown(kernels.nested(pairs, k)) for k in (0, 1)]


def test_literals_and_zeros():
    assert literal(-0.0) == "(-0.0)" and literal(math.inf) == "Infinity" and literal(True) == "true"
    assert literal(np.uint64(2**64 - 1)) == "0xffffffffffffffffn"
    assert literal(np.array([True, False])) == "Uint8Array.of(1, 0)"
    assert fresh(np.dtype(np.float64), (2, 3)) == "new Float64Array(6)"
    assert "key: 0x0n" in fresh(kernels.POINT, (2,)) and "v: new Float64Array(6)" in fresh(kernels.POINT, (2,))
    with pytest.raises(TranslationError, match="str"):
        kind_of("text")


# -- what is refused --------------------------------------------------------------------------------------------------


def power(x, y):
    return x**y


def lists(x, y):
    return [x, y]


def handled(x, y):
    try:
        return x
    finally:
        pass


def float_remainder(x, y):
    return x % y


def keyword(x, y):
    return max(x, y, key=abs)


def unknown_function(x, y):
    return math.sin(x)


def unknown_name(x, y):
    return x + nowhere  # noqa: F821


def valued_or(x, y):
    return x or y


def recursive(x, y):
    return recursive(x, y)


def two_kinds(x, y):
    if x > y:
        z = (x, y)
    else:
        z = x
    return z


def from_the_end(x, y):
    return kernels.TABLE[-1]


def text(x, y):
    return "no"


def two_returns(x, y):
    if x > y:
        return x
    return x, y


@pytest.mark.parametrize(
    ("function", "what"),
    [
        (power, r"\*\* is known for constants"), (lists, "List"), (handled, "Try"), (float_remainder, "% is known"),
        (keyword, "by keyword"), (unknown_function, "'sin'"), (unknown_name, "'nowhere'"), (valued_or, "and, or"),
        (recursive, "calls itself"), (two_kinds, "'z' is tuple or float"), (from_the_end, "negative indices"),
        (text, "'no'"), (two_returns, "returns float or tuple"),
    ],
)  # fmt: skip
def test_unknown_constructs_are_refused(function, what):
    with pytest.raises(TranslationError, match=what) as caught:
        Program().add(function, [FLOAT, FLOAT])
    if function is not two_returns:
        line = re.search(r"line (\d+)", str(caught.value))
        assert line and abs(int(line[1]) - function.__code__.co_firstlineno) < 6


def test_mixed_signs_are_refused():
    def mixed(a, b):
        return a + b

    with pytest.raises(TranslationError, match="Numba makes a float of it"):
        Program().add(mixed, [Wide(False), INT])


def test_only_what_is_called_is_written():
    program = Program()
    program.add(kernels.function, [FLOAT, FLOAT])
    assert "kernels_function" in program.code and "kernels_first" not in program.code
    assert "var$" in program.code and "this$" in program.code
