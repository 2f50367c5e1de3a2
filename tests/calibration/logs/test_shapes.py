"""Tables as they are found: units, clocks, prose, no header, wide, merged, relative, with sentinels, a coarse clock."""

import re
from datetime import UTC, datetime

import numpy as np
import pytest

from rss_gym.calibration.logs import read
from rss_gym.calibration.logs.columns import plain
from rss_gym.params import ParamsError

N = 200
TIME_S = 0.2 * np.arange(N)
DISTANCE_M = 30.0 + 25.0 * np.sin(TIME_S / 4.0)
RSS_DBM = np.round(-40.0 - 27.0 * np.log10(DISTANCE_M) + np.random.default_rng(0).normal(0.0, 2.0, N))


@pytest.fixture
def log(tmp_path):
    def write(header, *columns, name="log.csv", comma=",", before=""):
        lines = [before + comma.join(header)] if header else []
        lines += [comma.join(map(str, row)) for row in zip(*columns, strict=True)]
        path = tmp_path / name
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return path

    return write


def check(record, used=slice(None)):
    np.testing.assert_allclose(record.time_s - record.time_s[0], (TIME_S - TIME_S[used][0])[used], atol=2e-3)
    np.testing.assert_allclose(record.rss_dbm, RSS_DBM[used])
    np.testing.assert_allclose(record.distance_m, DISTANCE_M[used], rtol=1e-6)


@pytest.mark.parametrize(
    "name, scale, start",
    [
        ("t", 1.0, 0.0), ("t", 1e3, 0.0), ("t", 1e6, 0.0), ("t", 1e9, 0.0),
        ("t_ms", 1e3, 0.0), ("Time [us]", 1e6, 5e6), ("timestamp (ns)", 1e9, 0.0),
        ("t", 1.0, 1.7e9), ("t", 1e3, 1.7e12), ("t", 1e6, 1.7e15), ("t", 1e3, 5e7),
    ],
)  # fmt: skip
def test_the_unit_of_time_is_found(log, name, scale, start):
    stamps = [f"{start + scale * t:.4f}" if scale < 10 else f"{start + scale * t:.0f}" for t in TIME_S]
    found = read(log((name, "rss", "dist"), stamps, RSS_DBM, DISTANCE_M))
    check(found[0])
    said = any("time is taken as" in note for note in found.notes)
    assert said == (scale > 1.0 and name == "t")


def test_the_unit_of_time_can_be_named(log):
    path = log(("t", "rss", "dist"), [f"{30.0 * t:.2f}" for t in TIME_S], RSS_DBM, DISTANCE_M)
    (found,) = read(path, time_unit="ms")
    assert found.time_s[-1] == pytest.approx(0.03 * TIME_S[-1])
    with pytest.raises(ParamsError, match="time_unit = 'm' is unknown"):
        read(path, time_unit="m")


def test_slow_sampling_in_seconds_is_not_taken_for_milliseconds(log):
    distance_m = DISTANCE_M * 0 + 20.0 + np.arange(N)
    found = read(log(("t", "rss", "dist"), 8 * np.arange(N), RSS_DBM, distance_m))
    assert found[0].time_s[-1] == 8.0 * (N - 1) and not any("taken as" in note for note in found.notes)


@pytest.mark.parametrize(
    "style",
    [
        "%Y-%m-%dT%H:%M:%S.%fZ",
        "%Y-%m-%d %H:%M:%S.%f",
        "%Y/%m/%d %H:%M:%S.%f",
        "%d.%m.%Y %H:%M:%S.%f",
        "%d/%m/%Y %H:%M:%S.%f",
        "%H:%M:%S.%f",
    ],
)
def test_dates_and_clocks_over_midnight(log, style):
    start = datetime(2024, 4, 25, 23, 59, 45, tzinfo=UTC).timestamp()
    stamps = [datetime.fromtimestamp(start + t, UTC).strftime(style) for t in TIME_S]
    check(read(log(("Time", "RSSI", "Distance"), stamps, RSS_DBM, DISTANCE_M))[0])


