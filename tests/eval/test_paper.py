"""The reproduction of the paper: its numbers, their criterion, the page, the command."""

import json
import math
import os
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.cli import main
from rss_gym.eval import paper
from rss_gym.eval.intervals import Interval
from rss_gym.eval.paper import page, scan
from rss_gym.eval.paper.flights import PERIOD_S, paper_flights, tuning_flights
from rss_gym.eval.paper.number import RELATIONS, ROLES, Number, agrees, counts, exact, over
from rss_gym.eval.paper.recorded import recorded
from rss_gym.eval.paper.study import METHODS, Study
from rss_gym.params import ParamsError

pytestmark = pytest.mark.slow

SMALL = paper.Size(repetitions=6, tuning=2, circular=1, allan=3, trials=200_000, approaches=1_000, pairs=20, scan=1)
ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("RSS_GYM_DATA") or ROOT.parent / "shared" / "data")
FIELDS = {
    "id": str, "what": str, "paper": float, "measured": float, "low": float, "high": float, "n": int, "unit": str,
    "role": str, "relation": str, "tolerance": float, "note": str,
}  # fmt: skip


@pytest.fixture(scope="module")
def small():
    return paper.reproduce(SMALL, seed=3)


@pytest.fixture(scope="module")
def folder(small, tmp_path_factory):
    return paper.write(small, tmp_path_factory.mktemp("paper") / "out")


@pytest.fixture(scope="module")
def entries(folder):
    return {entry["id"]: entry for entry in json.loads((folder / paper.NUMBERS).read_text(encoding="utf-8"))}


def number(**changes):
    fields = {"id": "x", "what": "x", "paper": 4.0, "seen": Interval(5.0, 4.5, 5.5, 9), "role": "reproduced"}
    return Number(**(fields | changes))


def test_every_entry_has_its_fields(small, entries):
    assert len(entries) == len(small.numbers)
    for entry in entries.values():
        assert set(entry) == {*FIELDS, "agrees"}
        for name, kind in FIELDS.items():
            assert isinstance(entry[name], kind), (entry["id"], name)
        assert entry["role"] in ROLES and entry["relation"] in RELATIONS
        assert entry["low"] <= entry["measured"] <= entry["high"] and math.isfinite(entry["high"] - entry["low"])
        assert not any(mark in entry["what"] + entry["note"] for mark in ("{", "nan", "inf ", "None"))
        assert entry["what"] and (entry["note"] or entry["low"] == entry["high"])


def test_agreement_is_recomputed_from_the_fields(entries):
    for entry in entries.values():
        low, high = entry["low"] - entry["tolerance"], entry["high"] + entry["tolerance"]
        verdict = {
            "equals": low <= entry["paper"] <= high,
            "at least": entry["low"] >= entry["paper"] - entry["tolerance"],
            "at most": entry["high"] <= entry["paper"] + entry["tolerance"],
        }[entry["relation"]]
        uncounted = entry["role"] in ("calibrated", "beside")
        assert entry["agrees"] is (None if uncounted else verdict), entry["id"]


def test_what_does_not_agree_has_a_reason(entries):
    assert all(entry["note"] for entry in entries.values() if entry["agrees"] is False)


def test_numbers_of_section_vi_are_exact(entries):
    measured = {name: entries[name]["measured"] for name in ("n_d", "S-4", "S-16", "N_d")}
    assert measured == {"n_d": 8.0, "S-4": 120.0, "S-16": 240.0, "N_d": 39.0}
    for speed, stated in ((1, 25.39), (2, 12.69), (3, 8.46)):
        assert round(entries[f"coherence-2.5-{speed}"]["measured"], 2) == pytest.approx(stated, abs=0.005)
    assert entries["coherence-2.462-1"]["measured"] == pytest.approx(25.78, abs=0.005)
    assert not entries["coherence-2.462-1"]["agrees"]


def test_counting_finds_what_it_must(entries):
    for radius, n in ((115, 7), (230, 7), (120, 8), (240, 8)):
        entry = entries[f"fig12-counted-{radius}"]
        assert entry["role"] == "by construction" and entry["low"] <= 0.2**n <= entry["high"]


def test_least_squares_and_the_allan_slope_are_calibrated_and_count_nowhere(small, entries):
    calibrated = {name for name, entry in entries.items() if entry["role"] == "calibrated"}
    assert calibrated == {"fig10-ls", "fig3-rise-paper"}
    beside = {name for name, entry in entries.items() if entry["role"] == "beside"}
    assert {"fig11a-white", "fig11a-white-r", "scan-tuned", "outdoor-coloured"} <= beside
    assert all(entries[name]["agrees"] is None for name in calibrated | beside)
    assert sum(total for _, total in counts(small.numbers).values()) == len(entries) - len(calibrated | beside)


