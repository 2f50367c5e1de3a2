"""Radio logs in ROS bags: ROS 1 (.bag) and ROS 2 (.mcap, .db3), any topics with numbers."""

from __future__ import annotations

import contextlib
import math
import shutil
import tempfile
from array import array
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from rss_gym.calibration.logs.columns import GLOBAL, LOCAL, NAMES
from rss_gym.calibration.logs.ends import known_places, rate_mps, relative_m, sign
from rss_gym.calibration.logs.options import ReadOptions
from rss_gym.calibration.logs.record import DISTANCE, NO_POSITION, ROWS_MAX, Floats, LogFile, Rows
from rss_gym.calibration.logs.table_ends import GAP_MAX_S, bracketed
from rss_gym.params import ParamsError, suggestion

_DEPTH = 4  # of messages within messages
_KEYS = frozenset((*LOCAL, *GLOBAL, "rss", "dist", "rate", "vx", "vy", "vz", "vx2", "vy2", "vz2", "link"))
_NAVSAT = {"lat": "latitude", "lon": "longitude", "alt": "altitude"}


# How a bag begins, and the suffix by which rosbags tells it.
_BEGINNINGS = {b"#ROSBAG V2.0": ".bag", b"\x89MCAP0\r\n": ".mcap", b"SQLite format 3\0": ".db3"}


def is_bag(head: bytes) -> bool:
    """Whether a file begins as a bag of ROS 1, or as MCAP or SQLite."""
    return head.startswith(tuple(_BEGINNINGS))


@contextlib.contextmanager
def _suffixed(path: Path) -> Iterator[Path]:
    """The bag under a name with the suffix of its content: rosbags goes by the name, readers here do not."""
    if path.is_dir():
        yield path
        return
    with path.open("rb") as file:
        head = file.read(16)
    suffix = next((end for begin, end in _BEGINNINGS.items() if head.startswith(begin)), path.suffix)
    if path.suffix == suffix:
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        link = Path(folder) / f"log{suffix}"
        try:
            link.symlink_to(path.absolute())
        except OSError:  # no symbolic links on this system
            shutil.copyfile(path, link)
        yield link


