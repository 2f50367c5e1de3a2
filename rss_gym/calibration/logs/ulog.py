"""Radio logs in PX4's ULog files (.ulg)."""

from __future__ import annotations

import contextlib
import io
import math
from pathlib import Path
from typing import Any

import numpy as np

from rss_gym.calibration.logs.options import ReadOptions
from rss_gym.calibration.logs.record import LogFile
from rss_gym.calibration.logs.telemetry import Telemetry, sik_dbm
from rss_gym.params import ParamsError

_ARMED = 2  # arming_state of vehicle_status
_RADIO = ("radio_status", "telemetry_status")
_PLACES = ("vehicle_global_position", "vehicle_gps_position", "sensor_gps")
_WANTED = (*_RADIO, *_PLACES, "home_position", "vehicle_status", "vehicle_land_detected", "vehicle_local_position")


def is_ulog(head: bytes) -> bool:
    """Whether a file begins with ULog's mark."""
    return head[:7] == b"ULog\x01\x12\x35"


def read_ulog(path: Path, options: ReadOptions) -> LogFile:
    """Read a ULog file by pyulog.

    radio_status (telemetry_status in older logs) holds a SiK radio's report, `rssi` at the aircraft and `remote_rssi`
    at the ground; the aircraft is where vehicle_global_position says, or its GPS receiver; its velocity is that of
    vehicle_local_position or GPS; the ground station is at home_position, else where the aircraft was armed.

    Raises
    ------
    ParamsError
        When pyulog is not installed, the file is damaged, or lacks a radio or positions.
    """
    if options.columns:
        raise ParamsError(f"columns are for tables and do not apply to ULog files, got {dict(options.columns)!r}")
    try:
        from pyulog import ULog
    except ImportError as error:
        raise ParamsError(
            "reading ULog files needs pyulog, which is not installed: pip install -e '.[ulog]' in the clone"
        ) from error
    with contextlib.redirect_stdout(io.StringIO()), path.open("rb") as file:  # it prints what is damaged
        try:
            data = ULog(file, list(_WANTED)).data_list
        except Exception as error:  # it raises whatever a damaged byte leads to
            raise ParamsError(f"log {path.name!r} is a damaged ULog file: {type(error).__name__}") from error
    sets: dict[str, list[dict[str, Any]]] = {}
    for item in data:
        sets.setdefault(item.name, []).append(item.data)
    telemetry = Telemetry(path.name, "PX4 ULog", ("aircraft", "ground"))
    _reports(telemetry, sets)
    _positions(telemetry, sets)
    for home in sets.get("home_position", []):
        for time, lat, lon, alt in zip(_time_s(home), home["lat"], home["lon"], home["alt"], strict=True):
            telemetry.homes.extend((time, float(lat), float(lon), float(alt)))
    for status in sets.get("vehicle_status", []):
        _steps(telemetry.armed, status, "arming_state", _ARMED)
    for land in sets.get("vehicle_land_detected", []):
        _steps(telemetry.landed, land, "landed", 1)
    return telemetry.file(options, ("radio_status or telemetry_status with rssi", "vehicle_global_position or GPS"))


def _time_s(data: dict[str, Any]) -> Any:
    return np.asarray(data["timestamp"], float) * 1e-6


def _steps(values: Any, data: dict[str, Any], name: str, wanted: int) -> None:
    if name in data:
        for time, value in zip(_time_s(data), data[name], strict=True):
            values.extend((time, float(value == wanted)))


def _reports(telemetry: Telemetry, sets: dict[str, list[dict[str, Any]]]) -> None:
    name = next((name for name in _RADIO if any("rssi" in one for one in sets.get(name, []))), None)
    for k, data in enumerate(sets.get(name or "", [])):
        if "rssi" not in data or not np.asarray(data["rssi"]).any():
            continue
        remote = np.asarray(data.get("remote_rssi", np.zeros(len(data["rssi"]))), float)
        powers = zip(sik_dbm(np.asarray(data["rssi"], float)), sik_dbm(remote), strict=True)
        marks = np.asarray(data.get("noise", np.zeros(len(remote))), float)
        for number, (time, (rssi, far), mark) in enumerate(zip(_time_s(data), powers, marks, strict=True), 1):
            telemetry.report(f"{name}[{k}]", float(time), (float(rssi), float(far)), float(mark), number)


def _positions(telemetry: Telemetry, sets: dict[str, list[dict[str, Any]]]) -> None:
    name = next((name for name in _PLACES if sets.get(name)), None)
    if name is None:
        return
    data = sets[name][0]
    time_s = _time_s(data)
    if "latitude_deg" in data:
        place = [data["latitude_deg"], data["longitude_deg"], data["altitude_msl_m"]]
    elif name == "vehicle_global_position":
        place = [data["lat"], data["lon"], data["alt"]]
    else:
        place = [np.asarray(data["lat"]) * 1e-7, np.asarray(data["lon"]) * 1e-7, np.asarray(data["alt"]) * 1e-3]
    velocity = np.full((3, len(time_s)), math.nan)
    local = sets.get("vehicle_local_position", [])
    own = "vel_n_m_s" if "vel_n_m_s" in data else "vel_n" if "vel_n" in data else ""
    if own:
        tail = own.removeprefix("vel_n")
        velocity = np.array([data[f"vel_e{tail}"], data[own], -np.asarray(data[f"vel_d{tail}"])], float)
    elif local and len(local[0]["timestamp"]) > 1:
        parts = [np.interp(time_s, _time_s(local[0]), np.asarray(local[0][key], float)) for key in ("vy", "vx", "vz")]
        velocity = np.array([parts[0], parts[1], -parts[2]])
    table = np.column_stack([time_s, *(np.asarray(part, float) for part in place), velocity.T])
    for row in table.tolist():
        telemetry.position("1", row[0], (row[1], row[2], row[3]), (row[4], row[5], row[6]))
