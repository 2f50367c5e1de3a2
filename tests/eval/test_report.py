"""The report page: self-contained, escaped, true to the result, and whole for degenerate results."""

import base64
import hashlib
import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser

import gymnasium as gym
import numpy as np
import pytest

import rss_gym  # noqa: F401
from rss_gym.eval import evaluate, report
from rss_gym.eval.intervals import clopper_pearson
from rss_gym.eval.metrics import Estimate, defined_in
from rss_gym.eval.report import charts, curves, replay, tables
from rss_gym.pages import page
from rss_gym.pages.numbers import interval, number
from rss_gym.params import ParamsError

METRICS = defined_in("air")

VOID = {"meta", "input", "wbr", "br", "hr", "img", "link"}
RULES = [f"orthogonal:radius_m={radius}" for radius in (20, 40)]
HOSTILE = ["<script>alert(1)</script>", '"><img src=x onerror=alert(1)>', "</script><!--\u2028&amp;'", "x" * 300]


class Page(HTMLParser):
    """A page as a list of elements with their texts; raises where they are not nested."""

    def __init__(self, markup):
        super().__init__(convert_charrefs=True)
        self.open, self.elements = [], []
        self.feed(markup)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        names = [name for name, _ in attributes]
        assert len(names) == len(set(names)), f"attribute given twice in <{tag}>"
        self.elements.append((tag, dict(attributes), []))
        if tag not in VOID:
            self.open.append((tag, self.elements[-1]))

    def handle_startendtag(self, tag, attributes):
        self.elements.append((tag, dict(attributes), []))

    def handle_endtag(self, tag):
        assert self.open and self.open[-1][0] == tag, f"</{tag}> closes {[name for name, _ in self.open]}"
        self.open.pop()

    def handle_data(self, data):
        for _, element in self.open:
            element[2].append(data)

    def all(self, tag):
        return [element for element in self.elements if element[0] == tag]

    def data(self, anchor):
        (found,) = [e for e in self.all("script") if e[1].get("id") == f"data-{anchor}"]
        return json.loads("".join(found[2]))


def page_of(result):
    return report.markup(result, replay.fly(result))


def flights_of(result):
    return replay.player(result, replay.fly(result))


def words(element):
    return " ".join("".join(element[2]).split())


@pytest.fixture(scope="module")
def result():
    return evaluate(["none", *RULES, "orthogonal:radius_m=40,lookahead_s=5", "brake"], episodes=60, progress=False)


@pytest.fixture(scope="module")
def flown(result):
    return replay.fly(result)


@pytest.fixture(scope="module")
def shown(result, flown):
    """What the player shows."""
    return replay.player(result, flown)


@pytest.fixture(scope="module")
def markup(result, flown):
    return report.markup(result, flown)


@pytest.fixture(scope="module")
def parsed(markup):
    return Page(markup)


@pytest.mark.parametrize(
    "pattern",
    ["http", r"\bsrc\s*=", "<link", "@import", r"url\((?!#)", "<iframe", r"\bfetch\(", "XMLHttp", r"import\("],
)
def test_nothing_is_fetched(markup, pattern):
    allowed = re.sub(r'xmlns(:xlink)?="http://www\.w3\.org/[^"]*"', "", markup).replace("http-equiv", "")
    assert re.search(pattern, allowed, re.IGNORECASE) is None


def test_elements_are_nested_and_links_lead_somewhere(parsed):
    ids = [attributes["id"] for _, attributes, _ in parsed.elements if "id" in attributes]
    assert len(ids) == len(set(ids))
    links = [attributes["href"] for _, attributes, _ in parsed.all("a")]
    assert len(links) == 7
    assert all(link[0] == "#" and link[1:] in ids for link in links)
    assert parsed.all("html")[0][1] == {"lang": "en"}
    assert not [name for _, attributes, _ in parsed.elements for name in attributes if name.startswith("on")]


