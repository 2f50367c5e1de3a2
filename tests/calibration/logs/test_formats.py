"""Every format of a simulated flight is read without a word about its format, and holds what was flown."""

import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rss_gym.calibration.logs import READERS, read, told
from rss_gym.calibration.simulated import WRITERS, fly, write
from rss_gym.params import ParamsError

READ_AS = {
    "mavlink": "mavlink",
    "dataflash": "dataflash",
    "ulog": "ulog",
    "rosbag": "ros",
    "mcap": "ros",
    "edgetx": "edgetx",
}
RSS_STEP_DB = {"mavlink": 0.27, "dataflash": 0.27, "ulog": 0.27, "edgetx": 0.5, "milliseconds": 0.5}
RATED = {"csv", "positions", "edgetx", "mavlink", "dataflash", "ulog"}


@pytest.mark.parametrize("format", WRITERS)
def test_what_was_flown_is_read(flight, written, format):
    path, options = written(format)
    assert told(path) == READ_AS.get(format, "csv")
    for item in read(path, **options):
        at_s = item.time_s
        start = flight.time_s[0] if format in ("mavlink", "dataflash", "ulog", "edgetx", "rosbag", "mcap") else None
        first = flight.time_s[flight.flying][0] if start is None else start
        k = np.searchsorted(flight.time_s, at_s + first - 0.06)
        assert k.size > 700 and np.abs(flight.time_s[k] - at_s - first).max() < 0.06
        np.testing.assert_allclose(item.distance_m, flight.distance_m[k], rtol=2e-3, atol=0.25)
        n = 0 if item.link in ("link", "ground", "uplink 1") else 1
        np.testing.assert_allclose(item.rss_dbm, flight.rss_dbm[n, k], atol=RSS_STEP_DB.get(format, 0.051))
        assert (item.range_rate_mps is not None) == (format in RATED)
        if item.range_rate_mps is not None:
            true = np.sum(flight.position_m * flight.velocity_mps, axis=1)[k] / flight.distance_m[k]
            np.testing.assert_allclose(item.range_rate_mps, true, atol=0.4)


@pytest.mark.parametrize("format", ["mavlink", "dataflash", "ulog", "edgetx"])
def test_rows_on_the_ground_are_left_out_unless_wanted(flight, written, format):
    path, options = written(format)
    (first, *_), (whole, *_) = read(path, **options), read(path, whole=True, **options)
    reasons = {key: value for key, value in first.reasons.items() if "armed" in key or "ground" in key}
    assert sum(reasons.values()) == pytest.approx(40.0 * 5.0, abs=25)
    assert whole.time_s.size > first.time_s.size + 170


@pytest.mark.parametrize("format", ["mavlink", "dataflash", "ulog", "rosbag", "mcap", "edgetx"])
def test_the_name_does_not_tell_the_format(written, tmp_path, format):
    path, options = written(format)
    other = tmp_path / "log.csv"
    other.write_bytes(path.read_bytes())
    for one, two in zip(read(path, **options), read(other, **options), strict=True):
        np.testing.assert_array_equal(one.rss_dbm, two.rss_dbm)


def test_a_span_of_time(written):
    path, options = written("mavlink")
    (first, *_) = read(path, from_s=60.0, to_s=100.0, **options)
    assert 59.9 < first.time_s[0] < 61.0 and 99.0 < first.time_s[-1] <= 100.0
    assert first.reasons["outside of --from and --to"] > 100
    with pytest.raises(ParamsError, match="--from must lie before --to"):
        read(path, from_s=5.0, to_s=5.0)


@pytest.mark.parametrize("option", [{"melt": "*"}, {"truth": "truth.csv"}, {"time_unit": "ms"}])
def test_what_is_for_tables_is_not_ignored_elsewhere(written, option):
    path, _ = written("ulog")
    with pytest.raises(ParamsError, match=rf"{next(iter(option))} is for tables, and log 'ulog.ulg' is a PX4 ULog"):
        read(path, **option)


