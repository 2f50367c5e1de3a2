"""No constant displacement from the predefined trajectory, flown without listening to the radio, may score well."""

import numpy as np
import pytest

from rss_gym.core import SPLITS, Batch
from rss_gym.params import Params

REACH_M = 60.0
PLANAR_RISK_RATIO, SPATIAL_RISK_RATIO = 0.05, 0.01

# What is measured changes nothing for a manoeuvre that does not listen: leave most of it out, and the rest deaf.
DEAF = {"intruder": "gnss", "estimator": "ls", "channel": {"sensitivity_dbm": 0.0}}

HEADINGS = {"ahead": 0, "ahead right": 45, "right": 90, "back right": 135, "back": 180, "back left": 225, "left": 270,
            "ahead left": 315}  # fmt: skip


def make(n, **keywords):
    return Batch(Params.of(reach_m=REACH_M, **keywords), n)


def fly(batch, displacement_m):
    """Episodes 0 of the seeds 0..n-1 of split `validation` at one displacement (along, right, up): which collide."""
    rows = np.ones(batch.n, bool)
    batch.seed(np.arange(batch.n, dtype=np.uint64))
    batch.choose({"split": "validation", "episode": 0}, rows)
    assert np.all(batch.split == SPLITS["validation"])
    batch.reset(rows)
    actions = np.tile(np.asarray(displacement_m, float) / REACH_M, (batch.n, 1))
    done = np.zeros(batch.n, bool)
    while not done.all():
        batch.step(actions, done)
        done |= batch.episode["terminated"] | batch.episode["truncated"]
    return batch.episode["collision"].copy()


def displacement(heading, size_m, up_m=0.0):
    angle = np.radians(HEADINGS[heading])
    return size_m * np.cos(angle), size_m * np.sin(angle), up_m


def sweep(batch, table):
    """Risk ratio of every displacement in `table` (label -> metres), printed; the lowest with its label."""
    none = fly(batch, (0.0, 0.0, 0.0)).sum()
    assert none > 0.3 * batch.n
    print(f"\n{batch.n} encounters, {none} collide under zero action\n{'displacement':>30}  risk ratio")
    ratios = {}
    for label, metres in table.items():
        assert max(np.hypot(metres[0], metres[1]), abs(metres[2])) <= REACH_M + 1e-9
        ratios[label] = fly(batch, metres).sum() / none
        print(f"{label:>30}  {ratios[label]:.4f}")
    best = min(ratios, key=lambda label: ratios[label])
    print(f"best: {best} at {ratios[best]:.4f}")
    return ratios[best], best


@pytest.mark.parametrize("planar", [True, False])
def test_the_radio_changes_nothing_for_who_does_not_listen(planar):
    """The sweeps below leave the radio out: with all of it in, the same episodes collide."""
    metres = (10.0, 15.0, 0.0 if planar else 5.0)
    full, deaf = fly(make(300, planar=planar), metres), fly(make(300, planar=planar, **DEAF), metres)
    assert np.array_equal(full, deaf)
    assert 0 < full.sum() < 300


@pytest.mark.slow
def test_planar():
    batch = make(2000, planar=True, **DEAF)
    table = {
        f"{size_m} m {heading}": displacement(heading, size_m) for heading in HEADINGS for size_m in (5, 12, 20, 40, 60)
    }
    ratio, label = sweep(batch, table)
    assert ratio >= PLANAR_RISK_RATIO, label


@pytest.mark.slow
def test_in_space():
    """Up and down to the edge of the altitude band, alone and with a horizontal displacement."""
    batch = make(5000, planar=False, **DEAF)
    band_m = batch.params.encounter.altitude_band_m
    table = {f"{up_m:+g} m up": (0.0, 0.0, up_m) for up_m in (-band_m, -10.0, -6.0, 6.0, 10.0, band_m)}
    for up_m in (-band_m, band_m):
        for heading in ("right", "back", "left"):
            for size_m in (15, 60):
                table[f"{up_m:+g} m up, {size_m} m {heading}"] = displacement(heading, size_m, up_m)
    table["60 m back"] = displacement("back", 60)
    table["60 m left"] = displacement("left", 60)
    ratio, label = sweep(batch, table)
    assert ratio >= SPATIAL_RISK_RATIO, label
