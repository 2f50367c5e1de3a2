"""A result shows itself in one line, as a table, and as a data frame."""

import pytest

from rss_gym.eval import evaluate


@pytest.fixture(scope="module")
def result():
    given = {"<b>bold</b>": "none", "x" * 150: "stop", **{f"policy {n}": "none" for n in range(10)}}
    return evaluate(given, episodes=3)


def test_the_line_is_short(result):
    text = repr(result)
    assert "\n" not in text and len(text) < 1000 and "3 episodes of encounter-v0" in text and "more" in text


def test_the_table_is_escaped_and_has_every_policy(result):
    html = result._repr_html_()
    assert html.count("<tr>") == 1 + len(result.policies)
    assert "&lt;b&gt;bold" in html and "<b>" not in html and "cost (m)" in html
    assert len(html) < 20_000


def test_the_frame_has_every_metric(result):
    pytest.importorskip("pandas")
    frame = result.to_frame()
    assert list(frame.index) == [scored.entry.name for scored in result.policies]
    for scored in result.policies:
        for name, found in scored.metrics.items():
            assert frame.loc[scored.entry.name, name] == pytest.approx(found.value, nan_ok=True) or found.value is None
            assert {f"{name}_low", f"{name}_high"} <= set(frame.columns)
