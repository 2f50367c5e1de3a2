"""Figures as markup: the page's colours, ids of their own, nothing fetched."""

import re
from html import unescape

import numpy as np
import pytest

from rss_gym.pages import figure as figures
from rss_gym.pages import names
from rss_gym.pages.names import Name, shortened


def draw(values, colour=figures.COLOURS[0]):
    with figures.figure("RSS & distance") as drawing:
        drawing.axes.plot(values, color=colour)
        drawing.axes.fill_between([0, 1], 0, 1, alpha=0.2)
        drawing.axes.set_xlabel("distance, m")
    return drawing.markup


def test_colours_are_the_page_s():
    markup = draw([1, 2, 3])
    assert "var(--c0)" in markup and "var(--muted)" in markup
    assert not re.search(r"#(0[1-6])\1\1|#c0000", markup)
    assert "RSS &amp; distance" in markup


def test_same_figure_same_markup_and_others_share_no_id():
    first, second = draw([1, 2, 3]), draw([3, 2, 1])
    assert draw([1, 2, 3]) == first
    names = [set(re.findall(r'\bid="([^"]+)"', markup)) for markup in (first, second)]
    assert names[0] and not names[0] & names[1]
    for markup, known in zip((first, second), names, strict=True):
        assert set(re.findall(r'(?:url\(#|href="#)([^")]+)', markup)) <= known


def test_nothing_is_fetched_and_no_rule_leaves_the_figure():
    markup = draw([1, 2])
    assert "<image" not in markup and "@import" not in markup
    assert "<svg" in markup and ">*{" not in markup and ".plot *{" in markup


def test_a_tool_tip_is_the_title_of_its_point():
    with figures.figure("two points") as drawing:
        for x in (1.0, 2.0):
            drawing.tip(drawing.axes, x, x, f"<b>{x}</b>\nsecond line")
    assert re.findall(r'<g id="f\w+-tip-\d">\s*<title>(.*?)</title>', drawing.markup, re.DOTALL) == [
        f"&lt;b&gt;{x}&lt;/b&gt;\nsecond line" for x in (1.0, 2.0)
    ]


@pytest.mark.parametrize("text", ["$a_1$ and $b", "無線", "br\udc80ke", "<script>"])
def test_a_name_in_any_letters_is_written_as_it_is(text):
    with figures.figure("a name") as drawing:
        drawing.axes.set(xlim=(0, 1), ylim=(0, 1))
        name = Name(shortened(text, 20), 0.5, 0.5, figures.INK)
        assert names.place(drawing.axes, [name], [(0.5, 0.5)]) == []
    assert unescape(re.findall(r"<text[^>]*>([^<]*)</text>", drawing.markup)[-1]) == text.replace("\udc80", "?")


def test_names_never_overlap():
    generator = np.random.default_rng(3)
    for count in (1, 8, 40):
        spots = [(float(x), float(y)) for x, y in generator.uniform(0.1, 0.9, (count, 2))]
        with figures.figure("names", width_in=3.6, height_in=3.6) as drawing:
            drawing.axes.set(xlim=(0, 1), ylim=(0, 1))
            wanted = [Name("label" * (1 + k % 3), x, y, figures.INK) for k, (x, y) in enumerate(spots)]
            hidden = names.place(drawing.axes, wanted, spots)
            boxes = [text.get_window_extent() for text in drawing.axes.texts if text.get_visible()]
        assert len(boxes) == count - len(hidden) >= min(count, 8)
        assert not any(box.count_overlaps(boxes[:k]) for k, box in enumerate(boxes))


def test_a_long_name_loses_its_middle():
    assert shortened("abc", 3) == "abc" and shortened("abcdefghij", 7) == "abcd…ij"
