"""Elementary functions built from IEEE 754 basic operations only.

The mathematics library differs between systems in the last bits, and with it
every trajectory.  These functions use addition, multiplication, division and
bit casts, which IEEE 754 fixes exactly, so they give the same bits on every
machine, compiled or as plain Python.  Relative errors are below 4e-16 wherever
the result is a normal number (sine and cosine: for angles up to 1e6).

Reductions and polynomial coefficients of ``log``, ``log10``, ``exp``, ``sin``,
``cos`` and the arctangent are those of FDLIBM 5.3 (``e_log.c``, ``e_log10.c`` as
in FreeBSD's msun, ``e_exp.c``, ``k_sin.c``, ``k_cos.c``, ``e_rem_pio2.c``,
``s_atan.c``), with the notice:

    Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
    Permission to use, copy, modify, and distribute this software is freely
    granted, provided that this notice is preserved.

The rational approximation of ``tanh`` near zero is that of Cody and Waite,
"Software Manual for the Elementary Functions", 1980, chapter 13.
"""

import numpy as np

from rss_gym.jit import kernel

__all__ = ["atan2", "cos", "exp", "log", "log10", "sin", "tanh"]

_INF = float("inf")
_NAN = float("nan")
_SMALLEST_NORMAL = 2.0**-1022

# Bit patterns of float64, as int64.
_FRACTION = 0x000FFFFFFFFFFFFF
_ONE = 0x3FF0000000000000
_ROOT_HALF = 0x3FE6A09E667F3BCD
_SIGN = -0x8000000000000000
_HIGH_WORD = -0x100000000
# Integers 0 .. 2**52 - 1 or-ed into the fraction of 2**52 read as 2**52 + n.
_TWO52 = 0x4330000000000000
_TWO52_PLUS_BIAS = 2.0**52 + 1023.0
# Adding and subtracting this rounds to the nearest integer.
_ROUND = 1.5 * 2.0**52

_LN2_HIGH = 6.93147180369123816490e-01
_LN2_LOW = 1.90821492927058770002e-10
_INV_LN2 = 1.44269504088896338700e00
_INV_LN10_HIGH = 4.34294481878168880939e-01
_INV_LN10_LOW = 2.50829467116452752298e-11
_LOG10_2_HIGH = 3.01029995663611771306e-01
_LOG10_2_LOW = 3.69423907715893078616e-13

_EXP_OVERFLOW = 7.09782712893383973096e02
_EXP_UNDERFLOW = -7.45133219101941108420e02

_TWO_OVER_PI = 6.36619772367581382433e-01
_PIO2_1 = 1.57079632673412561417e00  # first 33 bits of pi/2
_PIO2_2 = 6.07710050630396597660e-11  # next 33 bits
_PIO2_2T = 2.02226624879595063154e-21  # the rest
_ANGLE_MAX = 1.0e6

_PI = 3.141592653589793116
_PI_LOW = 1.2246467991473531772e-16
_TAN_PIO8 = 0.4142135623730950488


@kernel(forceinline=True)
def _log_parts(x):
    """Exponent ``k`` and ``f`` of ``x = 2**k (1 + f)``, and log(1+f) - f + f*f/2."""
    # Subnormals: scale up, then correct the exponent.
    subnormal = x < _SMALLEST_NORMAL
    scaled = x * 2.0**54 if subnormal else x
    bias = _TWO52_PLUS_BIAS + 54.0 if subnormal else _TWO52_PLUS_BIAS
    # 1 + f in [sqrt(1/2), sqrt(2)), so that log(x) has no cancellation near 1.
    bits = np.float64(scaled).view(np.int64) + (_ONE - _ROOT_HALF)
    k = np.int64((bits >> 52) | _TWO52).view(np.float64) - bias
    f = np.int64((bits & _FRACTION) + _ROOT_HALF).view(np.float64) - 1.0
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    even = w * (3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01))
    odd = z * (
        6.666666666666735130e-01
        + w * (2.857142874366239149e-01 + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01))
    )
    half_square = 0.5 * f * f
    return k, f, half_square, s * (half_square + (even + odd))


