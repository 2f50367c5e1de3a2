"""A simulated flight as autopilots and ground stations write it."""

from __future__ import annotations

import math
import struct
from types import ModuleType
from typing import Any

import numpy as np

from rss_gym.calibration.simulated.flight import HOME, START_S, SimulatedFlight
from rss_gym.params import ParamsError

_POSITIONS_HZ, _HEARTBEAT_S = 4.0, 1.0


def sik_raw(rss_dbm: float) -> int:
    """A SiK radio's 8-bit report of an RSS; 0 where nothing was received."""
    return 0 if math.isnan(rss_dbm) else int(np.clip(round(1.9 * (rss_dbm + 127.0)), 1, 254))


def write_mavlink(flight: SimulatedFlight) -> bytes:
    """A telemetry log: heartbeats, home, positions, and each report as RADIO and as RADIO_STATUS."""
    dialect = _dialect()
    vehicle, radio = (dialect.MAVLink(None, srcSystem=system, srcComponent=part) for system, part in ((1, 1), (51, 68)))
    packets: list[tuple[float, Any, Any]] = []
    home = (round(HOME[0] * 1e7), round(HOME[1] * 1e7), round(HOME[2] * 1e3))
    for time_s in np.arange(0.0, flight.time_s[-1], 5.0).tolist():
        packets.append((time_s, vehicle, dialect.MAVLink_home_position_message(*home, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0)))
    for time_s in np.arange(0.0, flight.time_s[-1], _HEARTBEAT_S).tolist():
        mode = 128 * int(np.interp(time_s, flight.time_s, flight.armed) > 0.5)
        packets.append((time_s, vehicle, dialect.MAVLink_heartbeat_message(2, 3, mode, 0, 4, 3)))
    for time_s in np.arange(0.0, flight.time_s[-1], 1.0 / _POSITIONS_HZ).tolist():
        lat, lon, alt, height, east, north, up = _state(flight, time_s)
        place = (round(lat * 1e7), round(lon * 1e7), round(alt * 1e3), round(height * 1e3))
        velocity = (round(100.0 * north), round(100.0 * east), round(-100.0 * up))
        packets.append(
            (time_s, vehicle, dialect.MAVLink_global_position_int_message(round(1e3 * time_s), *place, *velocity, 0))
        )
    for k, time_s in enumerate(flight.time_s.tolist()):
        report = (
            sik_raw(flight.rss_dbm[0, k]),
            sik_raw(flight.rss_dbm[1, k]),
            100,
            40 + k % 7,
            42 + k % 5,
            k % 65536,
            0,
        )
        packets.append((time_s + 0.02, radio, dialect.MAVLink_radio_message(*report)))
        packets.append((time_s + 0.021, radio, dialect.MAVLink_radio_status_message(*report)))
    content = bytearray()
    for time_s, sender, message in sorted(packets, key=lambda packet: packet[0]):
        content += struct.pack(">Q", round((START_S + time_s) * 1e6)) + message.pack(sender)
    return bytes(content)


def _state(flight: SimulatedFlight, time_s: float) -> tuple[float, ...]:
    """Latitude, longitude, altitude, height and velocity at a time."""
    columns = (
        flight.latitude, flight.longitude, flight.altitude_m, flight.position_m[:, 2], *flight.velocity_mps.T,
    )  # fmt: skip
    return tuple(float(np.interp(time_s, flight.time_s, column)) for column in columns)


def _dialect() -> ModuleType:
    try:
        from pymavlink.dialects.v20 import ardupilotmega
    except ImportError as error:
        raise ParamsError("writing MAVLink logs needs pymavlink: pip install -e '.[mavlink]' in the clone") from error
    return ardupilotmega


