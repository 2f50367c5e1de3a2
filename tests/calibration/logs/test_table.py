"""Radio logs as tables: what is read, and a sentence for each thing that can be wrong with one."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.calibration.logs import read, record, table
from rss_gym.params import ParamsError

ROWS = 40
TIME_S = np.arange(ROWS) * 0.5
DISTANCE_M = 5.0 + TIME_S


def text(header, rows, delimiter=","):
    return "\n".join([delimiter.join(header), *(delimiter.join(map(str, row)) for row in rows)]) + "\n"


def plain(rows=ROWS):
    return [[TIME_S[k], -60 - k % 5, DISTANCE_M[k]] for k in range(rows)]


@pytest.fixture
def log(tmp_path):
    def write(content, name="log.csv"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize(
    "header", [("t", "rss", "dist"), ("Timestamp", "RSSI", "distance_m"), ("time_s", "rss_dbm", "distance")]
)
def test_known_names_and_delimiters(log, header, delimiter):
    (found,) = read(log(text(header, plain(), delimiter)))
    assert (found.link, found.source, found.dropped, found.range_rate_mps) == ("link", "log.csv", 0, None)
    np.testing.assert_array_equal(found.time_s, TIME_S)
    np.testing.assert_array_equal(found.rss_dbm, [row[1] for row in plain()])
    np.testing.assert_array_equal(found.distance_m, DISTANCE_M)


def test_byte_order_mark_line_ends_quotes_and_blank_lines(log):
    content = text(("t", "rss", "dist"), plain()).replace("\n", "\r\n\r\n").replace("t,rss", '"t", "rss"').encode()
    (found,) = read(log(b"\xef\xbb\xbf" + content))
    np.testing.assert_array_equal(found.distance_m, DISTANCE_M)


def test_links_interleave_and_files_stay_apart(log):
    rows = [[t, -60, d + 10 * (name == "b"), name] for t, _, d in plain() for name in ("a", "b")]
    path = log(text(("t", "rss", "dist", "ap"), rows), "one.csv")
    other = log(text(("t", "rss", "dist", "sensor"), rows[::2]), "two.csv")
    found = read([path, other])
    assert [(item.source, item.link) for item in found] == [("one.csv", "a"), ("one.csv", "b"), ("two.csv", "a")]
    np.testing.assert_array_equal(found[1].distance_m, DISTANCE_M + 10)
    assert found.notes == ()


def test_named_columns_and_constants(log):
    # A station on a mast at (3, 4, 10); the aircraft flies east over it.
    rows = [[t, -60 - k % 3, 2.0 * t - 10.0, 4.0, 30.0, 2.0, 0.0, 0.0] for k, t in enumerate(TIME_S)]
    path = log(text(("clock", "dBm", "E", "N", "U", "vE", "vN", "vU"), rows))
    columns = {"t": "clock", "rss": "dBm", "x": "E", "y": "N", "z": "U", "x2": "3", "y2": "4", "z2": "10"}
    (still,) = read(path, columns=columns)
    across_m = 2.0 * TIME_S - 13.0
    np.testing.assert_allclose(still.distance_m, np.hypot(across_m, 20.0), rtol=1e-12)
    np.testing.assert_allclose(still.range_rate_mps, 2.0 * across_m / still.distance_m, rtol=1e-12, atol=1e-12)
    (moving,) = read(path, columns={**columns, "vx": "vE", "vy": "vN", "vz": "vU"})
    np.testing.assert_allclose(moving.range_rate_mps, 2.0 * across_m / still.distance_m, rtol=1e-12, atol=1e-12)
    both = {**columns, "vx": "vE", "vy": "vN", "vz": "vU", "vx2": "2", "vy2": "0", "vz2": "0"}
    np.testing.assert_allclose(read(path, columns=both)[0].range_rate_mps, 0.0, atol=1e-12)


def test_latitude_and_longitude(log):
    # Due north of the station from the equator: a degree of the meridian is 110,574 m there.
    header = ("t", "rss", "lat", "lon", "alt", "lat2", "lon2", "alt2")
    rows = [[t, -60, 0.001 + k * 1e-5, 9.0, 50, 0, 9.0, 50] for k, t in enumerate(TIME_S)]
    (found,) = read(log(text(header, rows)))
    np.testing.assert_allclose(found.distance_m, 110_574.3 * (0.001 + np.arange(ROWS) * 1e-5), rtol=1e-5)


def test_named_positions_go_before_a_distance_that_is_not_named(log):
    header = ("t", "rss", "dist", "x", "y", "z")
    path = log(text(header, [[*row, 3.0 * row[2], 0, 0] for row in plain()]))
    np.testing.assert_array_equal(read(path)[0].distance_m, DISTANCE_M)
    station = {"x2": "0", "y2": "0", "z2": "0"}
    np.testing.assert_allclose(read(path, columns=station)[0].distance_m, 3.0 * DISTANCE_M)
    np.testing.assert_array_equal(read(path, columns={**station, "dist": "dist"})[0].distance_m, DISTANCE_M)


@pytest.mark.parametrize(
    "cell, reason",
    [("", "no RSS"), ("nan", "no RSS"), ("NA", "no RSS"), (" NaN ", "no RSS"), ("0", "stands for no signal")],
)
def test_rows_without_signal_are_dropped_and_counted(log, cell, reason):
    rows = plain()
    rows[7][1] = cell
    found = read(log(text(("t", "rss", "dist"), rows)))
    assert found[0].dropped == 1
    np.testing.assert_array_equal(found[0].time_s, np.delete(TIME_S, 7))
    assert found.notes[0].startswith("log 'log.csv': 1 of 40 rows dropped: 1 × ") and reason in found.notes[0]
    assert "line 9" in found.notes[0]
    rows = [[*row[:1], cell if k % 5 < 3 else row[1], row[2]] for k, row in enumerate(plain())]
    with pytest.raises(ParamsError, match=r"'log.csv': 24 of 40 rows \(60.0%\) cannot be used, at most 50%"):
        read(log(text(("t", "rss", "dist"), rows)))


BAD_CELLS = [
    (1, "42", "not below 0 dBm .line 5 of 42"),
    (1, "loud", "line 5, column 'rss': rss must be an RSS in dBm .*got 'loud'"),
    (2, "5;1", "line 5, column 'dist': .*got '5;1'"),
    (2, "0", "a distance of 0 .line 5 of 0"),
    (2, "-4", "line 5, column 'dist': dist must be a distance in m .*got '-4'"),
    (2, "inf", "line 5, column 'dist'.*got 'inf'"),
    (2, "", "a value is missing .line 5"),
    (0, "inf", "line 5, column 't': t must be a time.*got 'inf'"),
    (0, "0.2", "the clock goes back .line 5 of 0.2"),
    (0, "1.0", "the time of the row before .line 5 of 1"),
    (1, "-60,1", "line 5, 4 cells where the header has 3"),
    (1, '"-60', "line 5, not a row of a table"),
    (1, "-6\0", "line 5, not a row of a table: a null character"),
]


@pytest.mark.parametrize("column, cell, words", BAD_CELLS)
def test_one_bad_row_is_dropped_counted_and_named(log, column, cell, words):
    found = read(log(with_cell(3, column, cell)))
    assert found[0].dropped == 1 and found[0].time_s.size == 39
    np.testing.assert_array_equal(found[0].time_s, np.delete(TIME_S, 3))
    assert "1 of 40 rows dropped" in found.notes[0]
    assert re.search(words, found.notes[0])


@pytest.mark.parametrize("column, cell, words", BAD_CELLS)
def test_many_bad_rows_are_refused_with_the_first(log, column, cell, words):
    if "row before" in words or "distance of 0" in words:
        pytest.skip("repeated rows are no fault, and an aircraft may stand on its launch point")
    rows = plain()
    for k in (3, 11, 19, 30):
        rows[k][column] = cell
    with pytest.raises(ParamsError, match=r"log.csv.*rows \(.*\) cannot be used, at most 5% may.*line 5") as caught:
        read(log(text(("t", "rss", "dist"), rows)))
    assert "\n" not in str(caught.value)


def test_short_link_is_left_out_with_a_note(log):
    rows = [[*row, "good"] for row in plain()] + [[*row, "brief"] for row in plain(29)]
    found = read(log(text(("t", "rss", "dist", "link"), rows)))
    assert [item.link for item in found] == ["good"]
    assert found.notes == ("log 'log.csv': link 'brief' left out, 29 valid rows of 30 needed",)
    with pytest.raises(ParamsError, match="link 'brief' has 29 valid rows"):
        read(log(text(("t", "rss", "dist", "link"), rows[ROWS:])))


def test_link_without_any_valid_row(log):
    rows = [[*row, "good"] for row in plain()]
    found = read(log(text(("t", "rss", "dist", "link"), [*rows, [9, 0, 1, "mute"], [9, -70, 1, ""]])))
    assert [item.link for item in found] == ["good"]
    assert "2 of 42 rows dropped" in found.notes[0] and "line 43, no link" in found.notes[0]
    assert found.notes[1] == "log 'log.csv': link 'mute' left out, 0 valid rows of 30 needed"


def with_cell(row, column, value):
    rows = plain()
    rows[row][column] = value
    return text(("t", "rss", "dist"), rows)


@pytest.mark.parametrize(
    "content, sentence",
    [
        ("", "'log.csv' is empty"),
        ("\n \n", "'log.csv' is empty"),
        ("t,rss,dist\n", "holds no rows"),
        (",,\n1,2,3\n", "no header, line 2 is '1,2,3'; name its columns by number"),
        (text(("t", "rsi", "dist"), plain()), "no column for rss.*did you mean 'rsi'"),
        (text(("t", "rss", "range"), plain()), "neither a distance nor.*known: range, rss, t"),
        (text(("t", "rss", "t"), plain()), "names 't' twice"),
        (with_cell(3, 1, "9" * 70_000), "line 5: longer than 65536 characters"),
        (text(("t", "rss", "dist"), plain(29)), "link 'link' has 29 valid rows"),
        (text(("t", "rss", "dist"), [[t, r, 4.2] for t, r, _ in plain()]), "link 'link' is 4.2 m in every row"),
        (b"\x7fELF\x02\x01\x01" + bytes(60), "not text in UTF-8"),
        (b"\x89PNG\r\n\x1a\n" + bytes(60), "not text in UTF-8"),
        (text(("t", "rss", "dist"), plain()).encode("utf-16"), "not text in UTF-8"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(log, content, sentence):
    with pytest.raises(ParamsError, match=sentence) as caught:
        read(log(content))
    assert "log.csv" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize(
    "columns, sentence",
    [
        ({"rsi": "rss"}, "columns: 'rsi' is unknown; did you mean 'rss'"),
        ({"rss": "rssi"}, "no column 'rssi'; did you mean 'rss'"),
        ({"t": "3"}, "t must be a column"),
        ({"dist": "-1"}, r"dist must be a distance in m in .*got '-1'"),
        ({"x": "dist"}, "no column for y; give y=NAME"),
        ({"vx": "dist"}, "vx is of use only"),
    ],
)
def test_wrong_columns(log, columns, sentence):
    with pytest.raises(ParamsError, match=sentence):
        read(log(text(("t", "rss", "dist"), plain())), columns=columns)


def test_positions_out_of_range_or_in_one_place(log):
    header = ("t", "rss", "lat", "lon", "alt", "lat2", "lon2", "alt2")
    rows = [[t, -60, 0.001 * k, 9, 50, 0.01, 9, 50] for k, t in enumerate(TIME_S)]
    found = read(log(text(header, rows)))
    assert found[0].dropped == 1 and "a distance of 0 (line 12 of 0)" in found.notes[0]
    rows[5][2] = 4712345678
    assert "line 7, column 'lat': lat must be a latitude in degrees" in read(log(text(header, rows))).notes[0]


def test_more_lines_or_links_than_fit(log, monkeypatch):
    path = log(text(("t", "rss", "dist", "link"), [[*row, f"n{k}"] for k, row in enumerate(plain())]))
    monkeypatch.setattr(table, "LINKS_MAX", 12)
    with pytest.raises(ParamsError, match="line 14: link 'n12'; a log has at most 12 links"):
        read(path)
    monkeypatch.setattr(table, "ROWS_MAX", 9)
    with pytest.raises(ParamsError, match="more than 9 lines"):
        read(path)


def test_paths_that_are_no_logs(log, tmp_path, monkeypatch):
    with pytest.raises(ParamsError, match="is a folder"):
        read(tmp_path)
    with pytest.raises(ParamsError, match="is missing"):
        read([tmp_path / "none.csv"])
    with pytest.raises(ParamsError, match="is missing"):
        read("a\0b")
    with pytest.raises(ParamsError, match="no regular file"):
        read("/dev/zero")
    with pytest.raises(ParamsError, match="no log was given"):
        read([])
    with pytest.raises(ParamsError, match="'cvs' is unknown; did you mean 'csv'"):
        read(tmp_path, format="cvs")

    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    path = log(text(("t", "rss", "dist"), plain()))
    monkeypatch.setattr("pathlib.Path.open", refuse)
    with pytest.raises(ParamsError, match=r"cannot be read.*Permission denied"):
        read(path)


def sound(found):
    for item in found:
        assert item.time_s.size >= record.ROWS_MIN
        assert np.all(np.diff(item.time_s) > 0.0)
        assert np.all(item.rss_dbm < 0.0) and np.all(item.distance_m > 0.0)
        assert np.isfinite(np.concatenate([item.time_s, item.rss_dbm, item.distance_m])).all()
        assert item.time_s.shape == item.rss_dbm.shape == item.distance_m.shape


def read_or_refuse(path):
    try:
        sound(read(path))
    except ParamsError as error:
        assert "\n" not in str(error)


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    return tmp_path_factory.mktemp("scratch") / "log.csv"


@given(st.one_of(st.binary(max_size=300), st.binary(max_size=300).map(lambda tail: b"t,rss,dist\n" + tail)))
def test_any_bytes_are_read_or_refused(scratch, content):
    scratch.write_bytes(content)
    read_or_refuse(scratch)


CELL = st.one_of(
    st.sampled_from(["", "nan", "-inf", "1e308", "-70", "0", "1_0", '"', "'", "x", "٣", "0x1f", "-1e-320", ";", ","]),
    st.floats(allow_nan=True).map(repr),
    st.text(max_size=5),
)


@pytest.mark.slow
@given(edits=st.lists(st.tuples(st.integers(0, ROWS), st.integers(0, 6), CELL), max_size=3))
def test_any_cell_is_read_or_refused(scratch, edits):
    header = ["t", "rss", "x", "y", "z", "x2", "y2"]
    rows = [header, *([t, -60 - t % 3, 3.0 * t, 1, 2, -3, 4] for t in TIME_S)]
    for row, column, cell in edits:
        rows[row][column] = cell
    scratch.write_text("\n".join(",".join(map(str, [*row, "0" if k else "z2"])) for k, row in enumerate(rows)), "utf-8")
    read_or_refuse(scratch)
