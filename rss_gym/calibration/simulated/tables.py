"""A simulated flight as tables of the shapes that are found."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from datetime import UTC, datetime

import numpy as np

from rss_gym.calibration.simulated.flight import HOME, START_S, SimulatedFlight

SENTINEL_DBM = -200.0


def _text(header: Sequence[str], rows: Iterable[Sequence[object]], before: str = "", comma: str = ",") -> bytes:
    lines = [comma.join(header)] if header else []
    lines += [comma.join(map(str, row)) for row in rows]
    return (before + "\n".join(lines) + "\n").encode()


def _rss(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.1f}"


def csv(flight: SimulatedFlight) -> bytes:
    """Time in s, link, RSS, true distance and velocity: what needs no word; only what was flown."""
    rows = [
        (f"{flight.time_s[k]:.3f}", link, _rss(flight.rss_dbm[n, k]), f"{flight.distance_m[k]:.3f}", f"{rate:.3f}")
        for k, rate in enumerate(_rates(flight))
        if flight.flying[k]
        for n, link in enumerate(("ground", "aircraft"))
    ]
    return _text(("time_s", "link", "rss_dbm", "distance_m", "range_rate_mps"), rows)


def _rates(flight: SimulatedFlight) -> list[float]:
    rates: list[float] = (np.sum(flight.position_m * flight.velocity_mps, axis=1) / flight.distance_m).tolist()
    return rates


def positions(flight: SimulatedFlight) -> bytes:
    """ISO 8601 times, degrees, and a velocity whose vertical part points down; the station is named by `--station`."""
    rows = []
    for k in np.flatnonzero(flight.flying).tolist():
        stamp = datetime.fromtimestamp(START_S + flight.time_s[k], UTC).isoformat(timespec="milliseconds")
        east, north, up = flight.velocity_mps[k]
        place = (f"{flight.latitude[k]:.7f}", f"{flight.longitude[k]:.7f}", f"{flight.altitude_m[k]:.2f}")
        rows.append((stamp, _rss(flight.rss_dbm[0, k]), *place, f"{east:.2f}", f"{north:.2f}", f"{-up:.2f}"))
    return _text(("timestamp", "rssi", "latitude", "longitude", "altitude", "ve", "vn", "vd"), rows)


def milliseconds(flight: SimulatedFlight) -> bytes:
    """Milliseconds since the start without a unit in the header, semicolons, and -200 where nothing was received."""
    rows = [
        (round(1e3 * flight.time_s[k]), f"{flight.distance_m[k]:.2f}",
         f"{SENTINEL_DBM if math.isnan(flight.rss_dbm[0, k]) or k % 10 == 7 else flight.rss_dbm[0, k]:.0f}")
        for k in np.flatnonzero(flight.flying).tolist()
    ]  # fmt: skip
    return _text(("time", "distance", "rssi"), rows, comma=";")


def wide(flight: SimulatedFlight) -> bytes:
    """A column of RSS and one of distance for each link; read with `--melt`."""
    rows = [
        (
            f"{flight.time_s[k]:.3f}",
            *(_rss(value) for value in flight.rss_dbm[:, k]),
            *[f"{flight.distance_m[k]:.3f}"] * 2,
        )
        for k in np.flatnonzero(flight.flying).tolist()
    ]
    return _text(("time", "rss_ground", "rss_aircraft", "dist_ground", "dist_aircraft"), rows)


def prose(flight: SimulatedFlight) -> bytes:
    """Lines of prose, names and units in words, a clock."""
    rows = []
    for k in np.flatnonzero(flight.flying).tolist():
        clock = datetime.fromtimestamp(START_S + flight.time_s[k], UTC).strftime("%H:%M:%S.%f")[:-3]
        rows.append((clock, _rss(flight.rss_dbm[0, k]), f"{100.0 * flight.distance_m[k]:.0f}"))
    before = "# Link test of the telemetry radio, antenna vertical\n# Recorded by hand, one line a packet\n\n"
    return _text(("Time of day", "Received signal strength (dBm)", "Distance to the station (cm)"), rows, before)


def bare(flight: SimulatedFlight) -> bytes:
    """No header; read with `--columns 1=t,2=rss,3=dist`."""
    rows = [
        (f"{flight.time_s[k]:.2f}", _rss(flight.rss_dbm[0, k]), f"{flight.distance_m[k]:.2f}")
        for k in np.flatnonzero(flight.flying).tolist()
    ]
    return _text((), rows)


def relative(flight: SimulatedFlight) -> bytes:
    """Relative power without its level; read with `--offset-db`."""
    rows = [
        (f"{flight.time_s[k]:.2f}", _rss(flight.rss_dbm[0, k] + 120.0), f"{flight.distance_m[k]:.2f}")
        for k in np.flatnonzero(flight.flying).tolist()
    ]
    return _text(("t", "rssi", "dist"), rows)


def edgetx(flight: SimulatedFlight) -> bytes:
    """What a transmitter writes, ground rows included."""
    rows = []
    for k in range(len(flight.time_s)):
        moment = datetime.fromtimestamp(START_S + flight.time_s[k], UTC)
        east, north, up = flight.velocity_mps[k]
        rows.append(
            (
                moment.strftime("%Y-%m-%d"), moment.strftime("%H:%M:%S.%f")[:-3],
                *(f"{0.0 if math.isnan(value) else value:.0f}" for value in flight.rss_dbm[:, k]),
                f"{flight.latitude[k]:.6f} {flight.longitude[k]:.6f}", f"{math.hypot(east, north) / 0.514444:.1f}",
                f"{math.degrees(math.atan2(east, north)) % 360.0:.1f}", f"{HOME[2] + flight.position_m[k, 2]:.1f}",
                f"{up:.2f}",
            )
        )  # fmt: skip
    return _text(("Date", "Time", "1RSS(dB)", "TRSS(dB)", "GPS", "GSpd(kts)", "Hdg(°)", "Alt(m)", "VSpd(m/s)"), rows)


TABLES: dict[str, Callable[[SimulatedFlight], bytes]] = {
    "csv": csv,
    "positions": positions,
    "milliseconds": milliseconds,
    "wide": wide,
    "prose": prose,
    "bare": bare,
    "relative": relative,
    "edgetx": edgetx,
}
