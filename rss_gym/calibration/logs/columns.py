"""Which column of a table holds what: by the user's word, else by well-known names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rss_gym.calibration.logs.record import DISTANCE_LIMITS_M
from rss_gym.params import ParamsError, suggestion

# Key of `--columns`: names guessed in a header, whatever their case, the first one found.
NAMES: dict[str, tuple[str, ...]] = {
    "t": ("t", "time", "time_s", "timestamp"),
    "rss": ("rss", "rssi", "rss_dbm", "rssi_dbm"),
    "dist": ("dist", "distance", "distance_m"),
    "link": ("link", "ap", "sensor"),
    **{key: (key, f"{key}_m") for key in ("x", "y", "z", "x2", "y2", "z2")},
    **{key: (key, f"{key}_mps") for key in ("vx", "vy", "vz", "vx2", "vy2", "vz2")},
    **{f"lat{end}": (f"lat{end}", f"latitude{end}", f"lat{end}_deg") for end in ("", "2")},
    **{f"lon{end}": (f"lon{end}", f"lng{end}", f"longitude{end}", f"lon{end}_deg") for end in ("", "2")},
    **{f"alt{end}": (f"alt{end}", f"altitude{end}", f"alt{end}_m") for end in ("", "2")},
}
LOCAL, GLOBAL = ("x", "y", "z", "x2", "y2", "z2"), ("lat", "lon", "alt", "lat2", "lon2", "alt2")
VELOCITY, VELOCITY_2 = ("vx", "vy", "vz"), ("vx2", "vy2", "vz2")

# Lowest and highest number of a key without its "2", and what it is.
_LIMITS: dict[str, tuple[float, float, str]] = {
    "t": (-1e11, 1e11, "a time in s"),  # milliseconds since 1970 lie outside
    "rss": (-300.0, 1000.0, "an RSS in dBm"),
    "dist": (*DISTANCE_LIMITS_M, "a distance in m"),
    "lat": (-90.0, 90.0, "a latitude in degrees"),
    "lon": (-180.0, 360.0, "a longitude in degrees"),
    "alt": (-1e4, 1e5, "an altitude in m"),
    **{key: (-1e6, 1e6, "a position in m") for key in ("x", "y", "z")},
    **{key: (-1e4, 1e4, "a velocity in m/s") for key in VELOCITY},
}


@dataclass(frozen=True)
class Quantity:
    """One number of a row: its key, where it is in the row or its constant value, its limits."""

    key: str
    column: str
    index: int | None
    constant: float
    low: float
    high: float
    what: str

    @property
    def wanted(self) -> str:
        """What would be right, for an error sentence."""
        return f"{self.key} must be {self.what} in [{self.low:g}, {self.high:g}]"


@dataclass(frozen=True)
class Layout:
    """The columns of a table that are read.

    Attributes
    ----------
    quantities : dict of str to Quantity
        By key: t and rss, dist if the distance is taken from there, positions and velocities if these are used.
    ends : tuple of str
        `LOCAL`, `GLOBAL`, or () when no positions are used.
    link_index : int or None
        Column with the link's name.
    link : str
        Its name where no column has it.
    """

    quantities: dict[str, Quantity]
    ends: tuple[str, ...]
    link_index: int | None
    link: str


def layout(header: Sequence[str], columns: Mapping[str, str], source: str) -> Layout:
    """The layout of a table with that header.

    A distance column is used as it is, unless positions were named and no distance was. Velocities need positions.

    Parameters
    ----------
    header : sequence of str
        Names of the columns.
    columns : mapping of str to str
        Key (`NAMES`) to the name of its column, or to a number that holds in every row.
    source : str
        The file's name, for messages.

    Raises
    ------
    ParamsError
        For an unknown key, a column that is not there, or a table without distance and positions.
    """
    for key in columns:
        if key not in NAMES:
            raise ParamsError(f"columns: {key!r} is unknown{suggestion(key, NAMES)}")
    found = {key: _named(key, columns[key], header, source) for key in columns}
    lower = [name.casefold() for name in header]
    for key, names in NAMES.items():
        index = next((lower.index(name) for name in names if name in lower), None)
        if key not in found and index is not None:
            found[key] = _quantity(key, header[index], index)

    for key in ("t", "rss"):
        if key not in found:
            raise ParamsError(f"log {source!r} has no column for {key}; name it by {key}=NAME{_of(key, header)}")
        if found[key].index is None:
            raise ParamsError(f"columns: {key} must be a column, got {columns[key]!r}{_of(key, header)}")
    by_distance = "dist" in found and ("dist" in columns or not columns.keys() & {*LOCAL, *GLOBAL})
    complete = [system for system in (LOCAL, GLOBAL) if found.keys() >= set(system)]
    if not complete and not by_distance:
        raise ParamsError(_no_distance(found, columns, header, source))
    moving = bool(complete) and found.keys() >= set(VELOCITY)
    both_moving = moving and found.keys() >= set(VELOCITY_2)
    for key in [*VELOCITY, *VELOCITY_2]:
        if key in columns and not (both_moving if key in VELOCITY_2 else moving):
            raise ParamsError(
                f"columns: {key} is of use only beside the other components of its velocity, vx, vy and vz, and the "
                f"positions of both ends; log {source!r} lacks some of them"
            )
    ends: tuple[str, ...] = ()
    if moving or not by_distance:
        ends = max(complete, key=lambda system: len(columns.keys() & set(system)))
    keys = ["t", "rss", *(["dist"] if by_distance else []), *ends]
    keys += [*(VELOCITY if moving else ()), *(VELOCITY_2 if both_moving else ())]
    link = found.get("link")
    return Layout(
        quantities={key: found[key] for key in keys},
        ends=ends,
        link_index=link.index if link else None,
        link=link.column if link else "link",
    )


def _quantity(key: str, column: str, index: int | None, constant: float = 0.0) -> Quantity:
    return Quantity(key, column, index, constant, *_LIMITS.get(key.rstrip("2"), (0.0, 0.0, "")))


def _named(key: str, name: str, header: Sequence[str], source: str) -> Quantity:
    """The column or the constant that the user gave for a key."""
    if name in header:
        return _quantity(key, name, header.index(name))
    try:
        constant = float(name)
    except (TypeError, ValueError):
        raise ParamsError(f"log {source!r} has no column {name!r}{_of(name, header)}") from None
    quantity = _quantity(key, str(name), None, constant)
    if key != "link" and not quantity.low <= constant <= quantity.high:
        raise ParamsError(f"columns: {quantity.wanted}, got {name!r}")
    return quantity


def _of(name: str, header: Sequence[str]) -> str:
    """The nearest name and the first names of a header, which may be long."""
    return suggestion(str(name)[:60], [column[:60] for column in header[:40]])


def _no_distance(found: Mapping[str, Quantity], columns: Mapping[str, str], header: Sequence[str], source: str) -> str:
    for system in (LOCAL, GLOBAL):
        missing = [key for key in system if key not in found]
        if columns.keys() & set(system) and missing:
            return (
                f"log {source!r} has no column for {missing[0]}; give {missing[0]}=NAME, or a number for every row"
                f"{_of(missing[0], header)}"
            )
    return (
        f"log {source!r} has neither a distance nor the positions of both ends; name them by dist=NAME, or by "
        f"{','.join(LOCAL)}, or by {','.join(GLOBAL)}{_of('dist', header)}"
    )
