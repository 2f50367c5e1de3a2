"""Which column of a table holds what: by the user's word, else by well-known names."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rss_gym.calibration.logs.record import DISTANCE_LIMITS_M
from rss_gym.params import ParamsError, suggestion

# Key of `--columns`: names guessed in a header without its unit, whatever their case, the first one found.
NAMES: dict[str, tuple[str, ...]] = {
    "t": ("t", "time", "timestamp", "datetime", "date time", "elapsed", "elapsed time", "seconds", "utc", "clock"),
    "date": ("date",),
    "rss": ("rss", "rssi", "signal strength", "received signal strength", "signal", "received power", "rx power"),
    "dist": ("dist", "distance", "true distance", "ground truth", "true dist"),
    "rate": ("range rate", "rate", "distance rate", "radial velocity", "radial speed"),
    "link": ("link", "ap", "sensor", "bssid", "mac", "anchor", "beacon", "transmitter"),
    "armed": ("armed",),
    **{key: (key, f"pos {key}", f"position {key}") for key in ("x", "y", "z")},
    **{key: (key,) for key in ("x2", "y2", "z2")},
    **{key: (key, f"v {key[1:]}", f"velocity {key[1:]}") for key in ("vx", "vy", "vz")},
    **{key: (key,) for key in ("vx2", "vy2", "vz2")},
    **{f"lat{end}": (f"lat{end}", f"latitude{end}", f"gps lat{end}", f"gps latitude{end}") for end in ("", "2")},
    **{
        f"lon{end}": (f"lon{end}", f"lng{end}", f"longitude{end}", f"gps lon{end}", f"gps longitude{end}")
        for end in ("", "2")
    },
    **{
        f"alt{end}": (f"alt{end}", f"altitude{end}", f"height{end}", f"gps alt{end}", f"gps altitude{end}")
        for end in ("", "2")
    },
    "vn": ("vn", "vel north", "v north", "north velocity"),
    "ve": ("ve", "vel east", "v east", "east velocity"),
    "vd": ("vd", "vel down", "v down", "down velocity"),
    "speed": ("speed", "ground speed", "gps speed"),
    "course": ("course", "heading", "track", "bearing"),
}
LOCAL, GLOBAL = ("x", "y", "z", "x2", "y2", "z2"), ("lat", "lon", "alt", "lat2", "lon2", "alt2")
VELOCITY, VELOCITY_2 = ("vx", "vy", "vz"), ("vx2", "vy2", "vz2")
COMPASS, POLAR = ("ve", "vn", "vd"), ("speed", "course")
HEIGHTS = frozenset(("z", "z2", "alt", "alt2", "vz", "vz2", "vd"))

# Words of a header that says it in prose, for the keys that every log needs.
_WORDS: dict[str, tuple[frozenset[str], ...]] = {
    "t": (frozenset(("time",)), frozenset(("timestamp",)), frozenset(("elapsed",)), frozenset(("seconds",))),
    "rss": (frozenset(("rssi",)), frozenset(("rss",)), frozenset(("signal",)), frozenset(("received", "power"))),
    "dist": (frozenset(("distance",)), frozenset(("dist",))),
}
_NOT = frozenset(
    ("rtt", "estimated", "measured", "estimate", "std", "error", "noise", "ratio", "quality", "horizontal")
)

_LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 1e-3, "km": 1e3, "ft": 0.3048, "feet": 0.3048, "metres": 1.0, "meters": 1.0}
_SPEEDS = {"m/s": 1.0, "mps": 1.0, "cm/s": 0.01, "km/h": 1 / 3.6, "kmh": 1 / 3.6, "kts": 0.514444, "knots": 0.514444}
_TIMES = {
    "s": "s",
    "sec": "s",
    "seconds": "s",
    "ms": "ms",
    "millis": "ms",
    "milliseconds": "ms",
    "us": "us",
    "µs": "us",
}
_TIMES |= {"microseconds": "us", "ns": "ns", "nanoseconds": "ns"}
_ANGLES = {"deg": 1.0, "degrees": 1.0, "°": 1.0, "dege7": 1e-7}

# Lowest and highest number of a key without its "2", and what it is.
_LIMITS: dict[str, tuple[float, float, str]] = {
    "rss": (-100_000.0, 100_000.0, "an RSS in dBm"),
    "dist": (0.0, DISTANCE_LIMITS_M[1], "a distance in m"),
    "lat": (-90.0, 90.0, "a latitude in degrees"),
    "lon": (-180.0, 360.0, "a longitude in degrees"),
    "alt": (-1e4, 1e5, "an altitude in m"),
    "course": (-360.0, 360.0, "a course in degrees"),
    **{key: (-1e6, 1e6, "a position in m") for key in ("x", "y", "z")},
    **{key: (-1e4, 1e4, "a velocity in m/s") for key in (*VELOCITY, *COMPASS, "speed", "rate")},
}


@dataclass(frozen=True)
class Quantity:
    """One number of a row: its key, where it is in the row or its constant value, factor to SI, limits.

    `unit` is the unit of a time, empty where the header does not say.
    """

    key: str
    column: str
    index: int | None
    constant: float
    low: float
    high: float
    what: str
    factor: float = 1.0
    unit: str = ""

    @property
    def wanted(self) -> str:
        """What would be right, for an error sentence."""
        return f"{self.key} must be {self.what} in [{self.low:g}, {self.high:g}]"


def plain(column: str) -> tuple[str, str]:
    """A column's name as words, and its unit: `Signal strength [dBm]` and `rss_dbm` alike lose theirs."""
    name = column.strip().strip("\"'").casefold()
    found = re.search(r"[\(\[]([^\)\]]*)[\)\]]", name)
    unit = found.group(1).strip() if found else ""
    name = re.sub(r"[\(\[][^\)\]]*[\)\]]", " ", name)
    words = re.split(r"[\s_\-.:/,]+", name.strip())
    units = {*_LENGTHS, *_SPEEDS, *_TIMES, *_ANGLES, "dbm", "db"}
    if not unit and len(words) > 2 and words[-2:] == ["m", "s"]:
        unit, words = "m/s", words[:-2]
    if not unit and len(words) > 1 and words[-1] in units and " ".join(words) not in NAMES["t"]:
        unit = words.pop()
    return " ".join(words), unit


