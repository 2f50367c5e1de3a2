"""Scenes of a batch: `rss_gym.render.recorder`."""

import copy

import numpy as np
import pytest

from rss_gym.core import Batch
from rss_gym.params import Params
from rss_gym.render.recorder import RENDER_FPS, Recorder, predefined_m
from rss_gym.state import AIRCRAFT

ACTION = np.array([0.1, 0.5, -0.4])


def fly(decisions, rows=1, row=0, seed=3, **keywords):
    """Batch, recorder of one row, and the true positions of that row's aircraft after 0, 1, ... decisions."""
    batch, recorder = Batch(Params.of(**keywords), rows), Recorder()
    batch.seed(np.arange(seed, seed + rows, dtype=np.uint64))
    batch.reset(np.ones(rows, bool))
    recorder.reset(batch, row)
    positions = [batch.state.aircraft[row]["position_m"].copy()]
    for _ in range(decisions):
        batch.step(np.tile(ACTION, (rows, 1)), np.ones(rows, bool))
        recorder.append(batch, row)
        positions.append(batch.state.aircraft[row]["position_m"].copy())
    return batch, recorder, np.array(positions)


@pytest.mark.parametrize("row", [0, 2])
def test_paths_hold_a_sample_a_decision(row):
    batch, recorder, positions = fly(12, rows=3, row=row, intruders=2, planar=False)
    scene = recorder.scene(batch, row)
    assert np.array_equal(scene.own.flown_m, positions[:, 0])
    assert [np.array_equal(aircraft.flown_m, positions[:, 1 + k]) for k, aircraft in enumerate(scene.intruders)] == [
        True
    ] * 2
    assert np.array_equal(scene.own.position_m, positions[-1, 0])
    assert scene.time_s == pytest.approx(6.0)
    assert not scene.planar


def test_a_reset_begins_new_paths():
    batch, recorder, _ = fly(5)
    batch.reset(np.ones(1, bool))
    recorder.reset(batch, 0)
    assert len(recorder.scene(batch, 0).own.flown_m) == 1


def test_a_scene_says_what_the_agent_knows():
    batch, recorder, _ = fly(30, intruders=2)
    scene, own, others = recorder.scene(batch, 0), batch.seen.own[0], batch.seen.others[0]
    assert np.array_equal(scene.own.estimate_m, own["position_m"])
    assert np.array_equal(scene.way_point_m, own["way_point_m"])
    assert np.array_equal(scene.planned_m, own["planned_m"])
    for intruder, other in zip(scene.intruders, others, strict=True):
        assert (intruder.range_m, intruder.range_std_m) == (other["range_m"], other["range_std_m"])
        assert (intruder.zone_radius_m, intruder.warning) == (other["radius_m"], other["warning"])
    assert scene.playback_speed == pytest.approx(RENDER_FPS * 0.5)
    assert scene.zone_radius_m == pytest.approx(120.0)
    assert scene.collision_radius_m == 4.5
    assert scene.min_separation_m == batch.episode[0]["min_separation_m"]
    assert scene.duration_s == pytest.approx(batch.episode[0]["ticks"] * batch.params.clock.tick_s)


@pytest.mark.parametrize("information", ["oracle", "positions", "ranges"])
def test_an_estimate_is_the_track_on_the_own_solution(information):
    batch, recorder, positions = fly(40, information=information)
    intruder, track = recorder.scene(batch, 0).intruders[0], batch.state.tracks[0, 0]
    assert track["valid"]
    assert np.array_equal(intruder.estimate_m, batch.seen.own[0]["position_m"] + track["position_m"])
    assert np.array_equal(intruder.position_m, positions[-1, 1])
    if information == "oracle":
        np.testing.assert_allclose(intruder.estimate_m, intruder.position_m, rtol=1e-12)
    track["valid"] = False
    assert recorder.scene(batch, 0).intruders[0].estimate_m is None


def test_absent_intruders_are_left_out():
    seen = {len(fly(0, seed=seed, intruders=3, intruders_min=1)[1]._flown[0]) - 1 for seed in range(12)}
    assert seen == {1, 2, 3}
    batch, recorder, _ = fly(3, intruders=3, intruders_min=1)
    assert len(recorder.scene(batch, 0).intruders) == batch.episode[0]["intruders"]


def test_a_recorder_only_reads():
    batch, recorder, _ = fly(4)
    before = copy.deepcopy((batch.state, batch.seen))
    scene = recorder.scene(batch, 0)
    for aircraft in (scene.own, *scene.intruders):
        for array in (aircraft.position_m, aircraft.flown_m, aircraft.predefined_m, aircraft.velocity_mps):
            array += 1.0
    scene.way_point_m[:] = scene.planned_m[:] = 0.0
    for old, new in zip((*before[0], *before[1]), (*batch.state, *batch.seen), strict=True):
        assert old.tobytes() == new.tobytes()
    later = recorder.scene(batch, 0)
    assert np.allclose(later.own.flown_m, scene.own.flown_m - 1.0)


@pytest.mark.parametrize(
    ("events", "outcome"),
    [({}, ""), ({"collision": True, "terminated": True}, "collision"), ({"truncated": True}, "complete")],
)
def test_outcome(events, outcome):
    batch, recorder, _ = fly(1)
    for name, value in events.items():
        batch.episode[0][name] = value
    assert recorder.scene(batch, 0).outcome == outcome


@pytest.mark.parametrize(
    ("duration_s", "expected"),
    [
        (30.0, [(0, 0), (20, 0), (20, 10)]),  # as laid
        (42.0, [(0, 0), (20, 0), (20, 22)]),  # drawn out
        (24.0, [(0, 0), (20, 0), (20, 4)]),  # cut on the second leg
        (20.0, [(0, 0), (20, 0)]),  # on a way point
        (5.0, [(0, 0), (5, 0)]),  # on the first leg
    ],
)
def test_predefined_paths_end_with_the_flight(duration_s, expected):
    aircraft = np.zeros((), AIRCRAFT)
    aircraft["path_points"] = 3
    aircraft["path_m"][:3, :2], aircraft["path_s"][:3] = [(0, 0), (20, 0), (20, 10)], (0.0, 20.0, 30.0)
    assert np.allclose(predefined_m(aircraft, duration_s)[:, :2], expected)
