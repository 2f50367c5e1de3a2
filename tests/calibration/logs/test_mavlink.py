"""Telemetry logs written here by pymavlink's own packer, and read back."""

import struct
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as dialect

from rss_gym.calibration.logs import read
from rss_gym.calibration.logs.mavlink import sik_dbm
from rss_gym.params import ParamsError

START_US = 1_714_060_800_000_000
HOME = (47.0, 8.0, 400.0)
METRE_NORTH = 1.0 / 111_170.0  # degrees of latitude at 47 degrees north and 400 m


class Writer:
    """A telemetry log in memory: eight bytes of time before each packet."""

    def __init__(self, version=2):
        self.content = bytearray()
        self.vehicle = dialect.MAVLink(None, srcSystem=1)
        self.radio = dialect.MAVLink(None, srcSystem=51, srcComponent=68)
        self.version = version

    def add(self, time_s, message, sender=None):
        packet = message.pack(sender or self.vehicle, force_mavlink1=self.version == 1)
        self.content += struct.pack(">Q", START_US + round(time_s * 1e6)) + packet

    def home(self, time_s):
        lat, lon, alt_m = HOME
        place = (round(lat * 1e7), round(lon * 1e7), round(alt_m * 1e3), 0, 0, 0, [1, 0, 0, 0], 0, 0, 0)
        self.add(time_s, dialect.MAVLink_home_position_message(*place))

    def position(self, time_s, north_m, up_m=30.0, north_mps=4.0, sender=None):
        lat, lon, alt_m = HOME
        place = (round((lat + north_m * METRE_NORTH) * 1e7), round(lon * 1e7), round((alt_m + up_m) * 1e3))
        velocity = (round(north_mps * 100), 0, 0)
        self.add(
            time_s,
            dialect.MAVLink_global_position_int_message(round(time_s * 1e3), *place, round(up_m * 1e3), *velocity, 0),
            sender,
        )

    def report(self, time_s, rssi, remrssi, kind=dialect.MAVLink_radio_status_message):
        self.add(time_s, kind(rssi, remrssi, 100, 40, 40, 0, 0), self.radio)


def flight(writer, seconds=40, kind=dialect.MAVLink_radio_status_message):
    """Straight north at 4 m/s from 20 m, 30 m up; positions at 4 Hz, reports at 1 Hz in between."""
    for k in range(4 * seconds):
        writer.position(0.25 * k, 20.0 + k)
        writer.add(0.25 * k + 0.05, dialect.MAVLink_attitude_message(k, 0, 0, 0, 0, 0, 0))
        if k % 4 == 1:
            writer.report(0.25 * k + 0.1, 200 - k, 150 - k % 7, kind)
    return writer


@pytest.fixture
def log(tmp_path):
    def write(content):
        path = tmp_path / "flight.tlog"
        path.write_bytes(content)
        return path

    return write


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("kind", [dialect.MAVLink_radio_status_message, dialect.MAVLink_radio_message])
def test_both_ends_of_the_radio(log, version, kind):
    writer = Writer(version)
    writer.home(-1.0)
    found = read([log(flight(writer, kind=kind).content)], format="mavlink")
    assert [item.link for item in found] == ["ground", "aircraft"]
    assert found.notes == ()
    k = 4 * np.arange(40) + 1
    north_m = 20.0 + k + 0.1 / 0.25
    distance_m = np.hypot(north_m, 30.0)
    for item, raw in zip(found, (200 - k, 150 - k % 7), strict=True):
        np.testing.assert_allclose(item.time_s, np.arange(40.0), atol=1e-6)
        np.testing.assert_allclose(item.rss_dbm, raw / 1.9 - 127.0)
        np.testing.assert_allclose(item.distance_m, distance_m, rtol=5e-4)
        np.testing.assert_allclose(item.range_rate_mps, 4.0 * north_m / distance_m, rtol=5e-4)
        assert (item.source, item.dropped) == ("flight.tlog", 0)


def test_ground_station_at_the_first_position_without_home(log):
    found = read(log(flight(Writer()).content), format="mavlink")
    np.testing.assert_allclose(found[0].distance_m, 4 * np.arange(40) + 1.4, rtol=2e-2)
    np.testing.assert_allclose(found[0].range_rate_mps, 4.0, rtol=1e-9)
    assert len(found.notes) == 1 and "first position" in found.notes[0]


def test_sik_units():
    np.testing.assert_allclose(sik_dbm(np.array([1.0, 190.0, 254.0])), [-126.4737, -27.0, 6.6842], atol=1e-4)
    assert np.isnan(sik_dbm(np.array([0.0, 255.0]))).all()