def test_only_the_page_s_own_script_may_run(parsed):
    code = [e for e in parsed.all("script") if "type" not in e[1]]
    assert len(code) == 1
    digest = base64.b64encode(hashlib.sha256("".join(code[0][2]).encode()).digest()).decode()
    (policy,) = [e[1]["content"] for e in parsed.all("meta") if e[1].get("http-equiv") == "Content-Security-Policy"]
    assert f"script-src 'sha256-{digest}'" in policy
    assert "default-src 'none'" in policy


def test_names_cannot_break_out(result):
    names = dict(zip(("brake", *RULES, "orthogonal:radius_m=40,lookahead_s=5"), HOSTILE, strict=True))
    policies = tuple(
        replace(scored, entry=replace(scored.entry, name=names.get(scored.entry.name, scored.entry.name)))
        for scored in result.policies
    )
    markup = page_of(replace(result, policies=policies, reference="none"))
    parsed = Page(markup)
    assert len(parsed.all("script")) == 2
    assert parsed.all("img") == []
    assert "<script>alert" not in markup
    assert "\u2028" not in "".join(e[2][0] for e in parsed.all("script"))
    assert {policy["name"] for policy in parsed.data("replays")["policies"]} == {"none", *HOSTILE}
    headings = {words(e) for e in parsed.all("th") if e[1].get("scope") == "row"}
    assert {" ".join(name.split()) for name in HOSTILE} <= headings


def test_a_name_that_is_no_unicode_is_written(result, tmp_path):
    policies = tuple(
        replace(scored, entry=replace(scored.entry, name=scored.entry.name.replace("brake", "br\udc80ke")))
        for scored in result.policies
        if scored.entry.name in ("none", RULES[0], "brake")
    )
    path = report.write(replace(result, policies=policies), tmp_path)
    Page(path.read_text(encoding="utf-8"))


