"""Simulated flights, written in every format."""

import pytest

from rss_gym.calibration.simulated import HOME, fly, write

STATION = {"station": HOME}
# What a format does not say itself.
OPTIONS = {
    "positions": STATION,
    "wide": {"melt": "*"},
    "bare": {"columns": {"1": "t", "2": "rss", "3": "dist"}},
    "relative": {"offset_db": -120.0},
    "edgetx": STATION,
    "rosbag": {"columns": {"rss": "/radio/rssi.data"}, **STATION},
    "mcap": {"columns": {"rss": "/radio/rssi.data"}, **STATION},
}
SUFFIXES = {"mavlink": "tlog", "dataflash": "bin", "ulog": "ulg", "rosbag": "bag", "mcap": "mcap"}


@pytest.fixture(scope="session")
def flight():
    """Three minutes at 5 Hz."""
    return fly("outdoor", seconds=180.0, rate_hz=5.0, seed=3)


@pytest.fixture(scope="session")
def written(flight, tmp_path_factory):
    """`written(format)`: the flight's log and the options to read it with."""
    folder = tmp_path_factory.mktemp("written")

    def path(format):
        name = folder / f"{format}.{SUFFIXES.get(format, 'csv')}"
        if not name.exists():
            write(flight, format, name)
        return name, OPTIONS.get(format, {})

    return path
