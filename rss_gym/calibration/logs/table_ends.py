"""Distance and range rate of a table's rows: from its own columns, a station, or another table over the same clock."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rss_gym.calibration.logs import columns as names
from rss_gym.calibration.logs.columns import COMPASS, GLOBAL, LOCAL, POLAR, VELOCITY, VELOCITY_2, Quantity
from rss_gym.calibration.logs.ends import known_places, rate_mps, relative_m, sign
from rss_gym.calibration.logs.record import DISTANCE, MISSING, NO_POSITION, Floats, Rows
from rss_gym.params import ParamsError

if TYPE_CHECKING:
    from rss_gym.calibration.logs.table import Table

GAP_MAX_S, GAP_INTERVALS = 2.0, 3.0  # between two rows of the truth on both sides of a sample


@dataclass(frozen=True, eq=False)
class Truth:
    """A second table over the same clock: its rows by link, and what its columns hold."""

    links: dict[str, dict[str, Floats]]
    found: dict[str, Quantity]


def add_distance(table: Table, rows: Rows, values: dict[str, Floats], truth: Truth | None = None) -> None:
    """Fill in the distance, and the range rate where the log has any velocity.

    Raises
    ------
    ParamsError
        If nothing tells the distance.
    """
    found = table.layouts[0].quantities
    for layout in table.layouts:
        found = layout.quantities if layout.link == rows.link else found
    columns, station = table.options.columns, table.options.station
    if truth is not None:
        values = values | _merged(table, rows, truth)
        found = found | {key: value for key, value in truth.found.items() if key not in ("t", "rss", "link", "date")}
    if station is not None and not {"x2", "lat2"} & values.keys():
        system = GLOBAL if "lat" in values else LOCAL
        values = values | {key: np.full(rows.time_s.size, at) for key, at in zip(system[3:], station, strict=True)}
        found = found | {key: found[key[:-1]] for key in system[3:] if key[:-1] in found}
    ends = names.ends(found, columns)
    named = {name if key.isdecimal() else key for key, name in columns.items()}
    if "dist" in values and ("dist" in named or not (named & {*LOCAL, *GLOBAL} or (station is not None and ends))):
        rows.distance_m = values["dist"].copy()
    elif not ends:
        raise ParamsError(names.no_distance(found, columns, table.header, table.source))
    if ends:
        _by_positions(table, rows, values, ends)
    if "rate" in values:
        turn = sign(rows.time_s, rows.distance_m, values["rate"])
        if turn < 0.0:
            _note(table, "the range rate is positive when the distance falls; its sign is turned")
        rows.range_rate_mps = turn * values["rate"]


def _by_positions(table: Table, rows: Rows, values: dict[str, Floats], ends: tuple[str, ...]) -> None:
    size = rows.time_s.size
    flat = [key for key in (ends[2], ends[5]) if key not in values]
    if flat:
        _note(table, f"no {' and '.join(flat)}: distances are horizontal")
    first, second = (
        np.column_stack([np.zeros(size) if flat and k == 2 else values[key] for k, key in enumerate(part)])
        for part in (ends[:3], ends[3:])
    )
    apart_m = relative_m(first, second, ends == GLOBAL)
    if ends == GLOBAL:
        known = known_places(first[:, 0], first[:, 1], first[:, 2])
        if known.any():
            bad = ~known & ~np.isnan(first[:, 0])
            if bad.any() and known_places(*second[:1].T).all():
                table.file.example(DISTANCE, f"line {rows.number[np.argmax(bad)]:.0f}, a position beside 0, 0")
                rows.drop(bad, DISTANCE)
    if np.isnan(rows.distance_m).all():
        rows.distance_m = np.linalg.norm(apart_m, axis=1)
        unknown = np.isnan(rows.distance_m) & (rows.reason == 0)
        if unknown.any():
            table.file.example(MISSING, f"line {rows.number[np.argmax(unknown)]:.0f}, no position")
    velocity = _velocity(table, rows, values, first)
    if velocity is not None:
        rows.range_rate_mps = rate_mps(apart_m, velocity)


def _velocity(table: Table, rows: Rows, values: dict[str, Floats], first: Floats) -> Floats | None:
    """(n, 3) of the first end relative to the second, its vertical part by the sign of the height's change."""
    zero = np.zeros(rows.time_s.size)
    if values.keys() >= set(VELOCITY[:2]):
        own = [values[key] if key in values else zero for key in VELOCITY]
    elif values.keys() >= set(COMPASS[:2]):
        own = [values["ve"], values["vn"], -values["vd"] if "vd" in values else zero]
    elif values.keys() >= set(POLAR):
        course = np.radians(values["course"])
        up = values.get("vz", -values["vd"] if "vd" in values else zero)
        own = [values["speed"] * np.sin(course), values["speed"] * np.cos(course), up]
    else:
        return None
    if sign(rows.time_s, first[:, 2], own[2]) < 0.0:
        _note(table, "the vertical velocity is positive when the height falls; its sign is turned")
        own[2] = -own[2]
    velocity: Floats = np.column_stack(own)
    if values.keys() >= set(VELOCITY_2[:2]):
        velocity = velocity - np.column_stack([values.get(key, zero) for key in VELOCITY_2])
    return velocity


def _note(table: Table, note: str) -> None:
    if note not in table.file.notes:
        table.file.notes.append(note)


def _merged(table: Table, rows: Rows, source: Truth) -> dict[str, Floats]:
    """What the table of the truth says at the times of a link's rows, on the straight line between two of its rows."""
    links = source.links
    truth = links.get(rows.link) or (next(iter(links.values())) if len(links) == 1 else None)
    if truth is None:
        raise ParamsError(
            f"truth of log {table.source!r} has no rows of link {rows.link!r}, only of "
            f"{', '.join(map(repr, list(links)[:5]))}"
        )
    order = np.argsort(truth["t"], kind="stable")
    time_s = truth["t"][order]
    good = np.isfinite(time_s) & (truth["reason"][order] == 0)
    order, time_s = order[good], time_s[good]
    mine = rows.time_s[np.isfinite(rows.time_s)]
    if not time_s.size or not mine.size or time_s[0] > mine.max() or time_s[-1] < mine.min():
        spans = " and ".join(
            f"{part.min():.3f} to {part.max():.3f} s" if part.size else "no time at all" for part in (mine, time_s)
        )
        raise ParamsError(
            f"log {table.source!r} and its truth have no time in common: {spans}; both need the same clock"
        )
    limit_s = max(GAP_MAX_S, GAP_INTERVALS * float(np.median(np.diff(time_s)))) if time_s.size > 1 else GAP_MAX_S
    rows.drop(~bracketed(rows.time_s, time_s, limit_s), NO_POSITION)
    keys = truth.keys() - {"t", "number", "reason", "rss"}
    merged = {}
    for key in keys:
        values = truth[key][order]
        known = np.isfinite(values)
        if known.any():
            merged[key] = np.interp(rows.time_s, time_s[known], values[known])
    return merged


def bracketed(at_s: Floats, time_s: Floats, limit_s: float) -> np.ndarray:
    """Whether a time has a neighbour on both sides, these at most so far apart, or is one of them."""
    after = np.searchsorted(time_s, at_s)
    later, earlier = np.minimum(after, time_s.size - 1), np.maximum(after - 1, 0)
    inside = (after > 0) & (after < time_s.size) & (time_s[later] - time_s[earlier] <= limit_s)
    near: np.ndarray = inside | (time_s[later] == at_s)
    return near
