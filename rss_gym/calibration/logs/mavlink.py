"""Radio logs in MAVLink telemetry logs: what a SiK radio reports of both its ends, and where the aircraft was."""

from __future__ import annotations

import mmap
import re
import struct
from array import array
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from rss_gym.calibration.logs.geodesy import east_north_up_m, range_rate_mps
from rss_gym.calibration.logs.record import ROWS_MAX, Floats, LogFile, LogRecord
from rss_gym.params import ParamsError

GAP_MAX_S = 2.0  # between the positions on both sides of a radio report
NEAREST_M = 1.0  # the reference distance of (2); an aircraft on its launch point says nothing about path loss
_HEAD = struct.Struct(">Q")  # microseconds since 1970 before each packet
_MAGIC = re.compile(b"[\xfd\xfe]")  # first byte of a packet, MAVLink 2 and 1
_WANTED = ("RADIO", "RADIO_STATUS", "GLOBAL_POSITION_INT", "HOME_POSITION")


def sik_dbm(raw: Floats) -> Floats:
    """RSS of a SiK radio's 8-bit report: raw / 1.9 - 127 (ArduPilot's wiki); 0 and 255 say that there is none: NaN."""
    return np.where((raw > 0.0) & (raw < 255.0), raw / 1.9 - 127.0, np.nan)


def read_telemetry(path: Path, columns: Mapping[str, str]) -> LogFile:
    """Read a telemetry log (.tlog) that a ground station wrote.

    Two links: `ground` is the RSS at the ground's radio (`rssi` of RADIO_STATUS or RADIO), `aircraft` that at the
    aircraft's (`remrssi`). The aircraft is where GLOBAL_POSITION_INT says, between two messages on the straight line;
    the ground station at the last HOME_POSITION, else where the aircraft first was.

    Parameters
    ----------
    path : Path
        The file.
    columns : mapping
        Empty: these logs name their quantities themselves.

    Raises
    ------
    ParamsError
        When pymavlink is not installed, or the file is not a telemetry log with radio reports and positions.
    """
    if columns:
        raise ParamsError(f"columns are for tables and do not apply to MAVLink logs, got {dict(columns)!r}")
    flight = _Flight(path.name)
    for time_s, message in _messages(path):
        flight.take(time_s, message)
    return flight.finish()