@kernel(forceinline=True)
def log(x):
    """Natural logarithm.

    Parameters
    ----------
    x : float

    Returns
    -------
    float
        ``-inf`` at 0 (of either sign), ``nan`` below 0, ``inf`` at ``inf``,
        ``nan`` at ``nan``.
    """
    if not (0.0 < x < _INF):
        return -_INF if x == 0.0 else (x if x > 0.0 else _NAN)
    k, f, half_square, tail = _log_parts(x)
    return k * _LN2_HIGH - ((half_square - (tail + k * _LN2_LOW)) - f)


@kernel(forceinline=True)
def log10(x):
    """Decimal logarithm.

    Parameters
    ----------
    x : float

    Returns
    -------
    float
        ``-inf`` at 0 (of either sign), ``nan`` below 0, ``inf`` at ``inf``,
        ``nan`` at ``nan``.
    """
    if not (0.0 < x < _INF):
        return -_INF if x == 0.0 else (x if x > 0.0 else _NAN)
    k, f, half_square, tail = _log_parts(x)
    # log(1+f) = high + low, with few enough bits in high for an exact product.
    bits = np.float64(f - half_square).view(np.int64) & _HIGH_WORD
    high = np.int64(bits).view(np.float64)
    low = ((f - high) - half_square) + tail
    product = high * _INV_LN10_HIGH
    whole = k * _LOG10_2_HIGH
    rest = k * _LOG10_2_LOW + (low + high) * _INV_LN10_LOW + low * _INV_LN10_HIGH
    total = whole + product
    return (rest + ((whole - total) + product)) + total


@kernel(forceinline=True)
def exp(x):
    """Exponential.

    Parameters
    ----------
    x : float

    Returns
    -------
    float
        ``inf`` above 709.78, 0 below -745.13, ``nan`` at ``nan``.
    """
    if not (_EXP_UNDERFLOW <= x <= _EXP_OVERFLOW):
        return _INF if x > 0.0 else (0.0 if x < 0.0 else _NAN)
    shifted = x * _INV_LN2 + _ROUND
    n = shifted - _ROUND
    high = x - n * _LN2_HIGH
    low = n * _LN2_LOW
    r = high - low
    z = r * r
    c = r - z * (
        1.66666666666666019037e-01
        + z
        * (
            -2.77777777770155933842e-03
            + z * (6.61375632143793436117e-05 + z * (-1.65339022054652515390e-06 + z * 4.13813679705723846039e-08))
        )
    )
    y = 1.0 - ((low - (r * c) / (2.0 - c)) - high)
    # 2**n in two factors: n alone may lie outside the range of exponents.
    k = np.int64(n)
    half = k >> 1
    return y * np.int64((half + 1023) << 52).view(np.float64) * np.int64((k - half + 1023) << 52).view(np.float64)


@kernel
def _reduce(x):
    """Quadrant (mod 4) and ``x - quadrant*pi/2`` as a sum of two float64."""
    n = (x * _TWO_OVER_PI + _ROUND) - _ROUND
    first = x - n * _PIO2_1
    w = n * _PIO2_2
    r = first - w
    w = n * _PIO2_2T - ((first - r) - w)
    high = r - w
    return np.int64(n) & 3, high, (r - high) - w


@kernel
def _sin_cos(high, low):
    """Sine and cosine of ``high + low``, at most pi/4 in size."""
    z = high * high
    v = z * high
    r = 8.33333333332248946124e-03 + z * (
        -1.98412698298579493134e-04
        + z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10))
    )
    sine = high - ((z * (0.5 * low - v * r) - low) + v * 1.66666666666666324348e-01)
    r = z * (
        4.16666666666666019037e-02
        + z
        * (
            -1.38888888888741095749e-03
            + z
            * (
                2.48015872894767294178e-05
                + z * (-2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 - z * 1.13596475577881948265e-11))
            )
        )
    )
    half = 0.5 * z
    w = 1.0 - half
    cosine = w + (((1.0 - w) - half) + (z * r - high * low))
    return sine, cosine


