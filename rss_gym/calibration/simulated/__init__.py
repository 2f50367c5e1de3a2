"""Logs of simulated flights, written as real ones are: `rss-gym simulate-log`."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path

from rss_gym.calibration.simulated.autopilots import write_dataflash, write_mavlink, write_ulog
from rss_gym.calibration.simulated.bag import write_bag, write_mcap
from rss_gym.calibration.simulated.flight import HOME, SimulatedFlight, fly
from rss_gym.calibration.simulated.tables import TABLES
from rss_gym.params import ParamsError, suggestion

__all__ = ["HOME", "WRITERS", "SimulatedFlight", "fly", "write"]

Writer = Callable[[SimulatedFlight], bytes]

WRITERS: Mapping[str, Writer] = {
    **TABLES,
    "mavlink": write_mavlink,
    "dataflash": write_dataflash,
    "ulog": write_ulog,
    "rosbag": write_bag,
    "mcap": write_mcap,
}


def write(flight: SimulatedFlight, format: str, out: str | os.PathLike[str]) -> Path:
    """Write a flight's log in one of `WRITERS`; an older file of that name is not replaced.

    Raises
    ------
    ParamsError
        For an unknown format, a missing library, or a file that is there or cannot be written.
    """
    if format not in WRITERS:
        raise ParamsError(f"format {format!r} is unknown{suggestion(format, WRITERS)}")
    path = Path(out)
    content = WRITERS[format](flight)
    temporary = path.with_name(f".{path.name[:80]}-{os.getpid()}")
    try:
        if os.path.lexists(path):
            raise ParamsError(f"file {os.fspath(out)!r} exists; name a new one")
        temporary.write_bytes(content)
        temporary.rename(path)
    except (OSError, ValueError) as error:
        temporary.unlink(missing_ok=True)
        raise ParamsError(f"file {os.fspath(out)!r} cannot be written: {error}") from error
    return path
