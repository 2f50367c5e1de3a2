"""Numbers as a reader sees them: significant digits, powers of ten below a thousandth, intervals in brackets."""

from __future__ import annotations

import math
from typing import Protocol

MISSING = "–"
MINUS = "−"
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class Measured(Protocol):
    """A value with the ends of its interval, any of which may be missing."""

    @property
    def value(self) -> float | None: ...  # noqa: D102
    @property
    def low(self) -> float | None: ...  # noqa: D102
    @property
    def high(self) -> float | None: ...  # noqa: D102


def number(value: float | None, digits: int = 3) -> str:
    """A number to so many significant digits, such as `41.3`, `0.0052` or `3.1×10⁻⁴`."""
    if value is None or math.isnan(value):
        return MISSING
    sign, size = (MINUS if value < 0 else ""), abs(value)
    if size == 0.0 or math.isinf(size):
        return "0" if size == 0.0 else f"{sign}∞"
    while size < 1.0 and digits < 6 and float(f"{size:.{digits}g}") == 1.0:
        digits += 1  # almost certain is not certain
    mantissa, _, exponent = f"{size:.{digits - 1}e}".partition("e")
    power = int(exponent)
    if power < -3 or power > 6:
        return f"{sign}{mantissa}×{power_of_ten(power)}"
    return f"{sign}{size:,.{max(0, digits - 1 - power)}f}"


def short(value: float) -> str:
    """The same to two digits."""
    return number(value, 2)


def figures(value: float | None) -> str:
    """A number with three figures, such as `0.5` or `1.2e-04`."""
    if value is None:
        return MISSING
    if value != 0.0 and abs(value) < 0.001:
        return f"{value:.1e}"
    return f"{value:,.0f}" if abs(value) >= 999.5 else f"{value:.3g}"


def power_of_ten(power: int) -> str:
    """`10⁻⁴`."""
    return "10" + str(power).translate(_RAISED)


def interval(estimate: Measured, digits: int = 3) -> str:
    """`[low, high]`, or nothing where the estimate has no interval."""
    if estimate.low is None and estimate.high is None:
        return ""
    return f"[{number(estimate.low, digits)}, {number(estimate.high, digits)}]"


def full(estimate: Measured, unit: str = "") -> str:
    """Value, interval and unit in one line, for tool tips."""
    named = "" if unit in ("", "1") else f" {unit}"
    return " ".join(filter(None, (number(estimate.value) + named, interval(estimate))))
