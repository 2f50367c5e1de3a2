"""One table, three ways to show it: the same numbers in each, nothing that breaks out."""

import re
import subprocess
import sys
from html import unescape

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jinja2 import UndefinedError

from rss_gym.eval.intervals import Interval
from rss_gym.pages.markup import renderer
from rss_gym.pages.table import Cell, Column, Row, Table

COST, RATE = Column("cost", "m", ".2f"), Column("rate", "%", ".1f", 100.0, interval=False)


def cells_of(html):
    """The texts of the cells, row by row."""
    rows = re.findall("<tr.*?</tr>", str(html), re.DOTALL)
    strip = lambda cell: unescape(re.sub("<[^>]*>", "", cell))  # noqa: E731
    return [[strip(cell) for cell in re.findall("<t[hd].*?</t[hd]>", row, re.DOTALL)] for row in rows]


def test_the_same_table_three_times():
    table = Table(["policy", COST, RATE], [["a", Interval(-1.25, -2.0, 3.0, 9), 0.125], ["bb", None, Cell("x | y")]])
    assert table.lines(rule=True) == [
        "policy  cost, m              rate, %",
        "------  -------------------  -------",
        "a       -1.25 [-2.00, 3.00]  12.5",
        "bb      -                    x | y",
    ]
    assert table.markdown.splitlines() == [
        "| policy | cost, m | rate, % |",
        "| --- | --- | --- |",
        "| a | -1.25 [-2.00, 3.00] | 12.5 |",
        "| bb | - | x \\| y |",
    ]
    assert cells_of(table.html) == [
        ["policy", "cost (m)", "rate (%)"],
        ["a", "−1.25 [−2.00, 3.00]", "12.5"],
        ["bb", "–", "x | y"],
    ]
    assert 'data-value="-1.25" data-low="-2.0" data-high="3.0"' in table.html


def test_marks_rows_and_heads():
    rows = [Row([Cell("1", 1, mark="the front"), Cell("n", small="by <me>")], "fault")]
    table = Table(["place", Column("name", words=True, head=True, meaning="who")], rows, "sortable")
    assert table.lines()[1] == "1*     n" and table.markdown.splitlines()[2] == "| 1 * | n |"
    assert '<table class="sortable">' in table.html and '<tr class="fault"><td data-value="1">1' in table.html
    assert '<th scope="row" class="words">n<span class="unit">by &lt;me&gt;</span></th>' in table.html
    assert (
        '<abbr title="the front">*</abbr>' in table.html and '<th scope="col" class="words" title="who">' in table.html
    )


def test_whole_numbers_stay_whole_and_counts_have_no_interval_on_a_page():
    column = Column("n", form=",")
    assert column.cell(1234).plain == "1,234"
    assert "interval" not in Table([column], [[Interval(3.0, 3.0, 3.0, 1)]]).html


@given(st.text(), st.text(), st.sampled_from(["text", "small", "mark", "dot", "class_", "style"]))
def test_nothing_breaks_out(words, title, where):
    cell = Cell(words) if where == "text" else Cell("x", **{where: words})
    html = str(Table([Column(title, meaning=words, note=words)], [Row([cell], words)], words).html)
    tags = {"div", "table", "thead", "tbody", "tr", "th", "td", "span", "abbr", "wbr", "strong"}
    assert set(re.findall(r"</?([^\s>/]+)", html)) <= tags
    assert html.count("<th ") == html.count("</th>") == 2 and html.count("<tr") == 2


def test_a_row_of_another_length_is_refused():
    with pytest.raises(ValueError):
        Table(["a", "b"], [["1"]])


def test_a_template_is_given_all_it_names(tmp_path):
    (tmp_path / "templates").mkdir()
    (tmp_path / "templates" / "x.html").write_text("{{ name }}{{ gone }}")
    with pytest.raises(UndefinedError, match="gone"):
        renderer(str(tmp_path / "x.py"))("x.html", name="<b>")


def test_no_template_is_loaded_with_the_package():
    code = "import sys, rss_gym; assert not {'jinja2', 'markupsafe', 'matplotlib'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