def test_a_date_and_a_clock_in_two_columns(log):
    start = datetime(2024, 4, 25, 23, 59, 45, tzinfo=UTC).timestamp()
    moments = [datetime.fromtimestamp(start + t, UTC) for t in TIME_S]
    days = [moment.strftime("%Y-%m-%d") for moment in moments]
    clocks = [moment.strftime("%H:%M:%S.%f") for moment in moments]
    check(read(log(("Date", "Time", "RSSI", "Distance"), days, clocks, RSS_DBM, DISTANCE_M))[0])


@pytest.mark.parametrize(
    "header",
    [
        ("Elapsed time in seconds", "Signal strength (dBm)", "Distance to the mast [m]"),
        ("time (s)", "Received power [dBm]", "true distance (m)"),
        ("Timestamp", "RSSI", "Ground truth"),
    ],
)
def test_headers_in_prose(log, header):
    before = "Measured on the meadow, 3 May; antenna vertical\nradio 3, mast 2\n\n# all times local\n"
    check(read(log(header, TIME_S, RSS_DBM, DISTANCE_M, before=before))[0])


def test_a_header_in_a_comment_and_comments_between(log):
    path = log(("# t", "rss", "dist"), TIME_S, RSS_DBM, DISTANCE_M)
    path.write_text(path.read_text().replace("\n1.0,", "\n# a pause\n1.0,"))
    check(read(path)[0])


@pytest.mark.parametrize("comma", [";", "\t", " ", "|"])
def test_what_separates_the_columns(log, comma):
    check(read(log(("t", "rss", "dist"), TIME_S, RSS_DBM, DISTANCE_M, comma=comma))[0])


def test_decimal_commas_and_units_in_the_cells(log):
    def dotted(values, unit=""):
        return [f"{value:.6f}".replace(".", ",") + unit for value in values]

    check(
        read(log(("t", "rss", "dist"), dotted(TIME_S), dotted(RSS_DBM, " dBm"), dotted(DISTANCE_M, " m"), comma=";"))[0]
    )


@pytest.mark.parametrize("unit, factor", [("cm", 100.0), ("km", 1e-3), ("ft", 1 / 0.3048), ("m", 1.0)])
def test_units_of_length(log, unit, factor):
    found = read(log(("t", "rss", f"distance_{unit}"), TIME_S, RSS_DBM, factor * DISTANCE_M))
    check(found[0])


def test_no_header(log):
    path = log((), TIME_S, ["x"] * N, RSS_DBM, DISTANCE_M)
    check(read(path, columns={"1": "t", "3": "rss", "4": "dist"})[0])
    with pytest.raises(ParamsError, match=r"no header, line 1 is '0.0,x,-.*number: --columns 1=t,2=rss,3=dist"):
        read(path)
    with pytest.raises(ParamsError, match="has 4 columns, and none is number 9"):
        read(path, columns={"1": "t", "3": "rss", "9": "dist"})
    with pytest.raises(ParamsError, match="'rsi' is unknown"):
        read(path, columns={"1": "t", "3": "rsi"})


@pytest.mark.parametrize(
    "header, melt",
    [
        (("t", "RSS_AP1", "RSS_AP2", "dist_AP1", "dist_AP2"), "*"),
        (("t", "AP1 rssi", "AP2 rssi", "AP1 distance", "AP2 distance"), "*"),
        (("t", "p-AP1-q", "p-AP2-q", "x-AP1", "x-AP2"), "rss=p-*-q,dist=x-*"),
    ],
)
def test_wide_tables(log, header, melt):
    holes = ["" if k % 3 else value for k, value in enumerate(RSS_DBM)]  # the second is heard now and then
    found = read(log(header, TIME_S, RSS_DBM, holes, DISTANCE_M, DISTANCE_M), melt=melt)
    assert [item.link.casefold() for item in found] == ["ap1", "ap2"]
    check(found[0])
    check(found[1], slice(None, None, 3))
    assert found.notes == ()


def test_wide_tables_with_one_distance(log):
    found = read(log(("t", "dist", "north", "south"), TIME_S, DISTANCE_M, RSS_DBM, RSS_DBM - 9), melt="*")
    assert [item.link for item in found] == ["north", "south"]
    check(found[0])


def test_what_melt_cannot_find(log):
    path = log(("t", "rss", "dist"), TIME_S, RSS_DBM, DISTANCE_M)
    with pytest.raises(ParamsError, match=r"no column of RSS that fits --melt ap\*"):
        read(path, melt="ap*")
    with pytest.raises(ParamsError, match="must hold one star"):
        read(path, melt="rss")