def found_in(header: Sequence[str], columns: Mapping[str, str], source: str) -> dict[str, Quantity]:
    """The quantities of a header: those that the user named, and those with well-known names.

    Parameters
    ----------
    header : sequence of str
        Names of the columns; their numbers from 1 for a table without.
    columns : mapping of str to str
        Key (`NAMES`) to the name of its column, or to a number that holds in every row; or the number of a column to
        its key.
    source : str
        The file's name, for messages.

    Raises
    ------
    ParamsError
        For an unknown key or a column that is not there.
    """
    found: dict[str, Quantity] = {}
    for key, name in columns.items():
        if key.isdecimal():
            if name not in NAMES:
                raise ParamsError(f"columns: {name!r} is unknown{suggestion(name, NAMES)}")
            if not 1 <= int(key) <= len(header):
                raise ParamsError(f"log {source!r} has {len(header)} columns, and none is number {key}")
            found[name] = _quantity(name, header[int(key) - 1], int(key) - 1)
        elif key not in NAMES:
            raise ParamsError(f"columns: {key!r} is unknown{suggestion(key, NAMES)}")
        else:
            found[key] = _named(key, name, header, source)
    words = [plain(name)[0] for name in header]
    taken = {quantity.index for quantity in found.values() if quantity.index is not None}
    for key, names in NAMES.items():
        index = next((words.index(name) for name in names if name in words), None)
        if key not in found and index is not None and not (key == "date" and index in taken):
            found[key] = _quantity(key, header[index], index)
            taken.add(index)
    for key, several in _WORDS.items():
        if key not in found:
            spoken = [frozenset(name.split()) for name in words]
            fits = [
                k
                for k, said in enumerate(spoken)
                if k not in taken and not said & _NOT and any(wanted <= said for wanted in several)
            ]
            if len(fits) == 1:
                found[key] = _quantity(key, header[fits[0]], fits[0])
                taken.add(fits[0])
    return found