@kernel
def sin(x):
    """Sine.

    Parameters
    ----------
    x : float
        Angle, rad.

    Returns
    -------
    float
        ``nan`` when ``abs(x)`` exceeds 1e6 (the reduction is not exact there),
        at infinities and at ``nan``.
    """
    if not (-_ANGLE_MAX <= x <= _ANGLE_MAX):
        return _NAN
    quadrant, high, low = _reduce(x)
    sine, cosine = _sin_cos(high, low)
    y = cosine if quadrant & 1 else sine
    return -y if quadrant & 2 else y


@kernel
def cos(x):
    """Cosine.

    Parameters
    ----------
    x : float
        Angle, rad.

    Returns
    -------
    float
        ``nan`` when ``abs(x)`` exceeds 1e6 (the reduction is not exact there),
        at infinities and at ``nan``.
    """
    if not (-_ANGLE_MAX <= x <= _ANGLE_MAX):
        return _NAN
    quadrant, high, low = _reduce(x)
    sine, cosine = _sin_cos(high, low)
    y = sine if quadrant & 1 else cosine
    return -y if (quadrant + 1) & 2 else y


@kernel
def _with_sign_of(x, size):
    """``size``, which is not negative, with the sign of ``x``."""
    sign = np.float64(x).view(np.int64) & _SIGN
    return np.int64(np.float64(size).view(np.int64) | sign).view(np.float64)


@kernel
def _atan_reduced(t):
    """Arctangent of ``t``, for ``abs(t)`` at most tan(pi/8)."""
    z = t * t
    w = z * z
    even = z * (
        3.33333333333329318027e-01
        + w
        * (
            1.42857142725034663711e-01
            + w
            * (
                9.09088713343650656196e-02
                + w * (6.66107313738753120669e-02 + w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02))
            )
        )
    )
    odd = w * (
        -1.99999999998764832476e-01
        + w
        * (
            -1.11111104054623557880e-01
            + w * (-7.69187620504482999495e-02 + w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02))
        )
    )
    return t - t * (even + odd)


@kernel
def atan2(y, x):
    """Angle of the point (x, y) from the positive x axis.

    Parameters
    ----------
    y, x : float
        Coordinates, any common unit.

    Returns
    -------
    float
        Angle in [-pi, pi], rad.  Zeros keep their signs and infinities stand
        for directions, as in C99 annex F; ``nan`` if either is ``nan``.
    """
    a = abs(y)
    b = abs(x)
    larger = a if a > b else b
    if not (a + b < 1.0e308 and larger > 0.0):
        if not (a <= _INF and b <= _INF):
            return _NAN
        if larger == 0.0:
            b = 1.0
        elif larger == _INF:
            a = 1.0 if a == _INF else 0.0
            b = 1.0 if b == _INF else 0.0
        else:  # keep a + b finite
            a *= 0.25
            b *= 0.25
    low = b if a > b else a
    high = a if a > b else b
    # Above pi/8, turn by pi/4: atan(q) = pi/4 + atan((q - 1) / (q + 1)).
    turn = low > _TAN_PIO8 * high
    t = (low - high if turn else low) / (low + high if turn else high)
    r = _atan_reduced(t)
    # Now angle = base + base_low +- r, folded back by octant.
    negative_x = np.float64(x).view(np.int64) < 0
    swap = a > b
    quarters = 1.0 if turn else 0.0
    if swap:
        quarters = 2.0 - quarters
        r = -r
    if negative_x:
        quarters = 4.0 - quarters
        r = -r
    angle = quarters * (0.25 * _PI) + (quarters * (0.25 * _PI_LOW) + r)
    return _with_sign_of(y, angle)


@kernel
def tanh(x):
    """Hyperbolic tangent.

    Parameters
    ----------
    x : float

    Returns
    -------
    float
        1 with the sign of ``x`` beyond 22; zeros keep their signs; ``nan`` at
        ``nan``.
    """
    a = abs(x)
    if a < 0.625:
        z = a * a
        p = -1.61468768441708447952e03 + z * (-9.92877231001918586564e01 - z * 9.64399179425052238628e-01)
        q = 4.84406305325125486048e03 + z * (2.23548839060100448583e03 + z * (1.12811678491632931402e02 + z))
        y = a + a * (z * (p / q))
    elif a > 22.0:
        y = 1.0
    else:
        y = 1.0 - 2.0 / (exp(2.0 * a) + 1.0)
    return _with_sign_of(x, y)
