"""Times as logs have them: numbers of some unit, ISO 8601, or a clock."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from datetime import UTC, datetime

import numpy as np

from rss_gym.calibration.logs.options import TIME_UNITS
from rss_gym.calibration.logs.record import Floats

DAY_S = 86_400.0
_CLOCK = re.compile(r"(\d{1,3}):(\d{2})(?::(\d{2}(?:[.,]\d+)?))?$")
_STYLES = ("%Y/%m/%d %H:%M:%S", "%d.%m.%Y %H:%M:%S", "%d/%m/%Y %H:%M:%S", "%m/%d/%Y %H:%M:%S", "%Y-%m-%d_%H-%M-%S")
# Since 1970, between 1990 and 2100: the unit is told by the number alone.
_EPOCH_S = (6e8, 4.2e9)
_INTERVALS_S = (0.002, 10.0)
_SPEEDS_MPS = (2e-3, 300.0)


def time_parser(text: str) -> tuple[str, Callable[[str], float]] | None:
    """How cells such as this one give a time: a kind ("number", "date" or "clock") and a function, None if neither.

    Dates are in s since 1970, clocks in s since midnight, both with fractions.
    """
    for kind, parse in (("number", _number), ("clock", _clock_s), ("date", _date_s)):
        try:
            if math.isfinite(parse(text.strip())):
                return kind, parse
        except ValueError:
            continue
    return None


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float(text.replace(",", "."))


def _clock_s(text: str) -> float:
    found = _CLOCK.match(text.strip())
    if not found:
        raise ValueError(text)
    first, second, third = found.groups()
    if third is None:  # minutes and seconds
        return 60.0 * int(first) + int(second)
    return 3600.0 * int(first) + 60.0 * int(second) + float(third.replace(",", "."))


def _date_s(text: str) -> float:
    text = text.strip()
    try:
        found = datetime.fromisoformat(text)
    except ValueError:
        whole, dot, fraction = text.rpartition(".")
        if not fraction.isdecimal() or ":" not in whole:
            whole, dot, fraction = text, "", ""
        for style in _STYLES:
            try:
                found = datetime.strptime(whole, style)
            except ValueError:
                continue
            return found.replace(tzinfo=UTC).timestamp() + (float(f"0.{fraction}") if dot else 0.0)
        raise
    return (found if found.tzinfo else found.replace(tzinfo=UTC)).timestamp()


def unwrapped(clock_s: Floats) -> Floats:
    """Clock times that go on after midnight."""
    turns = np.cumsum(np.diff(clock_s, prepend=clock_s[:1]) < -0.5 * DAY_S)
    return clock_s + DAY_S * turns


def time_unit(links: list[tuple[Floats, Floats]]) -> tuple[str, str]:
    """The unit of numbers that may be times, and how it was told.

    By the number itself if it counts from 1970. Else the first of s, ms, us, ns in which the links are sampled every
    2 ms to 10 s and the distance changes by 2 mm/s to 300 m/s in the mean; then the first of the right interval.

    Parameters
    ----------
    links : list of (times, distances)
        The series of each link; distances may be NaN.

    Returns
    -------
    unit, why
        `why` is empty where seconds are as plausible as anything.
    """
    first = np.concatenate([np.empty(0), *(time[np.isfinite(time)][:1] for time, _ in links)])
    for unit, scale in TIME_UNITS.items():
        if first.size and _EPOCH_S[0] <= first.min() * scale <= _EPOCH_S[1]:
            return unit, "" if unit == "s" else "it counts from 1970"
    intervals, paths, spans = [], 0.0, 0.0
    for time, distance_m in links:
        good = np.isfinite(time)
        steps = np.diff(time[good])
        intervals.append(steps[steps > 0.0])
        path = np.abs(np.diff(distance_m[good & np.isfinite(distance_m)]))
        if path.size and steps.size:
            paths, spans = paths + float(path.sum()), spans + float(np.ptp(time[good]))
    steps = np.concatenate([np.empty(0), *intervals])
    if not steps.size:
        return "s", ""
    interval = float(np.median(steps))
    right = [unit for unit, scale in TIME_UNITS.items() if _INTERVALS_S[0] <= interval * scale <= _INTERVALS_S[1]]
    moving = [
        unit for unit in right if spans > 0.0 and _SPEEDS_MPS[0] <= paths / (spans * TIME_UNITS[unit]) <= _SPEEDS_MPS[1]
    ]
    unit = (moving or right or ["s"])[0]
    if unit == "s":
        return unit, ""
    return unit, f"rows of a link are {interval:g} {unit} apart"