# DataFlash: type, name, format, columns.
_FORMATS = {
    128: ("FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
    140: ("GPS", "QBBIHBcLLeffffB", "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U"),
    141: ("POS", "QLLfff", "TimeUS,Lat,Lng,Alt,RelHomeAlt,RelOriginAlt"),
    142: ("RAD", "QBBBBBHH", "TimeUS,RSSI,RemRSSI,TxBuf,Noise,RemNoise,RxErrors,Fixed"),
    143: ("EV", "QB", "TimeUS,Id"),
    144: ("ORGN", "QBLLe", "TimeUS,Type,Lat,Lng,Alt"),
}
_CODES = {
    "B": "B",
    "H": "H",
    "I": "I",
    "Q": "Q",
    "L": "i",
    "c": "h",
    "e": "i",
    "f": "f",
    "n": "4s",
    "N": "16s",
    "Z": "64s",
}
_GPS_EPOCH_S, _WEEK_S, _LEAP_S = 315_964_800.0, 604_800.0, 18.0


def write_dataflash(flight: SimulatedFlight) -> bytes:
    """A DataFlash log: GPS and POS at 5 Hz, RAD at the rate of the RSS, arming and home as events."""
    content = bytearray()
    for kind, (name, layout, columns) in _FORMATS.items():
        length = 3 + struct.calcsize("<" + "".join(_CODES[code] for code in layout))
        content += _dataflash(128, kind, length, name.encode(), layout.encode(), columns.encode())
    rows: list[tuple[float, bytes]] = []
    last_s = -1.0
    for k, time_s in enumerate(flight.time_s.tolist()):
        micro = round(1e6 * (time_s + 10.0))
        lat, lon, alt, height, east, north, up = _state(flight, time_s)
        place = (round(lat * 1e7), round(lon * 1e7))
        if time_s - last_s >= 0.2 - 1e-9:
            last_s = time_s
            gps_s = START_S + time_s - _GPS_EPOCH_S + _LEAP_S
            week, in_week = divmod(gps_s, _WEEK_S)
            course = math.degrees(math.atan2(east, north)) % 360.0
            rows.append(
                (time_s, _dataflash(140, micro, 0, 3, round(1e3 * in_week), int(week), 12, 80, *place, round(100 * alt),
                                    math.hypot(east, north), course, -up, 0.0, 1))
            )  # fmt: skip
            rows.append((time_s, _dataflash(141, micro, *place, alt, height, height)))
        raw = (sik_raw(flight.rss_dbm[1, k]), sik_raw(flight.rss_dbm[0, k]))
        rows.append((time_s, _dataflash(142, micro, *raw, 100, 40 + k % 7, 42 + k % 5, k % 65536, 0)))
    armed = flight.time_s[flight.armed]
    for time_s, event in ((armed[0], 10), (armed[-1], 11)):
        rows.append((float(time_s), _dataflash(143, round(1e6 * (time_s + 10.0)), event)))
    home = (round(HOME[0] * 1e7), round(HOME[1] * 1e7), round(100 * HOME[2]))
    rows.append((float(armed[0]), _dataflash(144, round(1e6 * (armed[0] + 10.0)), 0, *home)))
    return bytes(content) + b"".join(row for _, row in sorted(rows, key=lambda row: row[0]))


def _dataflash(kind: int, *values: Any) -> bytes:
    layout = "<" + "".join(_CODES[code] for code in _FORMATS[kind][1])
    return bytes((0xA3, 0x95, kind)) + struct.pack(layout, *values)


# ULog: name, fields.
_TOPICS = {
    "radio_status": "uint64_t timestamp;uint8_t rssi;uint8_t remote_rssi;uint8_t noise;uint8_t remote_noise;",
    "vehicle_global_position": "uint64_t timestamp;double lat;double lon;float alt;",
    "vehicle_local_position": "uint64_t timestamp;float vx;float vy;float vz;",
    "home_position": "uint64_t timestamp;double lat;double lon;float alt;",
    "vehicle_status": "uint64_t timestamp;uint8_t arming_state;",
    "vehicle_land_detected": "uint64_t timestamp;uint8_t landed;",
}
_TYPES = {"uint64_t": "Q", "uint8_t": "B", "double": "d", "float": "f"}
_LAYOUTS = {
    name: "<" + "".join(_TYPES[field.split()[0]] for field in fields.rstrip(";").split(";"))
    for name, fields in _TOPICS.items()
}


def write_ulog(flight: SimulatedFlight) -> bytes:
    """A ULog file: radio_status at the rate of the RSS, positions at 4 Hz, arming, landing and home."""
    content = bytearray(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0))
    content += _ulog(b"B", bytes(40))
    for name, fields in _TOPICS.items():
        content += _ulog(b"F", f"{name}:{fields}".encode())
    numbers = {name: number for number, name in enumerate(_TOPICS)}
    for name, number in numbers.items():
        content += _ulog(b"A", struct.pack("<BH", 0, number) + name.encode())
    rows: list[tuple[float, str, tuple[Any, ...]]] = []
    for k, time_s in enumerate(flight.time_s.tolist()):
        rows.append(
            (time_s, "radio_status", (sik_raw(flight.rss_dbm[1, k]), sik_raw(flight.rss_dbm[0, k]), 40 + k % 7, 40))
        )
    for time_s in np.arange(0.0, flight.time_s[-1], 1.0 / _POSITIONS_HZ).tolist():
        lat, lon, alt, height, east, north, up = _state(flight, time_s)
        rows.append((time_s, "vehicle_global_position", (lat, lon, alt)))
        rows.append((time_s, "vehicle_local_position", (north, east, -up)))
        rows.append((time_s, "vehicle_land_detected", (int(height < 0.5),)))
        rows.append((time_s, "vehicle_status", (1 + int(np.interp(time_s, flight.time_s, flight.armed) > 0.5),)))
    rows.append((float(flight.time_s[flight.armed][0]), "home_position", HOME))
    for time_s, name, values in sorted(rows, key=lambda row: row[0]):
        data = struct.pack(_LAYOUTS[name], round(1e6 * (time_s + 10.0)), *values)
        content += _ulog(b"D", struct.pack("<H", numbers[name]) + data)
    return bytes(content)


def _ulog(kind: bytes, data: bytes) -> bytes:
    return struct.pack("<H", len(data)) + kind + data
