"""Each metric on six encounters made by hand; definitions at their edges."""

from math import sqrt

import numpy as np
import pytest

from rss_gym.eval.metrics import Estimate, defined_in, measure
from rss_gym.params import ParamsError

METRICS = defined_in("air")

# Name -> (value, n), worked out by hand from the columns in conftest.py.
EXPECTED = {
    # 10 + 100 + 10,000, 5, 2 + 100, 1, 20 + 100 + 10,000, 0
    "cost_m": (20_338 / 6, 6),
    "collision_rate": (2 / 6, 6),
    "snmac_rate": (3 / 6, 6),
    "zone_violation_rate": (5 / 6, 6),
    "zone_severity": (1.5 / 6, 6),
    "faults": (1, 6),
    # `none` collides in encounters 0 and 1, the policy in 0 and 4
    "risk_ratio": (1.0, 6),
    "risk_ratio_unresolved": (0.5, 6),
    "risk_ratio_induced": (0.5, 6),
    # Encounters 3, 4, 5 are clear; the policy leaves by 3 (not more than 3), 3.5 and 8 m
    "unnecessary_manoeuvre_rate": (2 / 3, 3),
    # Conflicts 0, 1, 2: 50 - 30, never, 55 - 40
    "alert_lead_time_p50_s": (17.5, 2),
    "alert_lead_time_p5_s": (15.0, 2),
    "never_alerted_rate": (1 / 3, 3),
    # 10, 5, 2, 1, 20, 0
    "path_deviation_mean_m": (38 / 6, 6),
    # 30, 12, 4, 2, 150, 1
    "path_deviation_max_m": (199 / 6, 6),
    # Both complete 1, 3, 5
    "path_deviation_completed_m": ((5 + 1 + 0) / 3, 3),
    # Without collision 1, 2, 3, 5, which end 12, 9.9, 10 (not below 10) and 0 m beside the path
    "path_regained_rate": (2 / 4, 4),
    "extra_path": ((0.1 + 0.01 + 0.0) / 3, 3),
    # 2, 3, 12, 30, 60, 120
    "min_separation_p0_1_m": (2.0, 6),
    "min_separation_p1_m": (2.0, 6),
    "min_separation_p5_m": (2.0, 6),
    "min_separation_p50_m": (21.0, 6),
    # 1, 4, 6, 10, 11, 90; the quantile's rank is 6 * 0.8 + (0.8 + 1) / 3 = 5.4
    "range_error_p50_m": (8.0, 6),
    "range_error_p80_m": (11 + 0.4 * (90 - 11), 6),
    "range_rmse_m": (sqrt((1 + 16 + 36 + 100 + 121 + 8100) / 6), 6),
    # Estimates 125, 131, 150, 140 are above 120; 119 and 60 are not
    "missed_detection_decision_rate": (2 / 4, 4),
    # Runs 0, 8, 3, 9, 0 in the five encounters in the zone
    "missed_detection_encounter_rate": (2 / 5, 5),
    # Collisions 0 and 1 of `none`: warned 30 s and 0.5 s before contact
    "late_warning_rate": (1 / 2, 2),
    "missed_detection_bound": (2.56e-6, 0),
    "false_alert_rate_ph": (3 / (510 / 3600), 3),
}


def test_every_metric_is_worked_out_by_hand():
    assert list(EXPECTED) == list(METRICS)


@pytest.mark.parametrize("name", METRICS)
def test_by_hand(name, by_hand):
    value, n = EXPECTED[name]
    estimate = METRICS[name](by_hand)
    assert estimate.value == pytest.approx(value, rel=1e-12)
    assert estimate.n == n


def test_intervals_by_hand(by_hand):
    scores = measure(by_hand)
    # scipy.stats.binomtest(2, 6).proportion_ci()
    assert (scores["collision_rate"].low, scores["collision_rate"].high) == pytest.approx(
        (0.043272, 0.777222), abs=1e-6
    )
    # 38/6 -+ 2.570582 * 7.607014 / sqrt(6)
    deviation = scores["path_deviation_mean_m"]
    assert (deviation.low, deviation.high) == pytest.approx((-1.649739, 14.316405), abs=1e-5)
    # Six values: the median lies between least and greatest with 1 - 2 / 2^6
    assert (scores["min_separation_p50_m"].low, scores["min_separation_p50_m"].high) == (2.0, 120.0)
    assert (scores["faults"].low, scores["faults"].high) == (1.0, 1.0)


