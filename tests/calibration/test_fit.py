"""The channel found in logs of a known one."""

import dataclasses

import numpy as np
import pytest

from rss_gym.calibration.fit import LIMITS, fit
from rss_gym.params import ParamsError, load_channel

LONG = 12_000


@pytest.mark.parametrize("seed", range(4))
def test_a_known_channel_is_recovered_within_four_standard_errors(flown, truth, seed):
    found = fit([flown(LONG, seed)])
    path_loss, noise = found.links["a"].path_loss, found.noise
    for value, std, true in [
        (path_loss.path_loss_factor, path_loss.path_loss_factor_std, truth.path_loss_factor),
        (path_loss.offset_dbm, path_loss.offset_std_dbm, truth.offset_dbm),
        (found.channel.white_variance_db2, noise.white_variance_std_db2, truth.white_variance_db2),
        (noise.coloured_variance_db2, noise.coloured_variance_std_db2, truth.coloured_variance_db2),
        (noise.coloured_tc_s, noise.coloured_tc_std_s, truth.coloured_tc_s),
    ]:
        assert abs(value - true) < 4.0 * std
        assert std < 0.2 * abs(true)
    assert found.warnings == ()
    assert found.channel.quantisation_db == 1.0


def test_standard_errors_are_the_scatter_of_the_estimates(flown):
    fits = [fit([flown(1500, seed)]) for seed in range(40)]
    estimates = {
        "path_loss_factor": [
            (f.links["a"].path_loss.path_loss_factor, f.links["a"].path_loss.path_loss_factor_std) for f in fits
        ],
        "white": [(f.noise.white_variance_db2, f.noise.white_variance_std_db2) for f in fits],
        "coloured": [(f.noise.coloured_variance_db2, f.noise.coloured_variance_std_db2) for f in fits],
    }
    for pairs in estimates.values():
        values, stds = np.array(pairs).T
        # The standard deviation of 40 values errs by 11 %.
        assert 0.6 < np.median(stds) / values.std(ddof=1) < 1.6


def test_one_link_gives_its_own_path_loss(flown):
    found = fit([flown(600)])
    path_loss = found.links["a"].path_loss
    assert found.channel.path_loss_factor == path_loss.path_loss_factor
    assert found.channel.offset_dbm == pytest.approx(path_loss.offset_dbm, abs=1e-9)
    assert found.channel_of("a").offset_dbm == path_loss.offset_dbm
    assert found.channel_of("another") == found.channel