def read_bag(path: Path, options: ReadOptions) -> LogFile:
    """Read a bag by rosbags.

    `--columns` names fields: `rss=/radio/rssi.data,lat=/gps/fix.latitude,lat2=47.1`, a topic, a dot and the field, a
    number for what is the same in every row. The rows are those of the topic with the RSS; everything else is taken at
    their times, on the straight line between two messages. Positions of one NavSatFix are found without being named.

    Raises
    ------
    ParamsError
        When rosbags is not installed, the bag is damaged, a field is not there, or no distance can be made.
    """
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise ParamsError(
            "reading ROS bags needs rosbags, which is not installed: pip install -e '.[ros]' in the clone"
        ) from error
    try:
        with _suffixed(path) as named, AnyReader([named], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as bag:
            topics = {connection.topic: connection.msgtype for connection in bag.connections}
            wanted = _wanted(options, topics, _fields(bag))
            values = dict(_values(bag, wanted, path.name))
    except AnyReaderError as error:
        raise ParamsError(
            f"log {path.name!r} is not a bag that rosbags can read: {' '.join(str(error).split())[:200]}"
        ) from error
    except ParamsError:
        raise
    except Exception as error:  # it raises whatever a damaged byte leads to
        raise ParamsError(f"log {path.name!r} is a damaged bag: {type(error).__name__}") from error
    return _file(path.name, values, wanted, options)


def _wanted(options: ReadOptions, topics: Mapping[str, str], fields: Mapping[str, list[str]]) -> dict[str, Any]:
    """By key: (topic, field), or a number."""
    wanted: dict[str, Any] = {}
    known = [f"{topic}.{field}" for topic, names in fields.items() for field in names]
    for key, name in options.columns.items():
        if key not in _KEYS:
            raise ParamsError(
                f"columns: {key!r} is unknown for a bag{suggestion(key, [k for k in NAMES if k in _KEYS])}"
            )
        topic = max((topic for topic in topics if name.startswith(f"{topic}.")), key=len, default=None)
        if topic is not None and name[len(topic) + 1 :] in fields.get(topic, []):
            wanted[key] = (topic, name[len(topic) + 1 :])
            continue
        try:
            wanted[key] = float(name)
        except ValueError:
            raise ParamsError(f"columns: the bag has no numeric field {name!r}{suggestion(name, known)}") from None
    fixes = [topic for topic, kind in topics.items() if kind.endswith("NavSatFix")]
    if not wanted.keys() & {*LOCAL, *GLOBAL, "dist"} and len(fixes) == 1:
        wanted |= {key: (fixes[0], field) for key, field in _NAVSAT.items()}
    if "rss" not in wanted or not isinstance(wanted["rss"], tuple):
        listed = ", ".join(known[:30]) + (", ..." if len(known) > 30 else "")
        raise ParamsError(
            f"a bag does not say which field is the RSS: name it by --columns rss=TOPIC.FIELD; fields: {listed}"
        )
    return wanted


def _fields(bag: Any) -> dict[str, list[str]]:
    """The numeric fields of the first message of each topic."""
    found: dict[str, list[str]] = {}
    for connection in bag.connections:
        if connection.topic in found:
            continue
        for _, _, raw in bag.messages(connections=[connection]):
            found[connection.topic] = [name for name, _ in _numbers(bag.deserialize(raw, connection.msgtype))]
            break
    return found


def _numbers(message: Any, prefix: str = "", depth: int = 0) -> Iterator[tuple[str, float | str]]:
    for name in getattr(message, "__dataclass_fields__", {}):
        if name == "__msgtype__":
            continue
        value = getattr(message, name)
        if isinstance(value, (bool, int, float, np.number)) or (isinstance(value, str) and not prefix):
            yield prefix + name, value if isinstance(value, str) else float(value)
        elif depth < _DEPTH and name != "header":
            yield from _numbers(value, f"{prefix}{name}.", depth + 1)


def _values(bag: Any, wanted: Mapping[str, Any], source: str) -> Iterator[tuple[str, tuple[Floats, list[str]]]]:
    """By topic: a table of time and the wanted fields, and the link's name of each row."""
    for topic in dict.fromkeys(place[0] for place in wanted.values() if isinstance(place, tuple)):
        keys = [
            key for key, place in wanted.items() if isinstance(place, tuple) and place[0] == topic and key != "link"
        ]
        link = wanted["link"][1] if isinstance(wanted.get("link"), tuple) and wanted["link"][0] == topic else None
        rows, links = array("d"), []
        connections = [connection for connection in bag.connections if connection.topic == topic]
        for connection, stamp_ns, raw in bag.messages(connections=connections):
            message = bag.deserialize(raw, connection.msgtype)
            rows.append(_stamp_s(message, stamp_ns))
            rows.extend(float(_get(message, wanted[key][1])) for key in keys)
            links.append(str(_get(message, link)) if link is not None else "link")
            if len(links) > ROWS_MAX:
                raise ParamsError(f"log {source!r} has more than {ROWS_MAX:,} messages of {topic!r}; split it")
        yield topic, (np.frombuffer(rows).reshape(-1, 1 + len(keys)), links)


def _stamp_s(message: Any, stamp_ns: int) -> float:
    """The time of the measurement where the message says it, else that of its record."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    if stamp is not None and (stamp.sec or stamp.nanosec):
        return float(stamp.sec) + 1e-9 * float(stamp.nanosec)
    return stamp_ns * 1e-9


def _get(message: Any, field: str) -> Any:
    for name in field.split("."):
        message = getattr(message, name)
    return message


def _file(
    source: str, tables: Mapping[str, tuple[Floats, list[str]]], wanted: Mapping[str, Any], options: ReadOptions
) -> LogFile:
    topic = wanted["rss"][0]
    table, links = tables[topic]
    file = LogFile(source, f"ROS bag, RSS of {topic}", [], "message")
    file.columns = {key: ".".join(place) if isinstance(place, tuple) else f"{place:g}" for key, place in wanted.items()}
    time_s = table[:, 0]
    series: dict[str, Floats] = {}
    known = np.ones(len(time_s), bool)
    for key, place in wanted.items():
        if key == "link":
            continue
        if not isinstance(place, tuple):
            series[key] = np.full(len(time_s), place)
            continue
        other, _ = tables[place[0]]
        keys = [k for k, at in wanted.items() if isinstance(at, tuple) and at[0] == place[0] and k != "link"]
        column = other[:, 1 + keys.index(key)]
        if place[0] == topic:
            series[key] = column
            continue
        order = np.argsort(other[:, 0], kind="stable")
        at_s = other[order, 0]
        interval_s = float(np.median(np.diff(at_s))) if len(at_s) > 1 else 0.0
        known &= bracketed(time_s, at_s, max(GAP_MAX_S, 3.0 * interval_s))
        series[key] = np.interp(time_s, at_s, column[order])
    if options.station is not None:
        system = GLOBAL if "lat" in series else LOCAL
        series |= {key: np.full(len(time_s), at) for key, at in zip(system[3:], options.station, strict=True)}
    names = np.array(links)
    for link in dict.fromkeys(links):
        own = names == link
        rows = Rows(
            link=link,
            number=np.flatnonzero(own).astype(np.float64) + 1.0,
            time_s=time_s[own],
            rss_dbm=series["rss"][own],
            distance_m=np.full(own.sum(), math.nan),
            range_rate_mps=None,
            reason=np.zeros(own.sum(), np.uint8),
        )
        _distance(file, rows, {key: value[own] for key, value in series.items()})
        rows.drop(~known[own], NO_POSITION)
        file.rows.append(rows)
    return file


def _distance(file: LogFile, rows: Rows, values: dict[str, Floats]) -> None:
    system = next((system for system in (GLOBAL, LOCAL) if values.keys() >= {*system[:2], *system[3:5]}), ())
    if "dist" in values:
        rows.distance_m = values["dist"]
    elif system:
        zero = np.zeros(rows.time_s.size)
        flat = not values.keys() >= {system[2], system[5]}
        first, second = (
            np.column_stack([zero if flat and k == 2 else values[key] for k, key in enumerate(part)])
            for part in (system[:3], system[3:])
        )
        apart = relative_m(first, second, system == GLOBAL)
        rows.distance_m = np.linalg.norm(apart, axis=1)
        if system == GLOBAL:
            rows.drop(~known_places(*first.T), DISTANCE)
        if values.keys() >= {"vx", "vy"}:
            velocity = np.column_stack([values.get(key, zero) for key in ("vx", "vy", "vz")])
            velocity[:, 2] *= sign(rows.time_s, first[:, 2], velocity[:, 2])
            if values.keys() >= {"vx2", "vy2"}:
                velocity = velocity - np.column_stack([values.get(key, zero) for key in ("vx2", "vy2", "vz2")])
            rows.range_rate_mps = rate_mps(apart, velocity)
    else:
        raise ParamsError(
            f"log {file.source!r}: name the distance by dist=TOPIC.FIELD, or the positions of both ends by "
            f"{','.join(LOCAL)} "
            f"or {','.join(GLOBAL)}, the fixed one by --station"
        )
    if "rate" in values:
        rows.range_rate_mps = values["rate"] * sign(rows.time_s, rows.distance_m, values["rate"])