def test_a_log_of_no_known_format_is_refused(tmp_path):
    path = tmp_path / "log.dat"
    path.write_bytes(bytes(range(256)) * 20)
    with pytest.raises(ParamsError, match=r"'log.dat' is not text in UTF-8 and of no known format; known: MAVLink"):
        read(path)


@pytest.mark.parametrize("format, library, extra", [
    ("dataflash", "pymavlink", "mavlink"), ("ulog", "pyulog", "ulog"), ("mcap", "rosbags", "ros"),
])  # fmt: skip
def test_without_the_library(written, monkeypatch, format, library, extra):
    path, options = written(format)
    for name in [name for name in sys.modules if name.partition(".")[0] == library]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(ParamsError, match=rf"-e '\.\[{extra}\]"):
        read(path, **options)


DAMAGED = ("dataflash", "ulog", "mcap", "rosbag", "edgetx")


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    folder = tmp_path_factory.mktemp("small")
    flight = fly("outdoor", 60.0, 5.0)
    for name in DAMAGED:
        write(flight, name, folder / name)
    return folder


@pytest.mark.parametrize("format", DAMAGED)
@settings(max_examples=15)
@given(
    cut=st.integers(0, 200_000), tail=st.binary(max_size=60), place=st.integers(0, 100_000), value=st.integers(0, 255)
)
def test_any_damage_is_read_or_refused(small, scratch, format, cut, tail, place, value):
    content = bytearray((small / format).read_bytes())
    content = content[: cut % len(content)] + tail + content[cut % len(content) :]
    content[place % len(content)] = value
    scratch.write_bytes(content)
    columns = {"rss": "/radio/rssi.data"} if format in ("mcap", "rosbag") else {}
    try:
        found = read(scratch, format=READ_AS[format], columns=columns)
    except ParamsError as error:
        assert "\n" not in str(error) and scratch.name in str(error)
    else:
        assert all(np.isfinite(item.distance_m).all() and (np.diff(item.time_s) > 0.0).all() for item in found)


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    return tmp_path_factory.mktemp("scratch") / "flight.dat"


def test_a_bag_says_which_fields_it_has(written):
    path, _ = written("mcap")
    with pytest.raises(ParamsError, match=r"rss=TOPIC.FIELD; fields: .*/radio/rssi.data"):
        read(path)
    with pytest.raises(ParamsError, match=r"no numeric field '/radio/rsi.data'; did you mean '/radio/rssi.data'"):
        read(path, columns={"rss": "/radio/rsi.data"})
    with pytest.raises(ParamsError, match="the fixed one by --station"):
        read(path, columns={"rss": "/radio/rssi.data"})


def test_every_reader_has_a_writer(written):
    assert {told(written(format)[0]) for format in WRITERS} == set(READERS)


def test_a_bag_that_is_a_folder(flight, tmp_path):
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    pair = store.types["geometry_msgs/msg/Point"]
    with Writer(tmp_path / "bag", version=9) as writer:
        link = writer.add_connection("/link", pair.__msgtype__, typestore=store)
        for time_s, rss, distance in zip(flight.time_s, flight.rss_dbm[0], flight.distance_m, strict=True):
            message = store.serialize_cdr(pair(x=float(rss), y=float(distance), z=0.0), pair.__msgtype__)
            writer.write(link, round((1.7e9 + time_s) * 1e9), message)
    (found,) = read(tmp_path / "bag", columns={"rss": "/link.x", "dist": "/link.y"})
    np.testing.assert_allclose(found.distance_m, flight.distance_m)
    np.testing.assert_allclose(found.time_s, flight.time_s, atol=1e-6)
    (file,) = (tmp_path / "bag").glob("*.db3")
    (alone,) = read(file, columns={"rss": "/link.x", "dist": "/link.y"})
    np.testing.assert_array_equal(alone.rss_dbm, found.rss_dbm)