def test_every_number_of_the_paper_that_is_reproduced(entries):
    tests = {"fig10-ekf", "fig10-gain", "fig11a-white-same", "fig11a-gain-same", "fig11c-velocity", "fig11c-gain"}
    reproduced = {name: entry for name, entry in entries.items() if entry["role"] == "reproduced"}
    assert tests < set(reproduced) and len(reproduced) >= 14
    assert all(entry["agrees"] for entry in reproduced.values()), [n for n, e in reproduced.items() if not e["agrees"]]


def test_the_factor_of_two_is_that_of_the_same_process_noise(small):
    found = {(p.ratio, p.tc_s): p for p in scan.points(SMALL, 3, small.study.channel) if p.pace == 1.0}
    assert found[64.0, 0.15].factor > 1.7 and found[1.0, 5.0].factor < 1.2
    assert 0.8 < np.median([point.tuned for point in found.values()]) < 1.1
    assert scan.slope(64.0, 0.5) > 0.0 > scan.slope(1.0, 0.05) and scan.slope(1e-9, 1.0) == pytest.approx(
        -1.0, abs=1e-6
    )


@pytest.mark.parametrize("pace", [0.5, 2.0])
def test_another_pace_is_the_same_path(pace):
    for one, other in zip(paper_flights(), paper_flights(pace), strict=True):
        k = np.arange(0, len(one.time_s), 10)
        at = np.round(one.time_s[k] / pace / PERIOD_S, 6)
        whole = (at == np.round(at)) & (at < len(other.time_s))
        np.testing.assert_allclose(other.position_m[at[whole].astype(int)], one.position_m[k[whole]], atol=1e-9)


def test_recorded_logs_show_the_pattern_of_the_paper(monkeypatch):
    monkeypatch.setenv("RSS_GYM_DATA", "nowhere")
    assert recorded(0) is None
    if not (DATA / "wifi_walk").is_dir():
        pytest.skip(f"no recorded logs at {DATA}; set RSS_GYM_DATA to the folder that holds wifi_walk")
    monkeypatch.setenv("RSS_GYM_DATA", str(DATA))
    p80_m = {name: values[0] for name, values in recorded(0).p80_m.items()}
    assert p80_m == pytest.approx({"ls": 7.8, "white-same": 6.6, "white": 3.4, "coloured": 3.3}, abs=0.1)


def test_what_too_few_approaches_cannot_show_has_no_number(entries):
    assert "fig12-covers" not in entries and not entries["fig12-flown"]["agrees"]
    assert "too few" in entries["fig12-flown"]["note"]


def test_flown_form_of_the_rule_never_falls_short(entries):
    assert entries["fig14-flown"]["agrees"] and entries["fig14-step"]["agrees"]
    assert entries["fig14-printed"]["measured"] > 0.5


def test_page_is_whole_and_fetches_nothing(small, folder):
    text = (folder / paper.PAGE).read_text(encoding="utf-8")
    assert len(small.panels) == len(paper.FIGURES) == text.count("<svg")
    for panel in small.panels:
        assert not any(mark in panel.paper + panel.here for mark in ("{", "nan", "inf ", "None"))
        assert panel.figure.count("<path") > 5 and panel.paper and panel.here and panel.title in text
    assert "default-src 'none'" in text
    assert not re.search(r'\b(?:src|href)="(?!#)', text.replace('xmlns:xlink="http', ""))
    # Every row of every table has as many cells as the table has headings.
    for table in re.findall(r"<table>.*?</table>", text, flags=re.DOTALL):
        columns = len(re.findall(r'<th scope="col"', table))
        for row in re.findall(r"<tr><th scope=\"row\">.*?</tr>", table, flags=re.DOTALL):
            assert row.count("<td") == columns - 1
    for one in small.numbers:
        assert text.count(f'data-value="{one.measured!r}"') >= 2  # beside its figure and in the table of all


def test_same_seed_same_numbers_and_page(small):
    again = Study(SMALL, seed=3)
    for name in ("2", "11c", "14"):
        panel = paper.FIGURES[name](again)
        first = small.panels[list(paper.FIGURES).index(name)]
        assert panel == first
    other = paper.FIGURES["11c"](Study(SMALL, seed=4))
    assert other.numbers[0].measured != small.panels[list(paper.FIGURES).index("11c")].numbers[0].measured


def test_filters_are_tuned_apart_from_what_is_reported(small):
    study = small.study
    assert study.others.logs[0].rss_dbm.shape[0] == SMALL.tuning
    flown = {round(float(f.speed_mps.max()), 6) for f in study.flown.flights}
    assert not flown & {round(float(f.speed_mps.max()), 6) for f in study.others.flights}
    for name in METHODS:
        if METHODS[name].tuned:
            best = study.noise_m2_ps(name)
            errors = {q: study.others.errors_m(METHODS[name], study.channel, q) for q in (best / 10, best, best * 10)}
            assert np.quantile(errors[best], 0.8) == min(np.quantile(error, 0.8) for error in errors.values())