def test_invalid_reports_are_dropped_and_counted(log):
    writer = Writer()
    writer.home(-1.0)
    flight(writer)
    writer.position(40.0, 180.0)
    for k, (rssi, remrssi) in enumerate([(0, 150), (150, 255)]):
        writer.report(40.0 + k / 4, rssi, remrssi)
        writer.position(40.1 + k / 4, 181.0 + k)
    found = read(log(writer.content), format="mavlink")
    assert [item.dropped for item in found] == [1, 1]
    assert [item.time_s.size for item in found] == [41, 41]
    assert found.notes == ("log 'flight.tlog': 2 of 84 rows dropped: 2 × no RSS (message 363)",)
    for k in range(90):
        writer.report(41.0 + k / 4, 0, 0)
        writer.position(41.1 + k / 4, 184.0 + k)
    with pytest.raises(ParamsError, match=r"182 of 264 rows .*cannot be used, at most 50%"):
        read(log(writer.content), format="mavlink")


def test_reports_without_positions_about_them_are_left_out(log):
    writer = Writer()
    writer.home(-9.0)
    writer.report(-5.0, 180, 180)  # before the first
    flight(writer)
    writer.report(41.0, 180, 180)  # in a gap of over two seconds
    writer.position(43.0, 200.0)
    writer.report(44.0, 180, 180)  # after the last
    found = read(log(writer.content), format="mavlink")
    assert [item.time_s.size for item in found] == [40, 40]
    np.testing.assert_allclose(found[0].time_s[0], 5.35, atol=1e-6)
    assert "6 of 86 rows dropped: 6 × no position near in time" in found.notes[0]


def test_truncated_and_damaged_logs_give_what_is_whole(log):
    writer = Writer()
    writer.home(-1.0)
    whole = bytes(flight(writer).content)
    found = read(log(whole[:-17]), format="mavlink")
    assert found[0].time_s.size == 40
    half = len(whole) // 2
    damaged = whole[:half] + bytes(range(256)) + whole[half:]
    assert read(log(damaged), format="mavlink")[0].time_s.size >= 38
    with pytest.raises(ParamsError, match="valid rows"):
        read(log(whole[:half]), format="mavlink")


def test_packet_with_a_wrong_checksum_is_ignored(log):
    writer = Writer()
    writer.home(-1.0)
    whole = flight(writer).content
    at = whole.rindex(struct.pack(">Q", START_US + 39_350_000)) + 8
    whole[at + 12] ^= 0xFF
    assert read(log(whole), format="mavlink")[0].time_s.size == 39


@pytest.mark.parametrize(
    "change, sentence",
    [
        (lambda writer: writer.content.clear(), "'flight.tlog' is empty"),
        (lambda writer: writer.content.__init__(b"t,rss,dist\n" * 50), "not a MAVLink telemetry log"),
        (lambda writer: writer.content.__init__(bytes(range(256)) * 9), "not a MAVLink telemetry log"),
        (lambda writer: (writer.content.clear(), writer.position(0.0, 1.0)), "no message RADIO_STATUS or RADIO"),
        (lambda writer: (writer.content.clear(), writer.report(0.0, 9, 9)), "no message GLOBAL_POSITION_INT"),
        (
            lambda writer: writer.position(50.0, 9.0, sender=dialect.MAVLink(None, srcSystem=2)),
            r"several vehicles, systems 1, 2",
        ),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(log, change, sentence):
    writer = flight(Writer())
    change(writer)
    with pytest.raises(ParamsError, match=sentence) as caught:
        read(log(writer.content), format="mavlink")
    assert "\n" not in str(caught.value)


def test_columns_do_not_apply(log):
    with pytest.raises(ParamsError, match="columns are for tables"):
        read(log(flight(Writer()).content), format="mavlink", columns={"t": "time"})


def test_without_pymavlink(log, monkeypatch):
    for name in [name for name in sys.modules if name.startswith("pymavlink")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "pymavlink", None)
    with pytest.raises(ParamsError, match=r"-e '\.\[mavlink\]"):
        read(log(flight(Writer()).content), format="mavlink")


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    return tmp_path_factory.mktemp("scratch") / "flight.tlog"


@given(
    tail=st.binary(max_size=200),
    cut=st.integers(0, 8000),
    flips=st.lists(st.tuples(st.integers(0, 7000), st.integers(0, 255)), max_size=5),
)
def test_any_bytes_are_read_or_refused(scratch, tail, cut, flips):
    content = bytearray(WHOLE[:cut] + tail + WHOLE[cut:])
    for place, value in flips:
        content[place] = value
    scratch.write_bytes(content)
    try:
        found = read(scratch, format="mavlink")
    except ParamsError as error:
        assert "\n" not in str(error)
    else:
        assert all(np.isfinite(item.distance_m).all() and (np.diff(item.time_s) > 0.0).all() for item in found)


WHOLE = bytes(flight(Writer()).content)