def test_parts_sum_to_the_risk_ratio(random_flights):
    for seed in range(50):
        scores = measure(random_flights(300, seed))
        parts = scores["risk_ratio_unresolved"].value + scores["risk_ratio_induced"].value
        assert parts == pytest.approx(scores["risk_ratio"].value, rel=1e-14, abs=1e-300)


def test_none_against_itself(random_flights, make_flights):
    none = random_flights(500).none
    scores = measure(make_flights(none, none, none))
    assert scores["risk_ratio"].value == scores["risk_ratio_unresolved"].value == 1.0
    assert scores["risk_ratio_induced"].value == 0.0
    assert 0.98 < scores["risk_ratio"].low < 1.0 < scores["risk_ratio"].high < 1.02


def test_no_collision_is_bounded_by_clopper_pearson_over_the_rate_of_none(make_flights, make_table):
    n, collided = 10_000, 4_100
    none = make_table(
        {"episode": range(n), "collision": np.arange(n) < collided, "duration_s": 100.0, "flown_s": 100.0}
    )
    policy = make_table({"episode": range(n), "duration_s": 100.0, "flown_s": 100.0})
    scores = measure(make_flights(policy, none))
    assert (scores["risk_ratio"].value, scores["risk_ratio"].low) == (0.0, 0.0)
    upper = 1.0 - 0.025 ** (1 / n)
    assert scores["risk_ratio"].high == pytest.approx(upper / (collided / n), rel=1e-3)


def test_without_collisions_of_none_ratios_are_undefined(random_flights, make_flights):
    flights = random_flights(100)
    none = flights.none.copy()
    none["collision"] = False
    scores = measure(make_flights(flights.table, none))
    for name in ("risk_ratio", "risk_ratio_unresolved", "risk_ratio_induced"):
        assert (scores[name].value, scores[name].low, scores[name].high) == (None, None, None)


def test_a_collision_costs_and_leaves_the_deviation_alone(make_flights, make_table):
    """Two flights alike until one collides, wherever: the deviation is that of what was flown."""
    for flown_s in (100.0, 80.0, 20.0):
        hit = flown_s < 100.0
        columns = {"episode": [0], "duration_s": 100.0, "flown_s": flown_s, "deviation_mean_m": 30.0}
        table = make_table(columns | {"collision": hit, "snmac": hit, "cost_m": 30.0 + 10_100.0 * hit})
        scores = measure(make_flights(table, table))
        assert scores["path_deviation_mean_m"].value == 30.0
        assert scores["cost_m"].value == 30.0 + 10_100.0 * hit


def test_clustered_false_alerts_widen_the_interval(make_flights, make_table):
    spread, clustered = np.arange(1000) % 5 == 0, np.where(np.arange(1000) % 50 == 0, 10, 0)
    widths = []
    for alerts in (spread, clustered):
        none = make_table({"episode": range(1000), "false_alerts": alerts, "flown_s": 100.0, "duration_s": 100.0})
        estimate = measure(make_flights(none, none))["false_alert_rate_ph"]
        assert estimate.value == pytest.approx(7.2)
        widths.append(estimate.high - estimate.low)
    assert widths[1] > 2.5 * widths[0]


def test_rows_chooses_encounters_in_all_tables(by_hand):
    flights = by_hand.rows(np.array([True, False, False, False, True, False]))
    assert (len(flights), flights.trials) == (2, 8)
    assert measure(flights, ["collision_rate"]) == {
        "collision_rate": Estimate(1.0, pytest.approx(0.158114), 1.0, 2, "1")
    }
    assert list(flights.reference["episode"]) == list(flights.none["episode"]) == [0, 4]


def test_unknown_metric_is_refused(by_hand):
    with pytest.raises(ParamsError, match="'colision_rate' is unknown; did you mean 'collision_rate'"):
        measure(by_hand, ["colision_rate"])


def test_tables_of_different_encounters_are_refused(random_flights, make_flights):
    flights = random_flights(10)
    with pytest.raises(ValueError, match="none must hold the same episodes"):
        make_flights(flights.table, flights.none[::-1])
    with pytest.raises(ValueError, match="reference must hold the same episodes"):
        make_flights(flights.table, flights.none, flights.reference[:5])
    with pytest.raises(ValueError, match="table must be a row of TABLE"):
        make_flights(np.zeros(10), flights.none)
