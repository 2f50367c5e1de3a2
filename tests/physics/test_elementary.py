"""Elementary functions against mpmath, and that no library function is called."""

import math
import re

import mpmath
import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.physics import elementary

mpmath.mp.dps = 50

INF = math.inf
NAN = math.nan
ONE_ARGUMENT = ("log", "log10", "exp", "sin", "cos", "tanh")
TINY = 5e-324
JIT = not numba.config.DISABLE_JIT


def _relative_error(value, exact):
    if exact == 0:
        return abs(value)
    return float(abs((mpmath.mpf(float(value)) - exact) / exact))


def _worst(name, points):
    function, exact = getattr(elementary, name), getattr(mpmath, name)
    return max(_relative_error(function(float(x)), exact(mpmath.mpf(float(x)))) for x in points)


def _points(name):
    rng = np.random.default_rng(20240601)
    n = 4000
    signs = rng.choice([-1.0, 1.0], n)
    if name in ("log", "log10"):
        edges = [TINY, 2.0**-1022, 2.0**-1023, 1.7976931348623157e308]
        edges += [10.0**k for k in range(-300, 301, 25)]
        edges += [math.nextafter(1, 0), math.nextafter(1, 2), math.sqrt(0.5), math.sqrt(2)]
        return [*(10.0 ** rng.uniform(-307, 308, n)), *rng.uniform(0.5, 2, n), *edges]
    if name == "exp":
        return [*rng.uniform(-708, 709.78, n), *rng.uniform(-1, 1, n), 709.782712893384]
    if name in ("sin", "cos"):
        # The float64 nearest to a multiple of pi/2 is the hardest to reduce.
        hard = [float(k * mpmath.pi / 2) for k in range(1, 6367)]
        small = signs * 10.0 ** rng.uniform(-300, 0, n)
        return [*rng.uniform(-1e4, 1e4, n), *rng.uniform(-4, 4, n), *hard, *small]
    small = signs * 10.0 ** rng.uniform(-300, 0, n)
    return [*rng.uniform(-25, 25, n), *rng.uniform(-1, 1, n), *small, 0.625, 22.0]


@pytest.mark.parametrize("name", ONE_ARGUMENT)
def test_relative_error(name):
    assert _worst(name, _points(name)) < 4e-16


@pytest.mark.parametrize("name", ("sin", "cos"))
def test_angles_up_to_a_million(name):
    hard = [float(k * mpmath.pi / 2) for k in range(6367, 636619, 101)]
    assert _worst(name, hard) < 4e-16


def test_exp_of_subnormal_results():
    for x in np.linspace(-745.1, -708.5, 500):
        error = mpmath.mpf(float(elementary.exp(x))) - mpmath.exp(mpmath.mpf(float(x)))
        assert abs(error) <= 1.01 * TINY + 4e-16 * math.exp(x)


def test_atan2_relative_error():
    rng = np.random.default_rng(7)
    n = 8000
    y = rng.normal(size=n) * 10.0 ** rng.uniform(-6, 6, n)
    x = rng.normal(size=n) * 10.0 ** rng.uniform(-6, 6, n)
    ratio = np.concatenate([rng.uniform(0.3, 3, n), [1.0, math.tan(math.pi / 8)]])
    pairs = [*zip(y, x, strict=True), *((r, s) for r in ratio for s in (1.0, -1.0))]
    pairs += [(1e308, 1.5e308), (TINY, 1e-320), (1e308, -1e-308), (3e-310, -4e-310)]
    for b, a in pairs:
        exact = mpmath.atan2(mpmath.mpf(float(b)), mpmath.mpf(float(a)))
        assert _relative_error(elementary.atan2(b, a), exact) < 4e-16, (b, a)


@pytest.mark.parametrize(
    ("name", "x", "expected"),
    [
        *((n, 0.0, -INF) for n in ("log", "log10")),
        *((n, -0.0, -INF) for n in ("log", "log10")),
        *((n, x, NAN) for n in ("log", "log10") for x in (-TINY, -1.0, -INF, NAN)),
        *((n, INF, INF) for n in ("log", "log10")),
        *((n, 1.0, 0.0) for n in ("log", "log10")),
        ("exp", 0.0, 1.0),
        ("exp", -0.0, 1.0),
        ("exp", 709.79, INF),
        ("exp", INF, INF),
        ("exp", -745.14, 0.0),
        ("exp", -INF, 0.0),
        ("exp", NAN, NAN),
        *((n, x, NAN) for n in ("sin", "cos") for x in (1.1e6, -1.1e6, INF, -INF, NAN)),
        ("sin", 0.0, 0.0),
        ("sin", -0.0, -0.0),
        ("sin", TINY, TINY),
        ("cos", -0.0, 1.0),
        ("tanh", 0.0, 0.0),
        ("tanh", -0.0, -0.0),
        ("tanh", TINY, TINY),
        ("tanh", 23.0, 1.0),
        ("tanh", INF, 1.0),
        ("tanh", -INF, -1.0),
        ("tanh", NAN, NAN),
    ],
)
def test_special_values(name, x, expected):
    value = getattr(elementary, name)(x)
    if math.isnan(expected):
        assert math.isnan(value)
    else:
        assert _bits(value) == _bits(expected)


