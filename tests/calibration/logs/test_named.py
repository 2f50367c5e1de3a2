"""Every error about a log says which, told from others of the same name, and the link and line where there is one."""

import contextlib
import io
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.cli import main

ROWS = 60


def level(row):
    return round(-40.0 - 27.0 * math.log10(20 + row) + row % 3, 1)


def table(**columns):
    """Lines of a table with a link `x`; a column is a function of the row, or a constant."""
    names = {"t": lambda row: 0.2 * row, "link": "x", "rss": level, "dist": lambda row: 20 + row}
    names |= columns
    rows = [[value(row) if callable(value) else value for value in names.values()] for row in range(ROWS)]
    return "\n".join([",".join(names), *(",".join(map(str, row)) for row in rows), ""])


def refusal(capsys, tmp_path, content, *options, name="flight.csv"):
    """What is said of a bad log beside a good one of the same name: one line where it is refused, nothing written."""
    good, bad = tmp_path / "may" / name, tmp_path / "june" / name
    for path, text in ((good, table()), (bad, content)):
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
    out = tmp_path / "channel.toml"
    for way in (["--inspect"], ["--out", str(out)]):
        status = main(["calibrate", str(good), str(bad), *way, *options])
        output = capsys.readouterr()
        said = output.err.strip() if status else output.out
        assert "june/flight.csv" in said, said
        assert status == 0 or (status == 2 and said.count("\n") == 0 and not out.exists()), said
    return said


BAD = {
    "empty": ("", ""),
    "only a header": ("t,link,rss,dist\n", ""),
    "no column of RSS": (table().replace("rss", "height"), "rss"),
    "a column twice": (table().replace("link", "rss", 1), "rss"),
    "words for most levels": (table(rss=lambda row: "strong" if row > 3 else -50), "line 6"),
    "words for most times": (table(t=lambda row: f"noon{row}" if row > 3 else row), "line 6"),
    "most distances negative": (table(dist=lambda row: -row - 1.0), "line 2"),
    "levels above 0": (table(rss=lambda row: 20 + row % 5), "line 2"),
    "short": ("\n".join(table().splitlines()[:20]) + "\n", "link 'x'"),
    "distance of one value": (table(dist=20.0), "link 'x'"),
    "all at one time": (table(t=5.0), "link 'x'"),
    "clock going back": (table(t=lambda row: 100.0 - row), "line"),
    "not text": (b"\xff\xfe\x00\x01" * 300, ""),
    "null characters": (table().replace("x", "x\0"), "UTF-8"),
    "an endless line": ("t,link,rss,dist\n" + "1" * 2_000_000, ""),
    "level rises with distance": (table(rss=lambda row: -90 + row), "link 'x'"),
    "level is constant": (table(rss=-60.0), "link 'x'"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_log_is_named(capsys, tmp_path, case):
    content, also = BAD[case]
    assert also in refusal(capsys, tmp_path, content)


@pytest.mark.parametrize(
    "options",
    [
        ["--columns", "rss=power"],
        ["--columns", "9=rss,1=t,4=dist"],
        ["--columns", "t=t,rss=rss,dist=link"],
        ["--melt", "rss=rssi_*"],
        ["--from", "1e6"],
        ["--to", "-5"],
        ["--format", "mavlink"],
        ["--format", "ulog"],
        ["--format", "dataflash"],
        ["--format", "ros"],
        ["--format", "edgetx"],
    ],
    ids=" ".join,
)
def test_options_that_do_not_fit_a_log_name_it(capsys, tmp_path, options):
    path = tmp_path / "june" / "flight.csv"
    path.parent.mkdir()
    path.write_text(table())
    assert main(["calibrate", str(path), "--out", str(tmp_path / "channel.toml"), *options]) == 2
    said = capsys.readouterr().err
    assert "flight.csv" in said and said.count("\n") == 1, said


CELLS = st.one_of(
    st.text(max_size=5),
    st.sampled_from(
        ["", "nan", "inf", "-inf", "1e400", "-0", "0", "1e-320", '"', "'", "\0", "١٢", "0x10", "1_000", "12:00", "TRUE"]
    ),
    st.floats().map(repr),
)


@pytest.mark.slow
@given(column=st.integers(0, 3), cells=st.lists(CELLS, min_size=1, max_size=4))
def test_columns_of_any_cells(tmp_path_factory, column, cells):
    lines = [line.split(",") for line in table().splitlines()]
    for number, cell in enumerate(lines[1:]):
        cell[column] = cells[number % len(cells)]
    path = tmp_path_factory.mktemp("cells") / "flight.csv"
    path.write_bytes("\n".join(",".join(line) for line in lines).encode("utf-8", "surrogatepass"))
    for way in (["--inspect"], ["--out", str(path.with_name("channel.toml"))]):
        with contextlib.redirect_stderr(io.StringIO()) as said, contextlib.redirect_stdout(io.StringIO()):
            status = main(["calibrate", str(path), *way])
        assert status in (0, 2)
        if status:
            assert "flight.csv" in said.getvalue() and said.getvalue().count("\n") == 1, said.getvalue()
