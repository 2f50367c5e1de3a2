"""Radio logs in MAVLink telemetry logs: what a SiK radio reports of both its ends, and where the aircraft was."""

from __future__ import annotations

import mmap
import re
import struct
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from rss_gym.calibration.logs.options import ReadOptions
from rss_gym.calibration.logs.record import LogFile
from rss_gym.calibration.logs.telemetry import Telemetry, sik_dbm
from rss_gym.params import ParamsError

_HEAD = struct.Struct(">Q")  # microseconds since 1970 before each packet
_MAGIC = re.compile(b"[\xfd\xfe]")  # first byte of a packet, MAVLink 2 and 1
_WANTED = ("RADIO", "RADIO_STATUS", "GLOBAL_POSITION_INT", "HOME_POSITION", "HEARTBEAT", "EXTENDED_SYS_STATE")
_ARMED, _ON_GROUND, _IN_AIR = 128, 1, 2
_GROUND_STATION, _NO_AUTOPILOT = 6, 8
# A stamp of 2000 to 2100 in these units, in s; ground stations write microseconds.
_STAMPS = ((9.4e14, 4.2e15, 1e-6), (9.4e11, 4.2e12, 1e-3), (9.4e8, 4.2e9, 1.0), (9.4e17, 4.2e18, 1e-9))


def is_telemetry(head: bytes) -> bool:
    """Whether a file may begin with a stamped packet."""
    return len(head) > 8 and head[8] in b"\xfd\xfe"


def read_telemetry(path: Path, options: ReadOptions) -> LogFile:
    """Read a telemetry log (.tlog) that a ground station wrote.

    Two links for each sender: `ground` is the RSS at the ground's radio (`rssi` of RADIO_STATUS or RADIO), `aircraft`
    that at the aircraft's (`remrssi`). RADIO and RADIO_STATUS of one report are one. The aircraft is where
    GLOBAL_POSITION_INT says, between two messages on the straight line; the ground station at the HOME_POSITION of that
    time, else where the aircraft was first armed, else where it first was. The vertical velocity has the sign of the
    altitude's change.

    Parameters
    ----------
    path : Path
        The file.
    options : ReadOptions
        Without columns: these logs name their quantities themselves.

    Raises
    ------
    ParamsError
        When pymavlink is not installed, or the file is not a telemetry log with radio reports and positions.
    """
    if options.columns:
        raise ParamsError(f"columns are for tables and do not apply to MAVLink logs, got {dict(options.columns)!r}")
    telemetry = Telemetry(path.name, "MAVLink telemetry log")
    vehicles: Counter[tuple[int, int]] = Counter()
    for number, time_s, message in _messages(path):
        _take(telemetry, vehicles, number, time_s, message)
    autopilots = {f"{system}" for system, _ in vehicles}
    if autopilots & telemetry.positions.keys():  # a tracker or a ground station sends positions too
        for system in telemetry.positions.keys() - autopilots:
            count = len(telemetry.positions.pop(system)) // 8
            telemetry.notes.append(f"{count} positions of system {system} left out: it is no autopilot")
    return telemetry.file(options, ("RADIO_STATUS or RADIO", "GLOBAL_POSITION_INT"))


def _take(telemetry: Telemetry, vehicles: Counter[tuple[int, int]], number: int, time_s: float, message: Any) -> None:
    """Keep what is needed of one message."""
    kind, system = message.get_type(), message.get_srcSystem()
    if kind in ("RADIO", "RADIO_STATUS"):
        rssi, remote = sik_dbm(np.array([message.rssi, message.remrssi], float)).tolist()
        sender = f"{system}/{message.get_srcComponent()}"
        # Both messages carry these fields; equal ones are one report.
        mark = message.noise + 256.0 * (message.remnoise + 256.0 * (message.rxerrors + 65536.0 * message.fixed))
        telemetry.report(sender, time_s, (rssi, remote), mark, number, float(kind == "RADIO"))
    elif kind == "HOME_POSITION":
        telemetry.homes.extend((time_s, message.latitude * 1e-7, message.longitude * 1e-7, message.altitude * 1e-3))
    elif kind == "GLOBAL_POSITION_INT":
        place = (message.lat * 1e-7, message.lon * 1e-7, message.alt * 1e-3)
        velocity = (message.vy * 1e-2, message.vx * 1e-2, -message.vz * 1e-2)
        telemetry.position(f"{system}", time_s, place, velocity, message.relative_alt * 1e-3)
    elif kind == "EXTENDED_SYS_STATE" and message.landed_state in (_ON_GROUND, _IN_AIR):
        telemetry.landed.extend((time_s, float(message.landed_state == _ON_GROUND)))
    elif kind == "HEARTBEAT" and message.type != _GROUND_STATION and message.autopilot != _NO_AUTOPILOT:
        vehicles[system, message.get_srcComponent()] += 1
        telemetry.armed.extend((time_s, float(message.base_mode & _ARMED > 0)))


def _messages(path: Path) -> Iterator[tuple[int, float, Any]]:
    """The wanted messages of a telemetry log, with their numbers in it and their times in s; it is mapped, not loaded.

    `pymavlink.mavutil` would read the same, but it decodes every message and changes environment variables.
    """
    dialect = _dialect()
    if path.stat().st_size == 0:
        raise ParamsError(f"log {path.name!r} is empty; it must be a MAVLink telemetry log")
    wanted = {getattr(dialect, f"MAVLINK_MSG_ID_{name}") for name in _WANTED}
    parser = dialect.MAVLink(None)
    count, scale = 0, 0.0
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        for start, end, number in _packets(data):
            count += 1
            if number not in wanted:
                continue
            try:
                message = parser.decode(bytearray(data[start:end]))
            except dialect.MAVError:  # damaged on its way
                continue
            stamp = _HEAD.unpack_from(data, start - _HEAD.size)[0]
            scale = scale or next((factor for low, high, factor in _STAMPS if low <= stamp <= high), 1e-6)
            yield count, stamp * scale, message
    if not count:
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
            "reading MAVLink logs needs pymavlink, which is not installed: pip install -e '.[mavlink]' in the clone"
        ) from error
    return ardupilotmega