@pytest.mark.slow
def test_written_in_one_piece(result, markup, tmp_path, monkeypatch):
    path = report.write(result, tmp_path)
    assert path == tmp_path / "report.html"
    assert path.read_text(encoding="utf-8") == markup  # the same result, the same bytes
    assert path.stat().st_size < 5_000_000
    path.write_text("older")
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(ParamsError, match="disk full"):
        report.write(result, tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {"report.html", "flights.json"}
    assert path.read_text() == "older"


def rows_of(markup):
    """Tables as (headings, rows), a row being its name and the attributes and texts of its cells."""
    found = []
    for table in re.findall("<table.*?</table>", markup, re.DOTALL):
        parsed = Page(table)
        head, body = table.split("</thead>")
        headings = [words(e) for e in Page(head.replace("<table", "<div", 1) + "</thead></div>").all("th")]
        rows = []
        for row in re.findall("<tr[^>]*>.*?</tr>", body, re.DOTALL):
            cells = Page(row)
            rows.append((words(cells.all("th")[0]), [(e[1], words(e)) for e in cells.all("td")]))
        assert len(rows) + 1 == len(parsed.all("tr"))
        found.append((headings, rows))
    return found


def test_tables_hold_the_numbers_of_the_result(result, markup):
    found = {name: tables.column(name) for name in METRICS}
    columns = {f"{one.title} ({one.unit})" if one.unit else one.title: name for name, one in found.items()}
    assert len(columns) == len(METRICS), "two metrics have one heading"
    seen = set()
    for headings, rows in rows_of(markup):
        for place, heading in enumerate(headings[1:]):
            for policy, cells in rows if heading in columns else []:
                estimate = result[policy][columns[heading]]
                attributes, shown = cells[place]
                for key in ("value", "low", "high"):
                    given = attributes.get(f"data-{key}")
                    assert (None if given is None else float(given)) == getattr(estimate, key)
                assert shown.startswith(number(estimate.value))
                seen.add((policy, columns[heading]))
    policies = [scored.entry.name for scored in result.policies]
    assert seen == {(policy, name) for policy in policies for name, metric in METRICS.items() if not metric.sensor}


def test_sensor_table_holds_the_numbers_of_none(result, markup):
    (rows,) = [rows for headings, rows in rows_of(markup) if headings[0] == "figure"]
    sensor = {tables.title(name, metric.unit): name for name, metric in METRICS.items() if metric.sensor}
    assert [name for name, _ in rows] == list(sensor)
    for name, cells in rows:
        estimate = result["none"][sensor[name]]
        assert cells[0][1].startswith(number(estimate.value))
        assert cells[2][1] == f"{estimate.n:,}"


def test_family_table_counts_collisions(result, markup):
    (table,) = [(heads, rows) for heads, rows in rows_of(markup) if "crossing" in heads[1]]
    assert len(table[0]) == 1 + len(result.suite.families)
    for scored, (name, cells) in zip(result.policies, table[1], strict=True):
        assert name == scored.entry.name
        for index, (attributes, shown) in enumerate(cells):
            rows = scored.table[scored.table["family"] == index]
            rate = clopper_pearson(int(rows["collision"].sum()), len(rows))
            if len(rows):
                assert float(attributes["data-value"]) == rate.value
                assert f"[{number(rate.low, 2)}, {number(rate.high, 2)}]" in shown
            else:
                assert shown == "–"


def test_page_names_the_run(result, markup):
    for fact in (result.suite.name, result.suite.hash, "not an official run", "seed 0", "split suite", "numpy"):
        assert fact in markup


@pytest.mark.parametrize(
    ("policies", "settings"),
    [
        (["none"], {"episodes": 1}),
        (["none", "orthogonal"], {"episodes": 1}),
        (["none", *RULES], {"episodes": 5, "families": ["no-conflict"]}),
        (["none", "orthogonal"], {"episodes": 3, "intruders": 3}),
        (["none", "orthogonal"], {"episodes": 3, "suite": "encounter3d-v0"}),
        (["modified-orthogonal"], {"episodes": 3, "suite": "range-only-v0"}),
    ],
    ids=["one encounter", "one each", "no collision", "three intruders", "space", "range only"],
)
def test_degenerate_results(policies, settings):
    result = evaluate(policies, progress=False, **settings)
    parsed = Page(page_of(result))
    assert parsed.data("replays")["policies"]


def test_figures_that_are_undefined(result, flown):
    nothing = Estimate(None, None, None, 0, "1")
    policies = tuple(replace(scored, metrics=dict.fromkeys(scored.metrics, nothing)) for scored in result.policies)
    markup = report.markup(replace(result, policies=policies), flown)
    Page(markup)
    assert "No policy has both" in markup
    assert not re.search(r"\b(None|nan)\b", re.sub("<script.*?</script>", "", markup, flags=re.DOTALL))


# The replays


def test_flights_equal_those_of_the_environment(result, shown):
    """A second way to the same flight: the single environment, step by step."""
    data, cases = shown, {policy["name"]: policy["cases"] for policy in shown["policies"]}
    for scored in result.policies[1:3]:
        params = scored.entry.params
        for case in cases[scored.entry.name]:
            flight = data["flights"][case["flight"]]
            env = gym.make("rss_gym/Encounter-v0", params=params.to_dict()).unwrapped
            observation, _ = env.reset(seed=result.seed, options={"split": "suite", "episode": case["episode"]})
            state, start, over, path, intruder = None, np.ones(1, bool), False, [], []
            while True:
                path.append(env.batch.state.aircraft[0]["position_m"][:, :2].copy())
                if over:
                    break
                action, state = scored.entry.policy.predict(observation[None], state, start)
                observation, _, terminated, truncated, _ = env.step(action[0])
                start, over = np.zeros(1, bool), terminated or truncated
            flown = np.array(path)
            assert len(flight["times"]) == len(flown)
            own = np.reshape(flight["own"]["position"], (-1, 2)) / 10.0
            intruder = np.reshape(flight["intruders"][0]["position"], (-1, 2)) / 10.0
            assert np.abs(own - flown[:, 0]).max() <= 0.05 + 1e-9
            assert np.abs(intruder - flown[:, 1]).max() <= 0.05 + 1e-9
            row = scored.table[scored.table["episode"] == case["episode"]][0]
            assert flight["least"][-1] == round(100 * row["min_separation_m"])
            assert flight["times"][-1] == pytest.approx(row["flown_s"])
            assert flight["collision"] == row["collision"]
            assert flight["same"]
            assert max(flight["intruders"][0]["warning"]) == (row["warned_s"] >= 0)


def test_closest_encounters_are_shown_beside_the_rule(result, shown):
    data = shown
    assert data["beside"] == "orthogonal:radius_m=20"
    for scored, policy in zip(result.policies, data["policies"], strict=True):
        assert policy["name"] == scored.entry.name
        nearest = np.sort(scored.table["min_separation_m"])[:3]
        assert [case["least_m"] for case in policy["cases"]] == [round(float(value), 2) for value in nearest]
        for case in policy["cases"]:
            beside = data["flights"][case["beside"]]["name"]
            assert beside == ("none" if policy["name"] == data["beside"] else data["beside"])
    assert data["left_out"] == []


def test_what_is_left_out_is_said(result, monkeypatch):
    monkeypatch.setattr(replay, "POLICIES", 3)
    data = flights_of(result)
    assert [policy["name"] for policy in data["policies"]] == ["none", "orthogonal:radius_m=20", "brake"]
    assert "orthogonal:radius_m=40" in data["left_out"]
    assert "orthogonal:radius_m=40" in replay.markup(data)


class Moody:
    """Flies otherwise, or not at all, when asked again."""

    def __init__(self, error=False):
        self.flights, self.error = 0, error

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        self.flights += int(np.any(episode_start))
        if self.flights > 1 and self.error:
            raise RuntimeError("<b>no</b>")
        return np.full((len(observation), 2), 0.3 * (self.flights - 1)), None


def test_a_flight_that_does_not_repeat_is_marked():
    result = evaluate({"none": "none", "moody": Moody()}, episodes=4, progress=False)
    data = flights_of(result)
    assert {flight["name"] for flight in data["flights"] if not flight["same"]} == {"moody"}


def test_a_policy_that_fails_when_flown_again_leaves_a_page():
    result = evaluate({"none": "none", "moody": Moody(error=True)}, episodes=4, progress=False)
    data = flights_of(result)
    assert [policy["name"] for policy in data["policies"]] == ["none"]
    markup = page_of(result)
    Page(markup)
    assert "&lt;b&gt;no&lt;/b&gt;" in markup
    assert "<b>no</b>" not in markup


# The chart


def test_curves_join_settings_of_one_rule():
    specs = [
        "none",
        "orthogonal:radius_m=40",
        "orthogonal:radius_m=20",
        "orthogonal:radius_m=40,lookahead_s=5",
        "orthogonal:radius_m=20, lookahead_s=5",
        "orthogonal:radius_m=40,lookahead_s=2",
        "orthogonal:radius_m=60",
        "orthogonal@oracle:radius_m=20",
        "module:attribute",
        None,
    ]
    found = {curve.label: curve.members for curve in curves.find(specs)}
    assert found == {
        "orthogonal over radius_m, lookahead_s = 0.5": ((2, 20.0), (1, 40.0), (6, 60.0)),
        "orthogonal over radius_m, lookahead_s = 5": ((4, 20.0), (3, 40.0)),
        "orthogonal over lookahead_s, radius_m = 40": ((1, 0.5), (5, 2.0), (3, 5.0)),
    }
    assert [curve.label for curve in curves.find(specs[:3])] == ["orthogonal over radius_m"]
    assert curves.find(["none", "orthogonal", None]) == []


def rate(value, low, high):
    return Estimate(value, low, high, 1000, "1")


def test_axes_hold_points_and_bounds():
    metres = Estimate(8.0, 7.5, 8.5, 1000, "m")
    points = [
        charts.Point("a", metres, rate(0.4, 0.37, 0.43), "c0", "a"),
        charts.Point("b", metres, rate(0.0, 0.0, 3.7e-3), "c1", "b"),
        charts.Point("c", metres, rate(2e-3, 2.4e-4, 7.2e-3), "c2", "c"),
    ]
    limits = charts.limits(points)
    assert limits["ylim"] == (1e-3, 1.0) and limits["xlim"][0] <= 0.0 and limits["xlim"][1] > 8.5
    assert points[1].y == 3.7e-3


def test_the_front_is_ringed_and_the_best_corner_named(result):
    chart = sizes(charts.safety(result))["wide"]
    fronts = sum(place.front for _, place in tables.ordered(result))
    assert len(re.findall(r'id="[^"]*-front-\d+"', chart)) == fronts > 0
    assert "best is lower left" in chart


def test_no_event_is_an_arrow_from_the_upper_bound(result):
    none = {**result["none"], "collision_rate": rate(0.0, 0.0, 0.06)}
    some = {**result["brake"], "collision_rate": rate(0.01, 0.005, 0.02)}
    first, *_, last = result.policies
    shown = replace(result, policies=(replace(first, metrics=none), replace(last, metrics=some)))
    chart = sizes(charts.safety(shown))["wide"]
    assert len(re.findall(r'id="[^"]*-bound-\d+"', chart)) == 1
    assert "none\ncollision rate 0 [0, 0.0600]" in chart


def sizes(markup):
    """The figures by their size."""
    return dict(re.findall(r'<figure class="plot (\w+)">(.*?)</figure>', markup, re.DOTALL))


def test_every_size_has_the_same_points_and_names_for_those_who_see_none(result):
    found = sizes(charts.safety(result))
    assert [*found] == ["wide", "medium", "narrow"]
    for chart in found.values():
        assert 'role="img" aria-label="Collisions per encounter against mean deviation"' in chart
        assert chart.count("<title>") == len(result.policies)
        # 12 pixels or more, 9 of the 72 units of an inch; the page shows the size that it need not shrink.
        assert min(float(size) for size in re.findall(r"font(?:-size)?: (?:\w+ )?([\d.]+)px", chart)) >= 9.0


# Numbers


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, "0"),
        (0.41234, "0.412"),
        (1.0, "1.00"),
        (0.9996, "0.9996"),
        (0.99999999, "1.00000"),
        (0.001, "0.00100"),
        (0.00099, "9.90×10⁻⁴"),
        (2.56e-6, "2.56×10⁻⁶"),
        (9.996, "10.0"),
        (123.4, "123"),
        (5558.0, "5,558"),
        (-3.21, "−3.21"),
        (2.5e9, "2.50×10⁹"),
        (math.inf, "∞"),
        (math.nan, "–"),
        (None, "–"),
    ],
)
def test_numbers(value, shown):
    assert number(value) == shown


def test_intervals():
    assert interval(rate(0.1, 0.05, 0.2)) == "[0.0500, 0.200]"
    assert interval(rate(0.1, None, None)) == ""
    assert interval(rate(0.1, 0.05, None)) == "[0.0500, –]"


def test_titles_of_metrics():
    assert tables.title("min_separation_p0_1_m", "m") == "min separation, 0.1 %"
    assert tables.title("alert_lead_time_p50_s", "s") == "alert lead time, median"
    assert tables.title("snmac_rate", "1") == "sNMAC rate"
    assert tables.title("false_alert_rate_ph", "1/h") == "false alert rate"


def test_embedded_json_cannot_end_its_element():
    value = {"name": "</script><!-- & \u2028\u2029 é"}
    embedded = page.embedded(value)
    assert not set("<>&\u2028\u2029") & set(embedded)
    assert json.loads(embedded) == value
    with pytest.raises(ValueError):
        page.embedded(float("nan"))
