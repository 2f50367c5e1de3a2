"""What radio, from whom, counted how often: telemetry logs with the faults of real ones."""

import struct

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as dialect

from rss_gym.calibration.logs import read
from rss_gym.calibration.simulated import HOME, fly
from rss_gym.calibration.simulated.autopilots import sik_raw
from rss_gym.eval.studies.calibration.calibrate import calibrate

START_S = 1_714_060_800.0
FAR_DB = 20.0  # how much less the second radio receives
# The metres that a degree has at HOME, for a home that was set elsewhere first.
ELSEWHERE = (HOME[0] + 4e-4, HOME[1] + 3e-4, HOME[2])


class Telemetry:
    """A telemetry log of a flight with the faults that are asked for."""

    def __init__(self, flight, upside_down=False, senders=1, both=False, moved=False, scale=1e6, varied=1):
        self.packets = []
        vehicle = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
        end_s = flight.time_s[-1]
        for t in np.arange(0.0, end_s, 5.0):
            place = ELSEWHERE if moved and t < 15.0 else HOME
            home = (round(place[0] * 1e7), round(place[1] * 1e7), round(place[2] * 1e3))
            self.add(t, vehicle, dialect.MAVLink_home_position_message(*home, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0))
        for t in np.arange(0.0, end_s, 1.0):
            mode = 128 if np.interp(t, flight.time_s, flight.armed) > 0.5 else 0
            self.add(t, vehicle, dialect.MAVLink_heartbeat_message(2, 3, mode, 0, 4, 3))
        for t in np.arange(0.0, end_s, 0.25):
            lat, lon, alt, *v = (
                np.interp(t, flight.time_s, column)
                for column in (flight.latitude, flight.longitude, flight.altitude_m, *flight.velocity_mps.T)
            )
            height = round(1e3 * (alt - HOME[2]))
            east, north, up = (round(100 * value) for value in v)
            down = up if upside_down else -up
            place = (round(lat * 1e7), round(lon * 1e7), round(alt * 1e3), height)
            self.add(
                t, vehicle, dialect.MAVLink_global_position_int_message(round(t * 1e3), *place, north, east, down, 0)
            )
        for number in range(senders):
            radio = dialect.MAVLink(None, srcSystem=51 + number, srcComponent=68)
            for k, t in enumerate(flight.time_s):
                rssi, remote = (sik_raw(value - FAR_DB * number) for value in flight.rss_dbm[:, k])
                values = (rssi, remote, 100, 40 + k % 9 * varied, 40 + k % 7 * varied, k % 60_000 * varied, 0)
                self.add(t + 0.01 + 0.003 * number, radio, dialect.MAVLink_radio_status_message(*values))
                if both:
                    self.add(t + 0.012 + 0.003 * number, radio, dialect.MAVLink_radio_message(*values))
        self.scale = scale

    def add(self, time_s, sender, message):
        self.packets.append((time_s, message.pack(sender)))

    def write(self, path):
        stamped = [
            struct.pack(">Q", round((START_S + t) * self.scale)) + packet
            for t, packet in sorted(self.packets, key=lambda pair: pair[0])
        ]
        path.write_bytes(b"".join(stamped))
        return path


@pytest.fixture(scope="module")
def flights():
    return [fly("outdoor", 240.0, 2.0, seed) for seed in range(8)]


def clean(flight, path, number=0):
    """The table that a person makes of the log by hand: one radio, in flight, true distance and range rate."""
    rate = np.sum(flight.position_m * flight.velocity_mps, axis=1) / flight.distance_m
    lines = ["t,rss,dist,range_rate"]
    for k in np.flatnonzero(flight.flying & flight.armed):
        rss = sik_raw(flight.rss_dbm[0, k] - FAR_DB * number) / 1.9 - 127.0
        lines.append(f"{flight.time_s[k]:.2f},{rss:.2f},{flight.distance_m[k]:.3f},{rate[k]:.3f}")
    path.write_text("\n".join(lines) + "\n")
    return path


FAULTS = {
    "plain": {},
    "both messages of a report": {"both": True},
    "velocity up": {"upside_down": True},
    "two radios": {"senders": 2},
    "home moved": {"moved": True},
    "stamps in ms": {"scale": 1e3},
    "all": {"both": True, "upside_down": True, "senders": 2, "moved": True, "scale": 1e3},
}
METHODS = ("ls", "ekf-white", "ekf-coloured", "ekf-white-rate", "ekf-coloured-rate")


@pytest.fixture(scope="module")
def by_hand(flights, tmp_path_factory):
    folder = tmp_path_factory.mktemp("clean")
    logs = read([clean(flight, folder / f"{k}.csv") for k, flight in enumerate(flights)])
    return calibrate(logs[:4], logs[4:])


@pytest.mark.parametrize("name", [name for name in FAULTS if name not in ("plain", "all")])
def test_each_fault_by_itself_changes_no_row(flights, tmp_path, name):
    plain = read(Telemetry(flights[0]).write(tmp_path / "plain.tlog"))
    found = read(Telemetry(flights[0], **FAULTS[name]).write(tmp_path / "fault.tlog"))
    for one, other in zip(plain, found[:2], strict=True):
        np.testing.assert_allclose(other.time_s, one.time_s, atol=2e-3)
        np.testing.assert_array_equal(other.rss_dbm, one.rss_dbm)
        np.testing.assert_allclose(other.distance_m, one.distance_m, atol=0.02)
        np.testing.assert_allclose(other.range_rate_mps, one.range_rate_mps, atol=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["plain", "all"])
