"""Figures as markup: the page's colours, ids of their own, nothing fetched."""

import re
import sys

import pytest

from rss_gym.pages import figure as figures
from rss_gym.params import ParamsError


def draw(values, colour=figures.COLOURS[0]):
    with figures.figure("RSS & distance") as drawing:
        drawing.axes.plot(values, color=colour)
        drawing.axes.fill_between([0, 1], 0, 1, alpha=0.2)
        drawing.axes.set_xlabel("distance, m")
    return drawing.markup


def test_colours_are_the_page_s():
    markup = draw([1, 2, 3])
    assert "var(--c0)" in markup and "var(--muted)" in markup
    assert not re.search(r"#(0[1-5])\1\1|#c0000", markup)
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


def test_missing_matplotlib_is_one_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(ParamsError, match=r"-e '\.\[report\]"):
        figures.require_figures()