def test_exact_powers_of_ten():
    assert [elementary.log10(10.0**k) for k in range(-5, 23)] == list(range(-5, 23))


def test_atan2_special_values():
    values = [0.0, -0.0, 1.0, -1.0, INF, -INF, NAN]
    for y in values:
        for x in values:
            ours, theirs = elementary.atan2(y, x), math.atan2(y, x)
            assert math.copysign(1, ours) == math.copysign(1, theirs) or math.isnan(theirs)
            assert ours == pytest.approx(theirs, rel=3e-16, abs=0, nan_ok=True)


def _bits(value):
    return np.float64(value).view(np.int64)


any_float = st.floats(allow_nan=False)
angles = st.floats(-1e4, 1e4)


@given(st.floats(1e-300, 1e300))
def test_log_inverts_exp(x):
    assert elementary.exp(elementary.log(x)) == pytest.approx(x, rel=2e-13)
    assert elementary.log10(x) == pytest.approx(elementary.log(x) / math.log(10), rel=1e-15)


@given(st.floats(min_value=TINY, allow_infinity=False))
def test_log_grows(x):
    for log in (elementary.log, elementary.log10):
        assert log(x) <= log(x * 1.0000000000001) or x < 1e-300


@given(angles)
def test_sine_and_cosine(x):
    s, c = elementary.sin(x), elementary.cos(x)
    assert s * s + c * c == pytest.approx(1, abs=5e-16)
    assert elementary.sin(-x) == -s
    assert elementary.cos(-x) == c


@given(any_float, any_float)
def test_atan2_symmetries(y, x):
    angle = elementary.atan2(y, x)
    assert elementary.atan2(-y, x) == -angle
    assert -math.pi <= angle <= math.pi
    assert abs(angle) + abs(elementary.atan2(y, -x)) == pytest.approx(math.pi, rel=4e-16)


@given(any_float)
def test_tanh_is_odd_and_bounded(x):
    assert elementary.tanh(-x) == -elementary.tanh(x)
    assert abs(elementary.tanh(x)) <= 1


@pytest.mark.skipif(not JIT, reason="nothing is compiled")
@given(any_float, any_float)
def test_compiled_equals_plain_python(x, y):
    for name in ONE_ARGUMENT:
        function = getattr(elementary, name)
        with np.errstate(all="ignore"):
            plain = function.py_func(x)
        compiled = function(x)
        assert _bits(compiled) == _bits(plain) or (math.isnan(compiled) and math.isnan(plain))
    assert _bits(elementary.atan2(y, x)) == _bits(elementary.atan2.py_func(y, x))


@pytest.mark.skipif(not JIT, reason="nothing is compiled")
def test_vectorised_loop_equals_scalar_call():
    x = np.random.default_rng(3).uniform(1e-3, 20.0, 1003)
    for name in ONE_ARGUMENT:
        function = getattr(elementary, name)
        out = np.empty_like(x)
        _loop_of(function)(x, out)
        assert np.array_equal(out, [function(v) for v in x])


def _loop_of(function):
    @numba.njit(error_model="numpy")
    def loop(x, out):
        for i in range(x.size):
            out[i] = function(x[i])

    return loop


LIBRARY = re.compile(
    r"^(llvm\.)?(log|log10|log2|log1p|exp|exp2|exp10|expm1|sin|cos|sincos|tan|atan|atan2"
    r"|sinh|cosh|tanh|pow|powi|fma|fmuladd|ldexp|frexp|fmod|rint|round|floor|hypot)f?\b"
)
FUSED = re.compile(r"\bv?fn?m(?:add|sub|addsub|subadd|la|ls)\w*\b")


def _library_calls(loop):
    """External functions declared in the code of a loop, and fused operations."""
    loop.compile("void(float64[::1], float64[::1])")
    (ir,) = loop.inspect_llvm().values()
    (asm,) = loop.inspect_asm().values()
    declared = re.findall(r'^declare [^@\n]*@"?([\w.$]+)"?\(', ir, re.MULTILINE)
    return [n for n in declared if LIBRARY.match(n)] + FUSED.findall(asm)


@pytest.mark.skipif(not JIT, reason="nothing is compiled")
def test_the_search_finds_library_calls():
    assert "log10" in " ".join(_library_calls(_loop_of(math.log10)))
    assert "tanh" in " ".join(_library_calls(_loop_of(math.tanh)))


@pytest.mark.skipif(not JIT, reason="nothing is compiled")
@pytest.mark.parametrize("name", [*ONE_ARGUMENT, "atan2"])
def test_no_library_call_and_no_fused_operation(name):
    function = getattr(elementary, name)
    if name == "atan2":

        @numba.njit(error_model="numpy")
        def loop(x, out):
            for i in range(x.size):
                out[i] = function(x[i], out[i])

    else:
        loop = _loop_of(function)
    assert _library_calls(loop) == []
