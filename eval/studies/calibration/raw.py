"""Raw logs against the clean table of the same flights: how well a channel fitted to each ranges."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from rss_gym.calibration.logs import READERS, read, told
from rss_gym.calibration.simulated import HOME, WRITERS, SimulatedFlight, fly, write
from rss_gym.eval.studies.calibration.calibrate import calibrate
from rss_gym.pages.table import Table

FLIGHTS, FITTED, SECONDS, RATE_HZ = 8, 4, 240.0, 2.0
STATION: dict[str, Any] = {"station": HOME}
# What a format does not say itself, as on the command line.
OPTIONS: dict[str, tuple[str, dict[str, Any]]] = {
    "positions": ("--station", STATION),
    "wide": ("--melt", {"melt": "*"}),
    "bare": ("--columns 1=t,2=rss,3=dist", {"columns": {"1": "t", "2": "rss", "3": "dist"}}),
    "relative": ("--offset-db -120", {"offset_db": -120.0}),
    "edgetx": ("--station", STATION),
    "rosbag": ("--columns rss=TOPIC.FIELD --station", {"columns": {"rss": "/radio/rssi.data"}, **STATION}),
    "mcap": ("--columns rss=TOPIC.FIELD --station", {"columns": {"rss": "/radio/rssi.data"}, **STATION}),
}
METHODS = {"ls": "LS", "ekf-white": "white", "ekf-coloured": "coloured", "ekf-coloured-rate": "coloured, velocity"}


def table() -> str:
    """A row for each format, as Markdown."""
    flights = [fly("outdoor", SECONDS, RATE_HZ, seed) for seed in range(FLIGHTS)]
    heads = ("log", "read as", "options", "rows used", "dropped", *METHODS.values())
    return Table(heads, (row(flights, name) for name in WRITERS)).markdown


def row(flights: list[SimulatedFlight], name: str) -> tuple[str, ...]:
    """One format: fitted to half of the flights, tested on the others, the link at the ground."""
    said, options = OPTIONS.get(name, ("", {}))
    with tempfile.TemporaryDirectory() as folder:
        paths = [write(flight, name, Path(folder) / f"{k}.log") for k, flight in enumerate(flights)]
        logs = read(paths, **options)
        format = READERS[told(paths[0]) or "csv"].title
    chosen = [record for record in logs if record.link not in ("aircraft", "downlink")]
    result = calibrate(
        [record for record in chosen if record.file < FITTED], [record for record in chosen if record.file >= FITTED]
    )
    errors = [f"{result.scores[key].p80_m.value:.2f}" if key in result.scores else "–" for key in METHODS]
    used, dropped = sum(record.time_s.size for record in chosen), sum(record.dropped for record in chosen)
    return (name, format, f"`{said}`" if said else "", f"{used:,}", f"{dropped:,}", *errors)
