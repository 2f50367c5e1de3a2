"""Pictures: `rss_gym.render.draw` and `map_view`."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from gymnasium.error import DependencyNotInstalled

from rss_gym.render import Aircraft, Intruder, Scene, draw, map_view
from rss_gym.render.style import BLUE, ORANGE, RED, RING

pytest.importorskip("PIL", reason="needs the extra `render`")

DURATION_S = 80.0


def path(start_m, velocity_mps, time_s):
    times = np.arange(0.0, time_s + 1e-9, 0.1)
    return np.asarray(start_m, float) + times[:, None] * np.asarray(velocity_mps, float)


def fields(start_m, velocity_mps, time_s, error_m=(0.0, 0.0, 0.0)):
    flown = path(start_m, velocity_mps, time_s)
    return {
        "position_m": flown[-1],
        "estimate_m": flown[-1] + error_m,
        "flown_m": flown,
        "predefined_m": path(start_m, velocity_mps, DURATION_S)[[0, 400, -1]],
        "velocity_mps": np.asarray(velocity_mps, float),
    }


STARTS = [((-110, 25, 5), (2.5, -0.1, -0.1)), ((120, 60, 0), (-1.8, -1.5, 0)), ((40, 150, 0), (-0.8, -3.0, 0))]


def scene(time_s=20.0, count=1, planar=True, **changes):
    own = Aircraft(**fields((0, -90, 0), (0.3, 2.2, 0.1), time_s, (1.0, -1.0, 0.5)))
    intruders = []
    for start_m, velocity_mps in (STARTS * 3)[:count]:
        known = fields(start_m, velocity_mps, time_s, (12.0, 9.0, -3.0))
        true_m = float(np.linalg.norm(known["position_m"] - own.position_m))
        intruders.append(
            Intruder(**known, range_m=1.1 * true_m, range_std_m=0.1 * true_m, zone_radius_m=120.0, warning=true_m < 100)
        )
    whole = Scene(
        own=own,
        planned_m=own.position_m - np.array([6.0, 8.0, 0.0]),
        way_point_m=own.position_m + np.array([10.0, 8.0, 2.0]),
        intruders=tuple(intruders),
        time_s=time_s,
        duration_s=DURATION_S,
        zone_radius_m=120.0,
        collision_radius_m=4.5,
        min_separation_m=99.0,
        planar=planar,
        outcome="",
        playback_speed=5.0,
    )
    return replace(whole, **changes)


def at(picture, view, position_m):
    x, y = np.floor(view.to_px(position_m)).astype(int)
    return tuple(int(value) for value in picture[y, x])


@pytest.mark.parametrize("size_px", [(960, 720), (640, 480), (400, 300), (1280, 720)])
@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("count", [0, 1, 3, 8])
def test_shape_and_type(size_px, planar, count):
    picture = draw(scene(count=count, planar=planar), size_px)
    assert picture.shape == (size_px[1], size_px[0], 3)
    assert picture.dtype == np.uint8
    assert picture.flags.c_contiguous and picture.flags.writeable
    assert len(np.unique(picture @ np.array([65536, 256, 1]))) > 20  # colours


def test_the_same_scene_gives_the_same_picture():
    assert np.array_equal(draw(scene(count=3, planar=False)), draw(scene(count=3, planar=False)))


# At 20 s the warning of the only intruder is open.
def other_intruder(**changes):
    before = scene()
    return replace(before, intruders=(replace(before.intruders[0], **changes),))


@pytest.mark.parametrize(
    "changed",
    [
        scene(21.0),
        scene(count=2),
        scene(planar=False),
        scene(outcome="collision"),
        scene(outcome="complete"),
        scene(min_separation_m=3.0),
        scene(playback_speed=1.0),
        scene(collision_radius_m=20.0),
        scene(way_point_m=np.array([30.0, 0.0, 0.0])),
        scene(planned_m=np.array([30.0, 0.0, 0.0])),
        other_intruder(warning=False),
        other_intruder(zone_radius_m=90.0),
        other_intruder(range_m=60.0),
        other_intruder(range_std_m=30.0),
        other_intruder(estimate_m=None),
        other_intruder(velocity_mps=np.array([0.0, 3.0, 0.0])),
        other_intruder(flown_m=np.zeros((0, 3))),
    ],
)
def test_every_part_of_the_scene_is_drawn(changed):
    assert not np.array_equal(draw(scene()), draw(changed))


@pytest.mark.parametrize("planar", [True, False])
def test_the_view_stays_still_during_an_episode(planar):
    early, late = scene(0.0, 3, planar), scene(DURATION_S, 3, planar)
    assert map_view(early) == map_view(late)
    assert map_view(early) != map_view(scene(0.0, 1, planar))


@pytest.mark.parametrize("size_px", [(960, 720), (400, 300), (1280, 500)])
@pytest.mark.parametrize("planar", [True, False])
def test_the_view_holds_every_path_and_zone(size_px, planar):
    whole = scene(0.0, 3, planar)
    view = map_view(whole, size_px)
    assert view.px_per_m[0] == view.px_per_m[1]
    for aircraft in (whole.own, *whole.intruders):
        margin_m = 0.0 if aircraft is whole.own else whole.zone_radius_m
        for side in (-margin_m, margin_m):
            spots = view.to_px(aircraft.predefined_m + side)
            assert (spots >= 0).all() and (spots <= view.size_px).all()


def test_north_is_up_and_east_is_right():
    view = map_view(scene())
    origin, east, north = view.to_px([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]])
    assert east[0] - origin[0] == pytest.approx(10 * view.px_per_m[0]) and east[1] == origin[1]
    assert origin[1] - north[1] == pytest.approx(10 * view.px_per_m[1]) and north[0] == origin[0]


@pytest.mark.parametrize("time_s", [0.0, 12.3, 40.0])
@pytest.mark.parametrize("planar", [True, False])
def test_aircraft_have_their_colours(time_s, planar):
    whole = scene(time_s, planar=planar)
    picture, view = draw(whole), map_view(whole)
    assert at(picture, view, whole.own.position_m) == BLUE
    expected = RED if whole.intruders[0].warning else ORANGE
    assert at(picture, view, whole.intruders[0].position_m) == expected
    estimate_m = whole.intruders[0].estimate_m
    assert at(picture, view, estimate_m) == expected


def test_the_range_ring_lies_at_the_estimated_range():
    whole = other_intruder(range_m=50.0, range_std_m=5.0)
    picture, view = draw(whole), map_view(whole)
    south_east = np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0)
    x, y = np.floor(view.to_px(whole.own.position_m + 50.0 * south_east)).astype(int)
    patch = picture[y - 1 : y + 2, x - 1 : x + 2].reshape(-1, 3).astype(int)
    assert np.abs(patch - RING).max(axis=1).min() < 12

    band = [at(picture, view, whole.own.position_m + range_m * south_east) for range_m in (46.0, 54.0)]
    ground = [at(picture, view, whole.own.position_m + range_m * south_east) for range_m in (42.0, 58.0)]
    assert band[0] == band[1] and ground[0] == ground[1] and band[0] != ground[0]


def test_among_several_a_range_ring_is_bold_towards_its_intruder():
    whole = scene(count=2)
    first, second = (replace(intruder, zone_radius_m=1.0) for intruder in whole.intruders)
    first = replace(first, range_m=50.0, range_std_m=5.0)
    whole = replace(whole, intruders=(first, second))
    picture, view = draw(whole), map_view(whole)
    direction = first.position_m - whole.own.position_m
    unit = direction / np.linalg.norm(direction)
    ahead, behind = (
        [at(picture, view, whole.own.position_m + side * range_m * unit) for range_m in (42.0, 46.5, 53.5, 58.0)]
        for side in (1, -1)
    )
    assert ahead[1] != ahead[0] and ahead[2] != ahead[3]
    assert len(set(behind)) == 1


def test_the_deviation_is_drawn_and_told():
    own_m = scene().own.position_m
    far, near = scene(planned_m=own_m + np.array([20.0, 0.0, 0.0])), scene(planned_m=own_m)
    view = map_view(far)
    between = own_m + np.array([11.0, 0.0, 0.0])
    x, y = np.floor(view.to_px(between)).astype(int)
    line = draw(far)[y - 2 : y + 3, x].astype(int)
    assert np.abs(line - BLUE).max(axis=1).min() < 90
    assert not np.array_equal(draw(near), draw(far))


def test_a_hovering_aircraft_is_a_disc():
    slow = [other_intruder(velocity_mps=np.array(v)) for v in ([0.1, 0.0, 0.0], [0.0, 0.2, 0.0])]
    fast = [other_intruder(velocity_mps=np.array(v)) for v in ([2.0, 0.0, 0.0], [0.0, 2.0, 0.0])]
    assert np.array_equal(draw(slow[0]), draw(slow[1]))
    assert not np.array_equal(draw(fast[0]), draw(fast[1]))


def test_the_zone_changes_with_the_warning():
    clear, warned = other_intruder(warning=False), other_intruder(warning=True)
    view = map_view(clear)
    inside = clear.intruders[0].position_m + np.array([-40.0, 60.0, 0.0])
    colours = {at(draw(whole), view, inside) for whole in (clear, warned)}
    assert len(colours) == 2
    assert at(draw(clear), view, clear.intruders[0].position_m + np.array([0.0, 130.0, 0.0])) not in colours


NAN3 = np.full(3, np.nan)


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize(
    "changes",
    [
        {"estimate_m": None},
        {"estimate_m": NAN3},
        {"estimate_m": np.full(3, 1e12)},
        {"flown_m": np.zeros((0, 3))},
        {"flown_m": np.zeros((1, 3))},
        {"flown_m": np.zeros((50, 3))},
        {"predefined_m": np.zeros((0, 3))},
        {"predefined_m": np.zeros((1, 3))},
        {"velocity_mps": np.zeros(3)},
        {"position_m": np.array([1e5, -1e5, 300.0])},
        {"position_m": NAN3},
        {"range_m": float("nan"), "range_std_m": float("nan")},
        {"range_m": 0.3, "range_std_m": 0.0},
        {"range_m": 100.0, "range_std_m": 1e6},
        {"range_m": 100.0, "range_std_m": float("inf")},
        {"range_m": 100.0, "range_std_m": float("nan")},
        {"range_m": 1e9, "range_std_m": 1.0},
        {"range_m": float("inf"), "range_std_m": 1.0},
        {"zone_radius_m": 0.0},
        {"zone_radius_m": 1e9},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_odd_numbers_are_drawn(changes, planar):
    before = scene(planar=planar)
    of_intruder = replace(before, intruders=(replace(before.intruders[0], **changes),))
    assert draw(of_intruder).shape == (720, 960, 3)
    if not {"range_m", "zone_radius_m", "position_m"} & set(changes):
        assert draw(replace(before, own=replace(before.own, **changes))).shape == (720, 960, 3)


@pytest.mark.parametrize(
    "changes",
    [
        {"min_separation_m": float("inf")},
        {"way_point_m": NAN3},
        {"way_point_m": np.full(3, 1e12)},
        {"planned_m": NAN3},
        {"planned_m": np.full(3, 1e12)},
        {"zone_radius_m": 0.0},
        {"duration_s": 0.0, "time_s": 0.0},
        {"time_s": 200.0},
    ],
)
def test_odd_scenes_are_drawn(changes):
    assert draw(scene(planar=False, **changes)).shape == (720, 960, 3)


def test_integer_and_single_precision_arrays_are_taken():
    before = scene()
    own = replace(before.own, position_m=np.array([0, -40, 0]), flown_m=before.own.flown_m.astype(np.float32))
    assert draw(replace(before, own=own)).shape == (720, 960, 3)


def test_a_size_too_small_is_refused():
    with pytest.raises(ValueError, match="size_px"):
        draw(scene(), (100, 100))


def test_drawing_imports_no_window_and_importing_no_pillow():
    code = """
import sys
import numpy as np
from rss_gym.render import Aircraft, Scene, draw
assert not any(name.split(".")[0] == "PIL" for name in sys.modules)
zero = np.zeros(3)
own = Aircraft(zero, None, np.zeros((0, 3)), np.zeros((2, 3)), zero)
draw(Scene(own, zero, zero, (), 0.0, 1.0, 120.0, 4.5, 9.0, False, "", 1.0))
import rss_gym.render.window
assert "pygame" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_missing_pillow_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "PIL.Image", None)
    with pytest.raises(DependencyNotInstalled, match=r"Pillow: pip install -e '\.\[render\]'"):
        draw(scene())
