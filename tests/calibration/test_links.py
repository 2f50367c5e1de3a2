"""Logs of one link whose offsets differ by more than the noise are links of their own."""

import dataclasses

import numpy as np
import pytest

from rss_gym.calibration.links import separate
from rss_gym.eval.studies.calibration.calibrate import calibrate


@pytest.fixture
def logs(flown, truth):
    """Two logs in May, two in June with a radio that was mounted anew: 22 dB less."""
    records = []
    for k in range(4):
        channel = truth.replace(offset_dbm=truth.offset_dbm - 22.0 * (k >= 2))
        records.append(
            dataclasses.replace(
                flown(400, k, source=f"{k}.csv", channel=channel), start_s=1.7e9 + 3e6 * (k >= 2) + 900 * k
            )
        )
    return records


def test_offsets_that_differ_are_links_of_their_own(logs):
    fitted, _, notes = separate(logs, [])
    assert [record.link for record in fitted] == ["a (0.csv and 1 more)"] * 2 + ["a (2.csv and 1 more)"] * 2
    assert len(notes) == 1 and "offsets of its logs differ by up to 2" in notes[0]


def test_offsets_within_the_noise_are_one_link(flown):
    records = [flown(400, k, source=f"{k}.csv") for k in range(5)]
    fitted, tested, notes = separate(records, records)
    assert {record.link for record in (*fitted, *tested)} == {"a"} and notes == []


def test_a_tested_log_belongs_to_the_link_nearest_in_time(logs, flown, truth):
    test = dataclasses.replace(
        flown(400, 9, source="9.csv", channel=truth.replace(offset_dbm=truth.offset_dbm - 22.0)), start_s=1.7e9 + 3.1e6
    )
    _, (tested,), notes = separate(logs, [test])
    assert tested.link == "a (2.csv and 1 more)" and "nearest in time" in notes[-1]
    result = calibrate(logs, [test])
    assert result.scores["ekf-coloured"].p80_m.value < 0.7 * result.scores["constant"].p80_m.value


def test_without_a_clock_the_offset_decides(logs, flown, truth):
    undated = [dataclasses.replace(record, start_s=np.nan) for record in logs]
    _, (tested,), notes = separate(undated, [flown(400, 9, source="9.csv")])
    assert tested.link == "a (0.csv and 1 more)" and "whose offset is nearest to its own" in notes[-1]


def test_the_last_third_stays_with_its_log(logs):
    result = calibrate(logs)
    assert {record.link for record in result.tested} == {record.link for record in result.fit.records}
    assert len(result.fit.links) == 2