def test_the_truth_in_another_table(log):
    fine_s = np.arange(-1.0, TIME_S[-1] + 1.0, 0.01)
    truth = log(("time", "x", "y"), fine_s, 30.0 + 25.0 * np.sin(fine_s / 4.0), 0.0 * fine_s, name="truth.csv")
    path = log(("time", "rssi"), TIME_S, RSS_DBM)
    (found,) = read(path, truth=truth, station=(0.0, 0.0, 0.0))
    np.testing.assert_allclose(found.distance_m, DISTANCE_M, rtol=1e-4)
    short = log(("time", "dist"), TIME_S[:100], DISTANCE_M[:100], name="short.csv")
    found = read(path, truth=short)
    assert found[0].time_s.size == 100 and "100 × no position near in time" in found.notes[-1]
    late = log(("time", "dist"), TIME_S + 900.0, DISTANCE_M, name="late.csv")
    with pytest.raises(ParamsError, match=r"no time in common: 0.000 to 39.800 s and 900.000"):
        read(path, truth=late)
    with pytest.raises(ParamsError, match=r"truth .*none.csv.* cannot be read"):
        read(path, truth="none.csv")


def test_relative_power(log):
    path = log(("t", "rssi", "dist"), TIME_S, RSS_DBM + 120.0, DISTANCE_M)
    check(read(path, offset_db=-120.0)[0])
    with pytest.raises(ParamsError, match="name --offset-db, such as -120"):
        read(path)


def test_a_station(log):
    path = log(("t", "rss", "x", "y", "z"), TIME_S, RSS_DBM, DISTANCE_M, 0 * TIME_S + 4.0, 0 * TIME_S + 1.5)
    check(read(path, station=(0.0, 4.0, 1.5))[0])
    with pytest.raises(ParamsError, match="positions of one end only; say where the other is by --station X,Y,Z"):
        read(path)


