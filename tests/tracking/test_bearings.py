"""The bank of bearings on made-up flights: does it find the other, is it as sure as it may be, its symmetries."""

import numpy as np
import pytest
import sensed_flights as sensing

from rss_gym.params import Params
from rss_gym.tracking import bank, bearings, model
from rss_gym.tracking.record import BANK


@pytest.fixture(scope="module")
def constants():
    return model(Params.of(agent="dead-reckoning", intruder="dead-reckoning", channel={"path_loss_wander": 0.0}))[0]


@pytest.fixture(scope="module")
def weaving():
    return sensing.flights(np.random.default_rng(3), 40, 80, 6.0, 4.0, turning=True)


def mean_error(tracks, truth):
    return np.linalg.norm(tracks["position_m"][..., :2] - truth, axis=-1)


def test_a_weave_tells_the_sides_apart(constants, weaving):
    truth, own, other = weaving
    tracks = sensing.fly(bearings, "bearings", own, other, constants)
    mirror = np.linalg.norm(tracks["other_m"] - truth, axis=-1)
    right = mean_error(tracks, truth) < mirror
    assert right[0].mean() < 0.75  # by chance
    assert right[50:].mean() > 0.75
    assert np.median(mean_error(tracks, truth)[50:]) < 0.3 * np.median(mean_error(tracks, truth)[:4])


def test_a_side_that_is_sure_is_mostly_right(constants, weaving):
    truth, own, other = weaving
    tracks = sensing.fly(bearings, "bearings", own, other, constants)
    right = mean_error(tracks, truth) < np.linalg.norm(tracks["other_m"] - truth, axis=-1)
    sure = tracks["side_probability"] > 0.95
    assert sure.mean() > 0.2
    assert right[sure].mean() > 0.8


def test_errors_on_the_right_side_are_as_stated(constants, weaving):
    truth, own, other = weaving
    tracks = sensing.fly(bearings, "bearings", own, other, constants)
    right = mean_error(tracks, truth) < np.linalg.norm(tracks["other_m"] - truth, axis=-1)
    along, across, _ = sensing.standardised(tracks, truth)
    assert 0.4 < sensing.rms(along[20:60][right[20:60]]) < 1.6
    assert 0.4 < sensing.rms(across[20:60][right[20:60]]) < 1.6


def test_the_first_message_leaves_both_sides_as_probable(constants):
    memory, track = sensing.empty("bearings")
    bearings.advance(*sensing.records(), memory, track, constants)
    assert track["side_probability"] == pytest.approx(0.5, abs=1e-9)
    # Mirror images of each other in the relative velocity.
    v = track["velocity_mps"][:2] / np.linalg.norm(track["velocity_mps"][:2])
    image = 2.0 * v * (v @ track["position_m"][:2]) - track["position_m"][:2]
    np.testing.assert_allclose(track["other_m"], image, atol=1e-9)


def reflected(records):
    out = records.copy()
    for name in ("position_m", "velocity_mps"):
        out[name][..., 1] = -records[name][..., 1]
    return out


def test_mirror_symmetry(constants, weaving):
    _, own, other = weaving
    own, other = own[:, :8], other[:, :8]
    one = sensing.fly(bearings, "bearings", own, other, constants)
    two = sensing.fly(bearings, "bearings", reflected(own), reflected(other), constants)
    sure = one["side_probability"] > 0.56  # of even sides either may be published
    assert sure.mean() > 0.3
    np.testing.assert_allclose(two["side_probability"][sure], one["side_probability"][sure], atol=1e-6)
    np.testing.assert_allclose(two["position_m"][sure][:, 0], one["position_m"][sure][:, 0], atol=1e-5)
    np.testing.assert_allclose(two["position_m"][sure][:, 1], -one["position_m"][sure][:, 1], atol=1e-5)


def test_only_velocities_and_range_are_read(constants, weaving):
    _, own, other = weaving
    own, other = own[:40, :4].copy(), other[:40, :4].copy()
    one = sensing.fly(bearings, "bearings", own, other, constants)
    own["position_m"] += 1000.0
    other["position_m"] = np.nan
    assert sensing.fly(bearings, "bearings", own, other, constants).tobytes() == one.tobytes()


def test_covariances_of_the_hypotheses_stay_positive(constants, weaving):
    _, own, other = weaving
    memory, track = sensing.empty("bearings")
    for n in range(len(own)):
        bearings.advance(own[n, 0], other[n, 0], memory, track, constants)
        columns = memory[BANK:].reshape(10, bank.HYPOTHESES)
        w, _, _, _, xx, xy, xp, yy, yp, pp = columns
        p = np.stack([np.stack(row, -1) for row in ((xx, xy, xp), (xy, yy, yp), (xp, yp, pp))], -2)
        scale = np.sqrt(np.diagonal(p, axis1=1, axis2=2))
        assert np.linalg.eigvalsh(p / (scale[:, :, None] * scale[:, None, :])).min() > -1e-9
        assert w.max() == 1.0 and w.min() >= bank.LEAST_WEIGHT


def test_an_episode_before_is_forgotten(constants):
    memory, track = sensing.empty("bearings")
    bearings.advance(*sensing.records(range_m=40.0), memory, track, constants)
    bearings.advance(*sensing.records(range_m=38.0), memory, track, constants)
    memory[:] = 0.0
    bearings.advance(*sensing.records(), memory, track, constants)
    fresh, alone = sensing.empty("bearings")
    bearings.advance(*sensing.records(), fresh, alone, constants)
    assert track.tobytes() == alone.tobytes()
