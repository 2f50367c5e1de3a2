"""Radio logs in ArduPilot's DataFlash logs (.bin), which the autopilot writes on board."""

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

_ARMED, _DISARMED, _LANDED, _NOT_LANDED = 10, 11, 18, 28  # of EV
_HOME = 0  # of ORGN: where the aircraft is armed; 1 is the origin of the filter in older logs
_FIX_3D = 3
_KINDS = ("RAD", "RSSI", "POS", "GPS", "ORGN", "ARM", "EV")


def is_dataflash(head: bytes) -> bool:
    """Whether a file begins with the format of formats."""
    return head[:3] == b"\xa3\x95\x80"


def read_dataflash(path: Path, options: ReadOptions) -> LogFile:
    """Read a DataFlash log by pymavlink.

    RAD holds a SiK radio's report, `rssi` at the aircraft and `remrssi` at the ground. Without any, RSSI is taken: the
    receiver's share of its scale, relative power in 100 steps. The aircraft is where POS says, or GPS with a fix; its
    velocity is GPS'; the ground station is at ORGN, else where the aircraft was armed.

    Raises
    ------
    ParamsError
        When pymavlink is not installed, or the log lacks a radio or positions.
    """
    if options.columns:
        raise ParamsError(f"columns are for tables and do not apply to DataFlash logs, got {dict(options.columns)!r}")
    try:
        from pymavlink import DFReader
    except ImportError as error:
        raise ParamsError(
            "reading DataFlash logs needs pymavlink, which is not installed: pip install -e '.[mavlink]' in the clone"
        ) from error
    telemetry = Telemetry(path.name, "ArduPilot DataFlash log", ("aircraft", "ground"))
    receiver: list[tuple[float, float, int]] = []
    places: list[tuple[float, ...]] = []
    fixes: list[tuple[float, ...]] = []
    number = 0
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):  # it prints warnings
        log = DFReader.DFReader_binary.__new__(DFReader.DFReader_binary)  # at hand even where it fails to open
        try:
            log.__init__(str(path))
            while (message := log.recv_match(type=list(_KINDS))) is not None:
                number += 1
                _take(telemetry, message, number, receiver, places, fixes)
        except ParamsError:
            raise
        except Exception as error:  # it raises whatever a damaged byte leads to
            what = f"near message {number} of {', '.join(_KINDS)}: {type(error).__name__}"
            raise ParamsError(f"log {path.name!r} is a damaged DataFlash log, {what}") from error
        finally:
            if hasattr(log, "filehandle"):
                log.filehandle.close()
    _positions(telemetry, places, fixes)
    if not telemetry.reports and receiver:
        telemetry.links = ("receiver", "none")
        telemetry.notes.append("no RAD: RSSI is taken, relative power in per cent of the receiver's scale less 120 dBm")
        for time_s, power, at in receiver:
            telemetry.report("receiver", time_s, (power, math.nan), 0.0, at)
    return telemetry.file(options, ("RAD or RSSI", "POS or GPS"))


def _take(
    telemetry: Telemetry, message: Any, number: int, receiver: list[Any], places: list[Any], fixes: list[Any]
) -> None:
    kind, time_s = message.get_type(), float(message._timestamp)
    if kind == "RAD":
        powers = sik_dbm(np.array([message.RSSI, message.RemRSSI], float)).tolist()
        telemetry.report("RAD", time_s, (powers[0], powers[1]), float(message.Noise), number)
    elif kind == "RSSI":
        share = float(message.RXRSSI)
        receiver.append((time_s, 100.0 * share - 120.0 if 0.0 < share <= 1.0 else math.nan, number))
    elif kind == "POS":
        places.append((time_s, float(message.Lat), float(message.Lng), float(message.Alt), float(message.RelHomeAlt)))
    elif kind == "GPS" and message.Status >= _FIX_3D and getattr(message, "I", 0) == 0:
        course = math.radians(message.GCrs)
        velocity = (message.Spd * math.sin(course), message.Spd * math.cos(course), -message.VZ)
        fixes.append((time_s, float(message.Lat), float(message.Lng), float(message.Alt), *velocity))
    elif kind == "ORGN" and message.Type == _HOME:
        telemetry.homes.extend((time_s, message.Lat, message.Lng, message.Alt))
    elif kind == "ARM":
        telemetry.armed.extend((time_s, float(message.ArmState)))
    elif kind == "EV" and message.Id in (_ARMED, _DISARMED):
        telemetry.armed.extend((time_s, float(message.Id == _ARMED)))
    elif kind == "EV" and message.Id in (_LANDED, _NOT_LANDED):
        telemetry.landed.extend((time_s, float(message.Id == _LANDED)))


def _positions(telemetry: Telemetry, places: list[tuple[float, ...]], fixes: list[tuple[float, ...]]) -> None:
    """POS where there is any, with the velocity of GPS at that time; else GPS."""
    table = np.array(fixes, float).reshape(-1, 7)
    if not places:
        for fix in table.tolist():
            telemetry.position("1", fix[0], (fix[1], fix[2], fix[3]), (fix[4], fix[5], fix[6]))
        return
    for place in places:
        velocity = (math.nan,) * 3
        if len(table):
            k = int(np.argmin(np.abs(table[:, 0] - place[0]))) if len(table) < 64 else _nearest(table[:, 0], place[0])
            velocity = tuple(table[k, 4:].tolist()) if abs(table[k, 0] - place[0]) <= 1.0 else velocity
        telemetry.position(
            "1", place[0], (place[1], place[2], place[3]), (velocity[0], velocity[1], velocity[2]), place[4]
        )


def _nearest(times: Any, at: float) -> int:
    k = int(np.searchsorted(times, at))
    if k == 0 or k == len(times):
        return min(k, len(times) - 1)
    return k if times[k] - at < at - times[k - 1] else k - 1
