"""Tables that EdgeTX and OpenTX transmitters write: the link's RSS with the telemetry of the aircraft."""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path

import numpy as np

from rss_gym.calibration.logs.clock import time_parser
from rss_gym.calibration.logs.dialect import split
from rss_gym.calibration.logs.options import ReadOptions
from rss_gym.calibration.logs.record import CORRUPT, ROWS_MAX, Floats, LogFile, Rows
from rss_gym.calibration.logs.telemetry import Telemetry
from rss_gym.params import ParamsError

RELATIVE_DBM = -130.0  # FrSky's RSSI counts up from about the receiver's floor
REPEATED_S = 1.0
_BEGIN = re.compile(rb"^(\xef\xbb\xbf)?Date,Time,")
# Columns of RSS: the receiver's two antennas, the transmitter's, FrSky's relative one.
_LINKS = {"1RSS(dB)": "uplink 1", "2RSS(dB)": "uplink 2", "TRSS(dB)": "downlink", "RSSI(dB)": "receiver"}
_SPEEDS = {"kts": 0.514444, "kmh": 1.0 / 3.6, "km/h": 1.0 / 3.6, "m/s": 1.0, "mph": 0.44704}


def is_edgetx(head: bytes) -> bool:
    """Whether a file begins with EdgeTX' columns and has a link's RSS among them."""
    line = head.split(b"\n", 1)[0]
    return bool(_BEGIN.match(head)) and any(name.encode() in line for name in _LINKS)


def read_edgetx(path: Path, options: ReadOptions) -> LogFile:
    """Read a transmitter's log: Date, Time, RSS in dB, and GPS in one column.

    A receiver that repeats its last fix is where it said first; the height is the barometer's or the GPS' altitude. The
    ground station is where the aircraft first was, unless `--station` is given.

    Raises
    ------
    ParamsError
        If there is no GPS column, or too many rows are damaged.
    """
    if options.columns:
        raise ParamsError(
            f"columns do not apply to EdgeTX tables, got {dict(options.columns)!r}; use --format csv to name them"
        )
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        header = [name.strip() for name in split(file.readline(), ",")]
        lacking = next((name for name in ("Date", "Time", "GPS") if name not in header), None)
        links = [name for name in _LINKS if name in header]
        if lacking is not None or not links:
            raise ParamsError(
                f"log {path.name!r} has no column {lacking or ' or '.join(_LINKS)}, which an EdgeTX table needs; "
                "it has "
                f"{', '.join(header[:40])[:300]!r}"
            )
        telemetry = Telemetry(path.name, "EdgeTX table", tuple(_LINKS[name] for name in links))
        at = {name: header.index(name) for name in (*links, "GPS", "Date", "Time")}
        altitude = next((k for name in ("Alt", "GAlt") for k, column in enumerate(header) if _unit(column, name)), None)
        speed = next((k for k, column in enumerate(header) if _unit(column, "GSpd")), None)
        course = next((k for k, column in enumerate(header) if _unit(column, "Hdg")), None)
        climb = next((k for k, column in enumerate(header) if _unit(column, "VSpd")), None)
        speed_factor = _SPEEDS.get(_unit(header[speed], "GSpd") or "", 1.0) if speed is not None else 1.0
        height_factor = 0.3048 if altitude is not None and "(ft)" in header[altitude] else 1.0
        table: list[list[float]] = []
        places: list[tuple[float, ...]] = []
        bad: list[int] = []
        parser = None
        for number, line in enumerate(file, 2):
            if number > ROWS_MAX:
                raise ParamsError(f"log {path.name!r} has more than {ROWS_MAX:,} lines; split it")
            try:
                cells = split(line, ",")
                if len(cells) < len(header):
                    raise ValueError("too few cells")
                stamp = f"{cells[at['Date']].strip()} {cells[at['Time']].strip()}"
                parser = parser or time_parser(stamp)
                if parser is None:
                    raise ValueError(stamp)
                time_s = parser[1](stamp)
                powers = [float(cells[at[name]]) for name in links]
            except (ValueError, csv.Error, StopIteration):
                bad.append(number)
                continue
            table.append([number, time_s, *powers])
            fix = cells[at["GPS"]].split()
            if len(fix) == 2:
                try:
                    height_m = float(cells[altitude]) * height_factor if altitude is not None else 0.0
                    mps = float(cells[speed]) * speed_factor if speed is not None else math.nan
                    angle = math.radians(float(cells[course])) if course is not None else math.nan
                    up = float(cells[climb]) if climb is not None else 0.0
                    place = (float(fix[0]), float(fix[1]), height_m)
                except ValueError:
                    continue
                places.append((time_s, *place, mps * math.sin(angle), mps * math.cos(angle), up))
    return _file(telemetry, np.array(table, float).reshape(-1, 2 + len(links)), places, bad, options)


def _file(
    telemetry: Telemetry, table: Floats, places: list[tuple[float, ...]], bad: list[int], options: ReadOptions
) -> LogFile:
    last, last_s = (math.nan, math.nan), -math.inf
    for time_s, *rest in places:
        # A fix is repeated until the next; after a second it is one of an aircraft that stands.
        if (rest[0], rest[1]) != last or time_s - last_s >= REPEATED_S:
            telemetry.position("1", time_s, (rest[0], rest[1], rest[2]), (rest[3], rest[4], rest[5]))
            last, last_s = (rest[0], rest[1]), time_s
    names, files = telemetry.links, []
    for k, name in enumerate(names):
        powers = table[:, 2 + k]
        relative = bool((powers > 0.0).mean() > 0.5) if powers.size else False
        if relative:
            telemetry.notes.append(
                f"link {name!r} is relative power: {RELATIVE_DBM:g} dBm is added, besides --offset-db"
            )
        one = Telemetry(telemetry.source, telemetry.format, (name, "none"), positions=telemetry.positions, notes=[])
        for row in table.tolist():
            power = row[2 + k]
            level = power + RELATIVE_DBM if relative else power
            one.report("radio", row[1], (math.nan if power == 0.0 else level, math.nan), row[0], row[0])
        files.append(one.file(options, ("1RSS(dB), 2RSS(dB), TRSS(dB) or RSSI(dB)", "GPS")))
        telemetry.notes += [note for note in one.notes if note not in telemetry.notes]
    rows: list[Rows] = [rows for file in files for rows in file.rows]
    for line in bad:
        rows[0].number = np.append(rows[0].number, line)
        for field in ("time_s", "rss_dbm", "distance_m", "range_rate_mps"):
            values = getattr(rows[0], field)
            if values is not None:
                setattr(rows[0], field, np.append(values, math.nan))
        rows[0].reason = np.append(rows[0].reason, np.uint8(CORRUPT))
    file = LogFile(telemetry.source, telemetry.format, rows, "line", telemetry.notes)
    file.columns = {"rss": ", ".join(name for name, link in _LINKS.items() if link in names), "positions": "GPS"}
    if bad:
        file.example(CORRUPT, f"line {bad[0]}")
    return file


def _unit(column: str, name: str) -> str | None:
    """The unit in brackets of a column of that name."""
    found = re.fullmatch(rf"{name}\(([^)]*)\)", column)
    return found.group(1) if found else None