def test_the_channel_is_the_middle_of_the_links(flown, truth):
    factors = {"a": 2.0, "b": 2.4, "c": 4.0}
    # All have the same RSS at 36 m, near the middle distance, so that the offsets differ by much.
    level_db = 10.0 * np.log10(36.0)
    records = [
        flown(LONG // 4, seed, link, channel=truth.replace(path_loss_factor=g, offset_dbm=-75.0 + g * level_db))
        for seed, (link, g) in enumerate(factors.items())
    ]
    found = fit(records)
    assert found.channel.path_loss_factor == found.links["b"].path_loss.path_loss_factor
    assert found.channel.offset_dbm - found.channel.path_loss_factor * level_db == pytest.approx(-75.0, abs=1.0)
    assert {name: link.rows for name, link in found.links.items()} == dict.fromkeys(factors, LONG // 4)


def test_records_in_another_order_give_the_same_channel(flown):
    records = [flown(700, seed, link, f"{seed}.csv") for seed, link in enumerate("abab")]
    one, other = fit(records).channel.to_dict(), fit(records[::-1]).channel.to_dict()
    assert one == pytest.approx(other, rel=1e-6)


def test_a_link_that_does_not_fade_is_left_out(flown):
    record = flown(600, link="odd")
    rising = dataclasses.replace(record, rss_dbm=-110.0 - record.rss_dbm)
    found = fit([flown(600), rising])
    assert list(found.links) == ["a"] and list(found.excluded) == ["odd"]
    assert "path_loss_factor" in found.excluded["odd"] and "[1, 8]" in found.excluded["odd"]
    with pytest.raises(
        ParamsError, match=r"no link can be calibrated: link 'odd': path_loss_factor .*; in log 'a.csv'"
    ):
        fit([rising])


def test_a_link_at_one_distance_is_left_out(flown):
    still = dataclasses.replace(flown(600, link="still"), distance_m=np.full(600, 20.0))
    assert "must vary" in fit([flown(600), still]).excluded["still"]


def test_an_error_of_the_noise_names_log_and_link(flown):
    record = flown(60, source="may/a.csv")
    pairs = dataclasses.replace(record, time_s=np.repeat(np.arange(30.0), 2) + np.tile([0.0, 0.001], 30))
    with pytest.raises(ParamsError, match=r"log 'may/a.csv', link 'a': the noise cannot be told from the times"):
        fit([pairs])


def test_rounding_is_found_over_all_files_of_a_link(flown, truth):
    step = 1.0 / 1.9
    records = [flown(80, seed, source=f"{seed}.csv", channel=truth.replace(quantisation_db=step)) for seed in range(6)]
    written = [dataclasses.replace(one, rss_dbm=np.round(one.rss_dbm, 2)) for one in records]
    assert fit(written).channel.quantisation_db == pytest.approx(step, abs=2e-3)
    unrounded = flown(2000, 7, link="b", channel=truth.replace(quantisation_db=0.0))
    assert fit([unrounded]).channel.quantisation_db == 0.0


@pytest.mark.parametrize("seed", range(3))
def test_a_short_record_is_told(flown, truth, seed):
    found = fit([flown(300, seed, channel=truth.replace(coloured_tc_s=20.0))])
    assert any("short for a correlation time" in warning for warning in found.warnings)


def test_a_variance_that_the_residuals_do_not_show_is_not_flown(flown, truth):
    found = fit([flown(600, 2, channel=truth.replace(coloured_tc_s=20.0))])
    noise, residual_db = found.noise, found.links["a"].path_loss.residual_db
    assert noise.coloured_variance_db2 > 10.0 * residual_db.var()
    assert found.channel.coloured_variance_db2 == pytest.approx(residual_db.var(), rel=1e-6)
    growth = noise.coloured_variance_db2 / noise.coloured_tc_s
    assert found.channel.coloured_variance_db2 / found.channel.coloured_tc_s == pytest.approx(growth)
    assert any("too short for the coloured variance" in warning for warning in found.warnings)


def test_noise_of_another_kind_is_told(flown):
    record = flown(6000)
    hum = 4.0 * np.sin(2.0 * np.pi * record.time_s / 3.0)
    found = fit([dataclasses.replace(record, rss_dbm=record.rss_dbm + hum)])
    assert any("not that of white plus one Gauss-Markov noise" in warning for warning in found.warnings)


def test_values_outside_the_limits_of_a_channel_are_cut_with_a_warning(flown, truth):
    # Sampled every millisecond, noise of 2 ms is faster than any that a channel may have.
    record = flown(6000, channel=truth.replace(coloured_tc_s=2.0, quantisation_db=0.0))
    found = fit([dataclasses.replace(record, time_s=record.time_s * 1e-3)])
    assert found.noise.coloured_tc_s == pytest.approx(2e-3, rel=0.5)
    assert found.channel.coloured_tc_s == LIMITS["coloured_tc_s"][0]
    assert any("coloured_tc_s" in warning and "[0.01, 3600]" in warning for warning in found.warnings)
    load_channel(found.channel.to_dict())


@pytest.mark.parametrize("step_db", [0.0, 0.5, 1.0 / 1.9, 1.0, 2.0])
def test_the_step_of_the_rss_is_found(flown, truth, step_db):
    record = flown(900, channel=truth.replace(quantisation_db=step_db))
    shifted = dataclasses.replace(record, rss_dbm=record.rss_dbm - 0.3)
    for log in (record, shifted):
        assert fit([log]).channel.quantisation_db == pytest.approx(step_db, abs=1e-4)


def test_gaps_are_told(flown):
    record = flown(900)
    time_s = record.time_s + np.repeat([0.0, 1e3, 2e3], 300)
    found = fit([dataclasses.replace(record, time_s=time_s)])
    assert any("gaps" in warning for warning in found.warnings)
    assert found.noise.curve.period_s == pytest.approx(0.2)
    assert found.noise.curve.lengths == (300, 300, 300)
