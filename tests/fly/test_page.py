"""The page is one file that fetches nothing, and shows what Python scores."""

import html
import json
import re

import pytest

from rss_gym.baselines import make
from rss_gym.cli import main
from rss_gym.errors import ParamsError
from rss_gym.eval.episodes import Block, fly_all
from rss_gym.eval.suites import find
from rss_gym.fly.encounters import choose
from rss_gym.fly.engines import engines, rendered
from rss_gym.fly.page import build

COUNT = 6


@pytest.fixture(scope="module")
def page():
    return build(count=COUNT)


def data_of(page):
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page)[1])


def test_one_file_that_fetches_nothing(page):
    assert len(page.encode()) < 2_000_000
    assert "default-src 'none'" in html.unescape(page)
    assert not re.search(r"""(?:src|href)=["']|@import|url\(|fetch\(|XMLHttpRequest|import\(""", page)
    assert len(data_of(page)["encounters"]) == COUNT


def test_encounters_are_dangerous_and_varied():
    suite = find("encounter-v0")
    chosen = choose(suite, 12)
    assert len({encounter.number for encounter in chosen}) == 12
    assert len({encounter.family for encounter in chosen}) >= 5
    numbers = [encounter.number for encounter in chosen]
    flown = fly_all(make("none", suite.params), "none", suite.params, Block(suite.split, suite.seed, numbers))
    assert flown["snmac"].tolist() == [k % 4 != 3 for k in range(12)]


def test_the_page_shows_the_scores_of_python(page):
    if "chromium" not in engines():
        pytest.skip("chromium is not on the path")
    suite, first = find("encounter-v0"), data_of(page)["encounters"][0]["number"]
    block = Block(suite.split, suite.seed, [first])
    costs = []
    for name in ("none", "pathwise-plane"):
        policy = make(name, suite.params)
        costs.append(float(fly_all(policy, name, policy.params, block)["cost_m"][0]))
    shown = rendered(page, "encounter=1&keys=&time=end")
    cells = re.search(r"<th>Cost</th><td[^>]*>([\d.,]+) m</td><td[^>]*>([\d.,]+) m</td>", shown)
    assert cells, "no scores are shown"
    for cell, cost in zip(cells.groups(), costs, strict=True):
        assert cell == (f"{cost:.2f}" if cost < 100 else f"{cost:,.0f}")
    assert re.search(r'<section id="live"[^>]* hidden=""', shown)


def test_a_flight_can_stop_on_its_way(page):
    if "chromium" not in engines():
        pytest.skip("chromium is not on the path")
    shown = rendered(page, "encounter=2&keys=left&time=10")
    assert ">10.0 s<" in shown and re.search(r'<section id="end"[^>]* hidden=""', shown)


def with_script(page, before="", after=""):
    """The page with scripts of the test round its own, which its policy would not let run."""
    page = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", page)
    page = page.replace('<script type="application/json"', f'<script>{before}</script><script type="application/json"')
    return page.replace("</body>", f"<script>{after}</script></body>")


FLOWN = {
    "index": 1,
    "family": "crossing",
    "mine": {"cost": 3.0, "closest": 20.0},
    "its": {"cost": 4.0, "closest": 21.0},
}


@pytest.mark.parametrize(
    ("stored", "flights"),
    [
        (json.dumps([FLOWN, FLOWN]), 2), ("not JSON", 0),
        *(
            pytest.param(json.dumps(value), 0, marks=pytest.mark.slow)
            for value in ([{}], {}, [FLOWN | {"index": COUNT}], [FLOWN | {"its": {}}])
        ),
    ],
)  # fmt: skip
def test_the_tally_outlives_the_page(page, stored, flights):
    if "chromium" not in engines():
        pytest.skip("chromium is not on the path")
    key = data_of(page)["key"]
    before = f"localStorage.setItem({json.dumps(key)}, {json.dumps(stored)})"
    after = f"document.title = JSON.parse(localStorage.getItem({json.dumps(key)})).length"
    shown = rendered(with_script(page, before), "encounter=1")
    assert bool(re.search(r'<section id="tally"[^>]* hidden=""', shown)) == (flights == 0)
    assert ("2 encounters: your mean cost is 3.00 m" in shown) == (flights == 2)
    assert f"<title>{flights + 1}</title>" in rendered(with_script(page, before, after), "encounter=1&keys=&time=end")


def test_a_browser_that_keeps_nothing_flies_all_the_same(page):
    if "chromium" not in engines():
        pytest.skip("chromium is not on the path")
    before = "Object.defineProperty(window, 'localStorage', { get() { throw new Error('refused'); } })"
    shown = rendered(with_script(page, before), "encounter=1&keys=&time=end")
    assert "One encounter: your mean cost is" in shown


@pytest.mark.parametrize(
    ("words", "what"),
    [
        ({"suite": "encounter3d-v0"}, "planar suite"), ({"suite": "range-only-v0"}, "tell positions"),
        ({"agent": "pathwise-plain"}, "did you mean 'pathwise-plane'"), ({"suite": "nowhere-v0"}, "nowhere-v0"),
    ],
)  # fmt: skip
def test_what_a_page_cannot_fly_is_refused(words, what):
    with pytest.raises(ParamsError, match=what):
        build(**words)


def test_command(tmp_path, capsys):
    file = tmp_path / "fly.html"
    assert main(["page", "fly", "--out", str(file), "--encounters", "3"]) == 0
    assert len(data_of(file.read_text(encoding="utf-8"))["encounters"]) == 3
    assert main(["page", "fly", "--out", str(file)]) == 2
    assert "exists already" in capsys.readouterr().err