class _Flight:
    """What was taken from the messages of one log."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.reports = array("d")  # time, rssi, remrssi
        self.positions = array("d")  # time, latitude, longitude, altitude, velocity east, north, up
        self.home: tuple[float, float, float] | None = None
        self.vehicles: set[int] = set()

    def take(self, time_s: float, message: Any) -> None:
        """Keep what is needed of one message; a position of 0, 0 stands for one that is not known."""
        kind = message.get_type()
        if kind in ("RADIO", "RADIO_STATUS"):
            self.reports.extend((time_s, message.rssi, message.remrssi))
        elif kind == "HOME_POSITION" and (message.latitude or message.longitude):
            self.home = (message.latitude * 1e-7, message.longitude * 1e-7, message.altitude * 1e-3)
        elif kind == "GLOBAL_POSITION_INT" and (message.lat or message.lon):
            self.vehicles.add(message.get_srcSystem())
            self.positions.extend((time_s, message.lat * 1e-7, message.lon * 1e-7, message.alt * 1e-3))
            self.positions.extend((message.vy * 1e-2, message.vx * 1e-2, -message.vz * 1e-2))
        if len(self.reports) > 3 * ROWS_MAX or len(self.positions) > 7 * ROWS_MAX:
            raise ParamsError(f"log {self.source!r} has more than {ROWS_MAX:,} messages; split it")

    def finish(self) -> LogFile:
        """Both links, and what had to be assumed or left out."""
        if not self.reports or not self.positions:
            lacking = "RADIO_STATUS or RADIO" if not self.reports else "GLOBAL_POSITION_INT with a position"
            raise ParamsError(f"log {self.source!r} holds no message {lacking}; both are needed")
        if len(self.vehicles) > 1:
            raise ParamsError(
                f"log {self.source!r} holds positions of several vehicles, systems {sorted(self.vehicles)}; it must be "
                "known which one the radio is on, so give a log with one"
            )
        reports = self._in_order("radio report", self.reports, 3)
        positions = self._in_order("position", self.positions, 7)
        notes = []
        if self.home is None:
            notes.append("no HOME_POSITION, so the ground station is taken to be at the aircraft's first position")
        ground = np.array([self.home or positions[0, 1:4]])
        track_m = east_north_up_m(positions[:, 1:4], ground)

        at_s = reports[:, 0]
        relative_m = _interpolated(at_s, positions[:, 0], track_m)
        distance_m = np.linalg.norm(relative_m, axis=1)
        usable = _bracketed(at_s, positions[:, 0]) & (distance_m >= NEAREST_M)
        if not usable.all():
            notes.append(
                f"{np.sum(~usable)} of {usable.size} radio reports left out: nearer than {NEAREST_M:g} m to the ground "
                f"station, or without positions at most {GAP_MAX_S:g} s apart before and after"
            )
        rate_mps = np.zeros(at_s.size)
        relative_mps = _interpolated(at_s, positions[:, 0], positions[:, 4:])
        rate_mps[usable] = range_rate_mps(relative_m[usable], relative_mps[usable])
        records, rows, dropped = [], 0, 0
        for link, raw in (("ground", reports[:, 1]), ("aircraft", reports[:, 2])):
            rss_dbm = sik_dbm(raw)
            keep = usable & (rss_dbm < 0.0)
            lost = int(usable.sum() - keep.sum())
            time_s = at_s[keep] - at_s[0]
            records.append(LogRecord(link, self.source, time_s, rss_dbm[keep], distance_m[keep], rate_mps[keep], lost))
            rows, dropped = rows + int(usable.sum()), dropped + lost
        return LogFile(self.source, records, rows, dropped, tuple(notes))

    def _in_order(self, what: str, values: array[float], width: int) -> Floats:
        """The messages as rows; one that repeats the time before it is left out."""
        table = np.frombuffer(values).reshape(-1, width)
        step_s = np.diff(table[:, 0], prepend=-np.inf)
        if (step_s < 0.0).any():
            number = int(np.argmax(step_s < 0.0))
            raise ParamsError(
                f"log {self.source!r}: {what} {number + 1} is stamped {-step_s[number]:.6g} s before the previous one; "
                "the stamps must increase"
            )
        return table[step_s > 0.0]


def _interpolated(at_s: Floats, time_s: Floats, values: Floats) -> Floats:
    return np.column_stack([np.interp(at_s, time_s, column) for column in values.T])


def _bracketed(at_s: Floats, time_s: Floats) -> Any:
    """Whether a time has a neighbour on both sides, these not too far apart."""
    after = np.searchsorted(time_s, at_s)
    inside = (after > 0) & (after < time_s.size)
    later, earlier = np.minimum(after, time_s.size - 1), np.maximum(after - 1, 0)
    return inside & (time_s[later] - time_s[earlier] <= GAP_MAX_S)


def _messages(path: Path) -> Iterator[tuple[float, Any]]:
    """The wanted messages of a telemetry log with their times, s; the file is mapped, not loaded.

    `pymavlink.mavutil` would read the same, but it decodes every message and changes environment variables.
    """
    dialect = _dialect()
    if path.stat().st_size == 0:
        raise ParamsError(f"log {path.name!r} is empty; it must be a MAVLink telemetry log")
    wanted = {getattr(dialect, f"MAVLINK_MSG_ID_{name}") for name in _WANTED}
    parser = dialect.MAVLink(None)
    found = False
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        for start, end, number in _packets(data):
            found = True
            if number not in wanted:
                continue
            try:
                message = parser.decode(bytearray(data[start:end]))
            except dialect.MAVError:  # damaged on its way
                continue
            yield _HEAD.unpack_from(data, start - _HEAD.size)[0] * 1e-6, message
    if not found:
        raise ParamsError(f"log {path.name!r} is not a MAVLink telemetry log (.tlog): it holds no packet")


def _packets(data: mmap.mmap) -> Iterator[tuple[int, int, int]]:
    """Where packets start and end, and the numbers of their messages.

    What follows a packet must be a stamp and the next packet, or the end; after a damaged stretch the search goes on
    at the next byte that may begin a packet.
    """
    size, start = len(data), _HEAD.size
    while start + 12 <= size:
        end, number = _frame(data, start)
        follows = end + _HEAD.size
        if end <= size and (follows >= size or data[follows] in b"\xfd\xfe"):
            yield start, end, number
            start = follows
        else:
            start = _next_magic(data, start + 1)


def _next_magic(data: mmap.mmap, start: int) -> int:
    """In a function of its own, as a match that lives on would keep the map from closing."""
    found = _MAGIC.search(data, start)
    return found.start() if found else len(data)


def _frame(data: mmap.mmap, start: int) -> tuple[int, int]:
    """End of the packet at `start` and number of its message; the end is beyond any file when none starts there."""
    if data[start] == 0xFE:
        return start + 8 + data[start + 1], data[start + 5]
    if data[start] == 0xFD:
        signature = 13 * (data[start + 2] & 1)
        return start + 12 + data[start + 1] + signature, int.from_bytes(data[start + 7 : start + 10], "little")
    return len(data) + 1, -1


def _dialect() -> ModuleType:
    try:
        from pymavlink.dialects.v20 import ardupilotmega
    except ImportError as error:
        raise ParamsError(
            "reading MAVLink logs needs pymavlink, which is not installed: pip install 'rss-gym[mavlink]'"
        ) from error
    return ardupilotmega
