"""A simulated flight as bags of ROS: `/radio/rssi` (std_msgs/Float32) and `/gps/fix` (sensor_msgs/NavSatFix)."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from rss_gym.calibration.simulated.flight import START_S, SimulatedFlight
from rss_gym.params import ParamsError

RSS, FIX = "/radio/rssi", "/gps/fix"
_POSITIONS_HZ = 5.0


def write_mcap(flight: SimulatedFlight) -> bytes:
    """An MCAP file of ROS 2."""
    rosbags = _rosbags()
    store = rosbags.get_typestore(rosbags.Stores.ROS2_HUMBLE)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log"
        writer = rosbags.Writer2(path, version=9, storage_plugin=rosbags.StoragePlugin.MCAP)
        with writer:
            _fill(writer, store, flight, store.serialize_cdr)
        return next(path.glob("*.mcap")).read_bytes()


def write_bag(flight: SimulatedFlight) -> bytes:
    """A bag of ROS 1."""
    rosbags = _rosbags()
    store = rosbags.get_typestore(rosbags.Stores.ROS1_NOETIC)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.bag"
        with rosbags.Writer1(path) as writer:
            _fill(writer, store, flight, store.serialize_ros1)
        return path.read_bytes()


def _fill(writer: Any, store: Any, flight: SimulatedFlight, serialize: Any) -> None:
    number = store.types["std_msgs/msg/Float32"]
    power = writer.add_connection(RSS, number.__msgtype__, typestore=store)
    fix = writer.add_connection(FIX, "sensor_msgs/msg/NavSatFix", typestore=store)
    types = store.types
    rows: list[tuple[int, Any, Any, str]] = []
    for k, time_s in enumerate(flight.time_s.tolist()):
        if not math.isnan(flight.rss_dbm[0, k]):
            message = number(data=float(flight.rss_dbm[0, k]))
            rows.append((_ns(time_s), power, message, number.__msgtype__))
    header = types["std_msgs/msg/Header"]
    for n, time_s in enumerate(np.arange(0.0, flight.time_s[-1], 1.0 / _POSITIONS_HZ).tolist()):
        stamp = types["builtin_interfaces/msg/Time"](sec=_ns(time_s) // 10**9, nanosec=_ns(time_s) % 10**9)
        own = {"stamp": stamp, "frame_id": "gps"} | ({"seq": n} if "seq" in header.__dataclass_fields__ else {})
        lat, lon, alt = (
            float(np.interp(time_s, flight.time_s, column))
            for column in (flight.latitude, flight.longitude, flight.altitude_m)
        )
        message = types["sensor_msgs/msg/NavSatFix"](
            header=header(**own),
            status=types["sensor_msgs/msg/NavSatStatus"](status=0, service=1),
            latitude=lat,
            longitude=lon,
            altitude=alt,
            position_covariance=np.zeros(9),
            position_covariance_type=0,
        )
        rows.append((_ns(time_s), fix, message, "sensor_msgs/msg/NavSatFix"))
    for stamp_ns, connection, message, name in sorted(rows, key=lambda row: row[0]):
        writer.write(connection, stamp_ns, serialize(message, name))


def _ns(time_s: float) -> int:
    return round((START_S + time_s) * 1e9)


def _rosbags() -> Any:
    try:
        from types import SimpleNamespace

        from rosbags.rosbag1 import Writer as Writer1
        from rosbags.rosbag2 import StoragePlugin
        from rosbags.rosbag2 import Writer as Writer2
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise ParamsError("writing ROS bags needs rosbags: pip install -e '.[ros]' in the clone") from error
    return SimpleNamespace(
        Writer1=Writer1, Writer2=Writer2, StoragePlugin=StoragePlugin, Stores=Stores, get_typestore=get_typestore
    )