@pytest.mark.parametrize("flights", [paper_flights(), tuning_flights()], ids=["paper", "tuning"])
def test_flights_are_like_those_of_the_paper(flights):
    assert len({flight.name for flight in flights}) == len(flights)
    for flight in flights:
        assert flight.distance_m.max() < 60.0 and flight.speed_mps.max() <= 5.0 + 1e-9
        assert np.allclose(np.diff(flight.time_s), PERIOD_S)
        assert np.allclose(flight.position_m[0], flight.position_m[-1])
        acceleration = np.diff(flight.position_m, n=2, axis=0) / PERIOD_S**2
        assert np.linalg.norm(acceleration, axis=1).max() <= 1.0 + 1e-6
        assert np.allclose(np.cumsum(flight.range_rate_mps) * PERIOD_S, flight.distance_m - flight.distance_m[0])
    assert len(paper_flights()) == 12
    assert sorted({float(flight.position_m[0, 2]) for flight in paper_flights()}) == [10.0, 20.0, 30.0]


@given(
    low=st.floats(-10, 10), width=st.floats(0, 10), paper_value=st.floats(-10, 10), tolerance=st.floats(0, 5),
    relation=st.sampled_from(RELATIONS),
)  # fmt: skip
def test_a_wider_tolerance_never_takes_agreement_away(low, width, paper_value, tolerance, relation):
    fields = {"paper": paper_value, "low": low, "high": low + width, "role": "claim", "relation": relation}
    if agrees(fields | {"tolerance": tolerance}):
        assert agrees(fields | {"tolerance": tolerance + 1.0})


def test_the_criterion_by_hand():
    assert number().agrees is False
    assert number(tolerance=0.5).agrees is True
    assert number(relation="at least").agrees is True
    assert number(relation="at most").agrees is False
    assert number(relation="at most", tolerance=1.5).agrees is True
    assert number(role="calibrated", tolerance=9.0).agrees is None
    assert number(seen=exact(4.0)).agrees is True and number(seen=exact(4.001)).agrees is False
    assert over(np.arange(101.0)) == Interval(50.0, 2.5, 97.5, 101)


@pytest.mark.parametrize(
    "changes",
    [
        {"role": "true"},
        {"relation": "about"},
        {"paper": math.nan},
        {"tolerance": -1.0},
        {"seen": Interval(5.0, None, 6.0, 3)},
        {"seen": Interval(5.0, 5.5, 6.0, 3)},
        {"seen": Interval(math.nan, math.nan, math.nan, 3)},
    ],
)
def test_a_number_that_makes_no_sense_is_refused(changes):
    with pytest.raises(ParamsError, match="number 'x'"):
        number(**changes)


@pytest.mark.parametrize("changes", [{"repetitions": 1}, {"trials": 0}, {"approaches": 1.5}])
def test_a_size_that_is_too_small_is_refused(changes):
    with pytest.raises(ParamsError, match=next(iter(changes))):
        paper.Size(**changes)


def test_markdown_has_a_row_for_each_number(small):
    lines = page.markdown(small.numbers).splitlines()
    assert len(lines) == len(small.numbers) + 2
    assert len({len(re.findall(r"(?<!\\)\|", line)) for line in lines}) == 1


def test_the_command_refuses_an_existing_folder_before_it_runs(capsys, tmp_path):
    (tmp_path / "mine.txt").write_text("precious")
    assert main(["paper", "--out", str(tmp_path)]) == 2
    captured = capsys.readouterr()
    assert not captured.out and "exists and is not empty" in captured.err and len(captured.err.splitlines()) == 1
    assert (tmp_path / "mine.txt").read_text() == "precious"


@pytest.mark.parametrize("seed", ["-1", str(2**31)])
def test_the_command_refuses_a_bad_seed(capsys, tmp_path, seed):
    assert main(["paper", "--seed", seed, "--out", str(tmp_path / "out")]) == 2
    assert "seed" in capsys.readouterr().err and not list(tmp_path.iterdir())


def test_the_command_writes_both_files(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(paper, "QUICK", SMALL)
    monkeypatch.setattr(paper, "FIGURES", {name: paper.FIGURES[name] for name in ("4", "6")})
    assert main(["paper", "--quick", "--out", str(tmp_path / "out")]) == 0
    out = capsys.readouterr().out
    assert "numbers computed anew agree" in out and str(tmp_path / "out" / "paper.json") in out
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["index.html", "paper.json"]