def test_raw_logs_range_as_well_as_clean_ones(flights, by_hand, tmp_path, name):
    paths = [Telemetry(flight, **FAULTS[name]).write(tmp_path / f"{k}.tlog") for k, flight in enumerate(flights)]
    logs = read(paths)
    chosen = [record for record in logs if record.link.startswith("ground") and record.sender == "51/68"]
    result = calibrate(chosen[:4], chosen[4:])
    for method in METHODS:
        raw, ours = result.scores[method].p80_m.value, by_hand.scores[method].p80_m.value
        assert raw <= 1.1 * ours, method
        if not method.endswith("-rate"):  # with velocity the clean table has its own rounding
            assert raw >= 0.9 * ours, method
    factor = by_hand.fit.channel.path_loss_factor
    assert result.fit.channel.path_loss_factor == pytest.approx(factor, rel=0.03)


def test_two_radios_are_two_links(flights, tmp_path):
    found = read(Telemetry(flights[0], senders=2).write(tmp_path / "a.tlog"))
    assert [item.link for item in found] == ["ground 51/68", "aircraft 51/68", "ground 52/68", "aircraft 52/68"]
    assert any("2 senders report the radio: a link for each" in note for note in found.notes)
    factors = {name: link.path_loss.path_loss_factor for name, link in calibrate(found).fit.links.items()}
    assert max(factors.values()) - min(factors.values()) < 0.3


def test_a_sender_that_passes_reports_on_is_left_out(flights, tmp_path):
    log = Telemetry(flights[0])
    relay = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
    for k, t in enumerate(flights[0].time_s):
        values = (*(sik_raw(value) for value in flights[0].rss_dbm[:, k]), 100, 40 + k % 9, 40 + k % 7, k, 0)
        log.add(t + 0.1, relay, dialect.MAVLink_radio_status_message(*values))
    found = read(log.write(tmp_path / "a.tlog"))
    assert [item.link for item in found] == ["ground", "aircraft"]
    assert any("sender 1/1 passes on the reports of 51/68" in note for note in found.notes)


def test_copies_of_a_report_count_once(flights, tmp_path):
    found = read(Telemetry(flights[0], both=True).write(tmp_path / "a.tlog"))
    once = read(Telemetry(flights[0]).write(tmp_path / "b.tlog"))
    assert [item.time_s.size for item in found] == [item.time_s.size for item in once]
    assert found[0].reasons["a copy of another report"] == flights[0].time_s.size


def test_equal_reports_in_a_row_are_no_copies(tmp_path):
    flight = fly("outdoor", 60.0, 10.0)
    flight.rss_dbm[:] = np.round(flight.rss_dbm / 12.0) * 12.0  # hardly ever another value
    found = read(Telemetry(flight, both=True, varied=0).write(tmp_path / "a.tlog"), whole=True)
    assert found[0].time_s.size > 0.98 * flight.time_s.size
    assert found[0].reasons["a copy of another report"] == flight.time_s.size


def test_places_beside_0_0_and_jumps_are_left_out(flights, tmp_path):
    log = Telemetry(flights[0])
    vehicle = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
    for t, lat, lon in (
        (30.1, 100, 100),
        (31.1, -100, 0),
        (60.1, round(HOME[0] * 1e7) + 400_000, round(HOME[1] * 1e7)),
    ):
        log.add(t, vehicle, dialect.MAVLink_global_position_int_message(0, lat, lon, 410_000, 9_000, 0, 0, 0, 0))
    log.add(3.0, vehicle, dialect.MAVLink_home_position_message(100, 90, 0, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0))
    found, plain = read(log.write(tmp_path / "a.tlog")), read(Telemetry(flights[0]).write(tmp_path / "b.tlog"))
    for one, other in zip(found, plain, strict=True):
        np.testing.assert_allclose(one.distance_m, other.distance_m, atol=0.5)
    assert any("2 messages GLOBAL_POSITION_INT left out" in note and "no fix" in note for note in found.notes)
    assert any("1 messages GLOBAL_POSITION_INT left out: no flight goes there" in note for note in found.notes)


def test_home_at_the_time(flights, tmp_path):
    found = read(Telemetry(flights[0], moved=True).write(tmp_path / "a.tlog"))
    assert any("home moves 1 times: each row has the home of its time" in note for note in found.notes)
    station = read(tmp_path / "a.tlog", station=HOME)
    np.testing.assert_allclose(found[0].distance_m, station[0].distance_m, rtol=1e-6)


def test_a_tracker_is_no_vehicle(flights, tmp_path):
    log = Telemetry(flights[0])
    tracker = dialect.MAVLink(None, srcSystem=7, srcComponent=1)
    for t in range(40):
        place = (round(HOME[0] * 1e7), round(HOME[1] * 1e7), 400_000, 0)
        log.add(float(t), tracker, dialect.MAVLink_global_position_int_message(0, *place, 0, 0, 0, 0))
    found = read(log.write(tmp_path / "a.tlog"))
    assert any("40 positions of system 7 left out: it is no autopilot" in note for note in found.notes)


def test_a_clock_set_back_in_a_telemetry_log(flights, tmp_path):
    log = Telemetry(flights[0])
    radio = dialect.MAVLink(None, srcSystem=51, srcComponent=68)
    content = log.write(tmp_path / "a.tlog").read_bytes()
    late = dialect.MAVLink_radio_status_message(90, 90, 100, 1, 1, 1, 0).pack(radio)
    (tmp_path / "a.tlog").write_bytes(content + struct.pack(">Q", round((START_S + 50.0) * 1e6)) + late)
    found = read(tmp_path / "a.tlog")
    assert found[0].reasons.get("the clock goes back", 0) == 1