@pytest.mark.parametrize("mark", [-200.0, -999.0, -128.0, -127.0, 0.0, 100.0, 127.0])
def test_numbers_that_stand_for_no_signal(log, mark):
    rss = RSS_DBM.copy()
    rss[::10] = mark
    found = read(log(("t", "rss", "dist"), TIME_S, rss, DISTANCE_M))
    assert found[0].time_s.size == N - N // 10 and found[0].rss_dbm.min() == np.delete(rss, slice(None, None, 10)).min()
    assert found[0].reasons == {"a number that stands for no signal": N // 10}
    assert f"20 × a number that stands for no signal (line 2 of {mark:g})" in found.notes[-1]


def test_a_scale_that_ends(log):
    rss = np.maximum(RSS_DBM, np.round(np.quantile(RSS_DBM, 0.35)))
    found = read(log(("t", "rss", "dist"), TIME_S, rss, DISTANCE_M))
    assert found[0].rss_dbm.min() > rss.min()
    assert re.search(
        r"\d+% of the rows have the lowest RSS, -\d+ dBm, where the receiver's scale seems to end", found.notes[0]
    )
    assert found[0].reasons["an RSS at the edge of what the receiver reports"] == (rss == rss.min()).sum()


def test_a_coarse_clock_is_spread(log):
    found = read(log(("t", "rss", "dist"), np.floor(TIME_S), RSS_DBM, DISTANCE_M))
    np.testing.assert_allclose(found[0].time_s, TIME_S, atol=1e-9)
    assert "as of a coarse clock" in found.notes[0]


def test_a_clock_that_is_set_back_costs_the_fewest_rows(log):
    stamps = TIME_S.copy()
    stamps[50] = 4e5  # one stamp far ahead, and the rest goes on
    found = read(log(("t", "rss", "dist"), stamps, RSS_DBM, DISTANCE_M))
    check(found[0], np.delete(np.arange(N), 50))


@pytest.mark.parametrize("back_s", [3.0, 17.0])
def test_a_clock_that_is_set_back_goes_on_there(log, back_s):
    stamps = TIME_S - back_s * (np.arange(N) >= 120)
    found = read(log(("t", "rss", "dist"), stamps, RSS_DBM, DISTANCE_M))
    check(found[0])
    assert "the clock is set back 1 times, first in line 122; it is taken to go on there" in found.notes[0]


def test_sessions_that_begin_anew_are_apart(log):
    stamps = np.concatenate([TIME_S[:80], TIME_S[:120]])
    found = read(log(("t", "rss", "dist"), stamps, RSS_DBM, DISTANCE_M))
    assert found[0].time_s.size == N and np.diff(found[0].time_s).max() == pytest.approx(20.0)


def test_an_aircraft_on_its_launch_point(log):
    found = read(log(("t", "rss", "dist"), TIME_S, RSS_DBM, np.where(np.arange(N) < 60, 0.0, DISTANCE_M)))
    assert found[0].time_s.size == N - 60 and found[0].reasons == {"a distance of 0": 60}


def test_an_implausible_speed_is_named(log):
    found = read(log(("t", "rss", "dist"), TIME_S * 1e-6, RSS_DBM, DISTANCE_M), time_unit="s")
    assert "name --time-unit" in found.notes[-1]
    found = read(log(("time_s", "rss", "dist"), TIME_S * 1e3, RSS_DBM, DISTANCE_M))  # the header is wrong
    assert "at intervals of 200 s; name --time-unit" in found.notes[-1]


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_a_range_rate_with_either_sign(log, turn):
    rate = 25.0 / 4.0 * np.cos(TIME_S / 4.0)
    found = read(log(("t", "rss", "dist", "range_rate"), TIME_S, RSS_DBM, DISTANCE_M, turn * rate))
    np.testing.assert_allclose(found[0].range_rate_mps, rate)
    assert any("sign is turned" in note for note in found.notes) == (turn < 0)


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_a_vertical_velocity_with_either_sign(log, turn):
    height = 20.0 + 10.0 * np.sin(TIME_S / 5.0)
    columns = (TIME_S, RSS_DBM, 0 * TIME_S + 9.0, 0 * TIME_S, height, 0 * TIME_S, 0 * TIME_S)
    found = read(
        log(("t", "rss", "x", "y", "z", "vx", "vy", "vz"), *columns, turn * 2.0 * np.cos(TIME_S / 5.0)),
        station=(0.0, 0.0, 0.0),
    )
    np.testing.assert_allclose(found[0].range_rate_mps, 2.0 * np.cos(TIME_S / 5.0) * height / np.hypot(9.0, height))


def test_speed_and_course(log):
    course = np.degrees(np.arctan2(1.0, 1.0)) + 0 * TIME_S
    header = ("t", "rss", "x", "y", "speed_kmh", "course")
    found = read(
        log(header, TIME_S, RSS_DBM, 5.0 + TIME_S, 5.0 + TIME_S, 0 * TIME_S + 3.6 * 2**0.5, course), station=(0, 0, 0)
    )
    np.testing.assert_allclose(found[0].range_rate_mps, 2**0.5)


def test_rows_that_are_not_armed(log):
    armed = ["True" if 20 <= k < 180 else "False" for k in range(N)]
    path = log(("t", "rss", "dist", "armed"), TIME_S, RSS_DBM, DISTANCE_M, armed)
    check(read(path)[0], slice(20, 180))
    check(read(path, whole=True)[0])


def test_files_of_one_name_are_told_apart(log, tmp_path):
    names = []
    for folder in ("may", "june"):
        (tmp_path / folder).mkdir()
        names.append(log(("t", "rss", "dist"), TIME_S, RSS_DBM, DISTANCE_M).rename(tmp_path / folder / "log.csv"))
    assert [item.source for item in read(names)] == ["may/log.csv", "june/log.csv"]
    names[1].write_text("t,rss,dist\n")
    with pytest.raises(ParamsError, match=r"log 'june/log.csv' holds no rows"):
        read(names)


@pytest.mark.parametrize(
    "column, words",
    [("Signal strength [dBm]", ("signal strength", "dbm")), ("rss_dbm", ("rss", "dbm")), ("vx_m_s", ("vx", "m/s")),
     ("t_ms", ("t", "ms")), ("x_m", ("x", "m")), ("time_s", ("time", "s")), ("AP-1", ("ap 1", ""))],
)  # fmt: skip
def test_names_without_their_units(column, words):
    assert plain(column) == words
