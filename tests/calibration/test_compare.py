"""Tuning, and the errors of the methods with their intervals."""

import dataclasses

import numpy as np
import pytest

from rss_gym.calibration.fit import fit
from rss_gym.eval.studies.calibration.calibrate import calibrate
from rss_gym.eval.studies.calibration.compare import compare
from rss_gym.eval.studies.calibration.methods import available, methods, ranges
from rss_gym.eval.studies.calibration.tune import GRID, SHARE, tune
from rss_gym.params import ParamsError

CONSTANT = {"constant": methods()["constant"]}


def errors_m(result, name):
    pairs = zip(result.scores[name].ranges_m, result.tested, strict=True)
    return np.concatenate([np.abs(range_m - record.distance_m) for range_m, record in pairs])


def test_figures_are_those_of_the_errors(result):
    for name, score in result.scores.items():
        error_m = errors_m(result, name)
        assert score.p50_m.value == pytest.approx(np.quantile(error_m, 0.5))
        assert score.p80_m.value == pytest.approx(np.quantile(error_m, 0.8))
        assert score.rmse_m.value == pytest.approx(np.sqrt(np.mean(error_m**2)))
        for figure in (score.p50_m, score.p80_m, score.rmse_m):
            assert figure.low <= figure.value <= figure.high


def test_intervals_are_those_of_resampled_records(result):
    score = result.scores["ekf-coloured"]
    pairs = list(zip(score.ranges_m, result.tested, strict=True))
    errors = [np.abs(range_m - record.distance_m) for range_m, record in pairs]
    rng, drawn = np.random.default_rng(1), []
    for _ in range(2000):
        chosen = np.concatenate([errors[k] for k in rng.integers(len(errors), size=len(errors))])
        drawn.append((np.quantile(chosen, 0.8), np.sqrt(np.mean(chosen**2))))
    low, high = np.quantile(drawn, [0.025, 0.975], axis=0)
    for figure, one_low, one_high in zip((score.p80_m, score.rmse_m), low, high, strict=True):
        margin = 0.15 * (one_high - one_low)
        assert figure.low == pytest.approx(one_low, abs=margin)
        assert figure.high == pytest.approx(one_high, abs=margin)


def test_few_records_have_no_interval(flown):
    found = fit([flown(300)])
    score = compare(found, [flown(300, seed) for seed in range(1, 5)], CONSTANT, tune(found, CONSTANT))["constant"]
    assert score.p80_m.value > 0.0 and score.p80_m.low is None and score.p80_m.high is None


def test_the_constant_guess_is_the_median_of_the_link(result):
    for record, range_m in zip(result.tested, result.scores["constant"].ranges_m, strict=True):
        assert (range_m == np.median(result.fit.links[record.link].distance_m)).all()


def test_filters_beat_single_samples_and_the_constant(result):
    p80_m = {name: score.p80_m.value for name, score in result.scores.items()}
    for name in ("ekf-white", "ekf-coloured", "ekf-log"):
        assert p80_m[name] < 0.8 * min(p80_m["ls"], p80_m["constant"])


def test_process_noise_is_the_best_of_the_grid(result):
    for name, method in result.methods.items():
        if method.tuned is None:
            continue
        tuning = result.tunings[name]
        criteria = []
        for noise in GRID:
            tried = tuning.replace(**{method.tuned: float(noise)})
            error = [ranges(method, record, result.fit, tried) - record.distance_m for record in result.fit.records]
            criteria.append(np.quantile(np.abs(np.concatenate(error)), SHARE))
        assert getattr(tuning, method.tuned) == GRID[np.argmin(criteria)]
        assert GRID[0] < getattr(tuning, method.tuned) < GRID[-1]


def test_a_tuning_that_ends_at_its_grid_is_noted(flown):
    rated = [flown(500, seed, rated=True) for seed in range(2)]
    result = calibrate(rated[:1], rated[1:])
    noise = result.tunings["ekf-coloured-rate"].process_noise_rate_m2_ps
    assert noise == GRID[0]  # the velocities are exact
    (note,) = (note for note in result.notes if "grid" in note)
    assert "coloured EKF, with range rate" in note
    assert "the least of its grid, 1e-08 a second: less may be better" in note
    assert "white EKF, R + S;" not in note


def test_no_range_is_beyond_ten_times_the_longest_distance(flown, truth):
    fitted, faded = flown(500, 1), flown(500, 2)
    faded = dataclasses.replace(faded, rss_dbm=np.where(np.arange(500) % 100 < 30, -180.0, faded.rss_dbm))
    result = calibrate([fitted], [faded])
    for score in result.scores.values():
        assert score.ranges_m[0].max() <= 10.0 * fitted.distance_m.max() + 1e-9


def test_range_rate_needs_velocities_everywhere(flown):
    rated, bare = flown(300, 1, rated=True), flown(300, 2)
    assert list(available([rated, rated])) == list(methods())
    assert [name for name in available([rated, bare]) if name.endswith("-rate")] == []


def test_velocities_in_some_records_are_noted(flown):
    result = calibrate([flown(300, 1, rated=True)], [flown(300, 2)])
    assert result.notes == ("range rates are not used: not every record has velocities",)
    assert "ekf-coloured-rate" not in result.scores


def test_range_rate_helps(flown):
    result = calibrate([flown(700, seed, rated=True) for seed in range(3)], [flown(700, 7, rated=True)])
    p80_m = {name: score.p80_m.value for name, score in result.scores.items()}
    for name in ("ekf-white", "ekf-coloured"):
        assert p80_m[f"{name}-rate"] < 0.7 * p80_m[name]


def test_without_a_test_the_last_third_is_held_out(flown):
    record = flown(300, rated=True)
    result = calibrate([record])
    (fitted,), (tested,) = result.fit.records, result.tested
    assert not result.own_logs and (len(fitted.time_s), len(tested.time_s)) == (200, 100)
    for name in ("time_s", "rss_dbm", "distance_m", "range_rate_mps"):
        parts = [getattr(fitted, name), getattr(tested, name)]
        np.testing.assert_array_equal(np.concatenate(parts), getattr(record, name))


def test_links_that_cannot_be_fitted_and_new_links_are_noted(flown):
    odd = flown(400, 3, link="odd")
    odd = dataclasses.replace(odd, rss_dbm=-110.0 - odd.rss_dbm)
    fitted, new = flown(400), flown(400, 4, link="new")
    result = calibrate([fitted, odd], [new, odd])
    assert [record.link for record in result.tested] == ["new"]
    left_out, untold = result.notes
    assert "'odd' is left out, with 400 samples of the test" in left_out and "'new' was not fitted" in untold
    with pytest.raises(ParamsError, match="no link that can be used"):
        calibrate([fitted, odd], [odd])