def checked(found: dict[str, Quantity], columns: Mapping[str, str], header: Sequence[str], source: str) -> None:
    """Refuse a table without time and RSS, or with a half-named velocity.

    Raises
    ------
    ParamsError
        In one sentence.
    """
    for key in ("t", "rss"):
        if key not in found:
            raise ParamsError(f"log {source!r} has no column for {key}; name it by {key}=NAME{near(key, header)}")
        if found[key].index is None:
            raise ParamsError(f"columns: {key} must be a column, got {columns[key]!r}{near(key, header)}")
    for parts in (VELOCITY, VELOCITY_2):
        lone = [key for key in parts if key in columns]
        if lone and not found.keys() >= set(parts[:2]):
            raise ParamsError(
                f"columns: {lone[0]} is of use only beside the other components of its velocity, "
                f"{', '.join(parts)}, and "
                f"the positions of both ends; log {source!r} lacks some of them"
            )


def ends(found: Mapping[str, Quantity], columns: Mapping[str, str]) -> tuple[str, ...]:
    """`LOCAL`, `GLOBAL` or (): the positions of both ends that a table has, heights left aside."""
    complete = [system for system in (LOCAL, GLOBAL) if all(key in found or key in HEIGHTS for key in system)]
    named = {name if key.isdecimal() else key for key, name in columns.items()}
    return max(complete, key=lambda system: len(named & set(system)), default=())


def no_distance(found: Mapping[str, Quantity], columns: Mapping[str, str], header: Sequence[str], source: str) -> str:
    """The sentence for a table without distances."""
    for system in (LOCAL, GLOBAL):
        missing = [key for key in system if key not in found and key not in HEIGHTS]
        if columns.keys() & set(system) and missing:
            return (
                f"log {source!r} has no column for {missing[0]}; give {missing[0]}=NAME, or a number for every row"
                f"{near(missing[0], header)}"
            )
    for system, what in ((LOCAL, "X,Y,Z"), (GLOBAL, "LAT,LON,ALT")):
        if all(key in found for key in system[:2]):
            return f"log {source!r} has the positions of one end only; say where the other is by --station {what}"
    return (
        f"log {source!r} has neither a distance nor the positions of both ends; name them by dist=NAME, or by "
        f"{','.join(LOCAL)}, or by {','.join(GLOBAL)}, or give a table that has them by --truth{near('dist', header)}"
    )


def near(name: str, header: Sequence[str]) -> str:
    """The nearest name and the first names of a header, which may be long."""
    return suggestion(str(name)[:60], [column[:60] for column in header[:40]])


def _quantity(key: str, column: str, index: int | None, constant: float = 0.0) -> Quantity:
    unit, base = plain(column)[1] if index is not None else "", key.rstrip("2")
    low, high, what = _LIMITS.get(base, (0.0, 0.0, ""))
    factors = _ANGLES if base in ("lat", "lon", "course") else _SPEEDS if what.startswith("a velocity") else _LENGTHS
    factor = factors.get(unit, 1.0) if what and base != "rss" else 1.0
    time = _TIMES.get(unit, "") if key == "t" else ""
    return Quantity(key, column, index, constant, low, high, what, factor, time)


def _named(key: str, name: str, header: Sequence[str], source: str) -> Quantity:
    """The column or the constant that the user gave for a key."""
    if name in header:
        return _quantity(key, name, header.index(name))
    try:
        constant = float(name)
    except (TypeError, ValueError):
        raise ParamsError(f"log {source!r} has no column {name!r}{near(name, header)}") from None
    quantity = _quantity(key, str(name), None, constant)
    if key not in ("link", "t", "date", "armed") and not quantity.low <= constant <= quantity.high:
        raise ParamsError(f"columns: {quantity.wanted}, got {name!r}")
    return quantity
