"""Recorded logs of two radios, where they are at hand: RSS_GYM_DATA, or ../shared/data beside the repository."""

import os
from pathlib import Path

import pytest

from rss_gym.calibration.logs import read
from rss_gym.eval.studies.calibration.calibrate import calibrate

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("RSS_GYM_DATA") or ROOT.parent / "shared" / "data")
SETS = {
    "ble_tracks": (["straight_*.csv"], ["rectangular_*.csv", "zigzagging_*.csv"], 12),
    "wifi_walk": (["Library_213.csv", "Library_413.csv"], ["Library_513.csv", "Library_613.csv"], 6),
}


@pytest.mark.parametrize("name", SETS)
def test_the_coloured_filter_on_recorded_logs(name):
    folder = DATA / name
    if not folder.is_dir():
        pytest.skip(f"no recorded logs at {folder}; set RSS_GYM_DATA to the folder that holds {name}")
    fitted, tested, links = SETS[name]
    parts = [[path for pattern in patterns for path in sorted(folder.glob(pattern))] for patterns in (fitted, tested)]
    result = calibrate(*(read(paths) for paths in parts))
    assert len(result.fit.links) == links and result.fit.excluded == {}
    assert result.fit.channel.quantisation_db == 1.0
    p80_m = {name: score.p80_m.value for name, score in result.scores.items()}
    assert p80_m["ekf-coloured"] <= 0.9 * p80_m["constant"]
    assert p80_m["ekf-coloured"] <= 0.55 * p80_m["ls"]
