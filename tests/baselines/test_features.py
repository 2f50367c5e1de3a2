"""Features: what they say is true, mirrored worlds give mirrored features, and nothing depends on the batch."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym import observation
from rss_gym.baselines.cbf import Cbf
from rss_gym.baselines.features import FEATURES, LIMIT, append, names
from rss_gym.baselines.features.approach import NEAR_M, TIME_MAX_S, Approach
from rss_gym.baselines.features.masks import MASKS, kept
from rss_gym.baselines.range_only import RangeOnly
from rss_gym.core import Batch
from rss_gym.params import Params, ParamsError

WORLDS = {
    "plane": Params(),
    "space": Params.of(planar=False, intruders=2),
    "range": Params.of(track="range", intruders=2),
    "range-space": Params.of(track="range", planar=False),
}
MIRRORED = ("_right", ".side", "turn_sin")  # what changes its sign with the side


@pytest.fixture(params=sorted(WORLDS))
def world(request):
    """Worlds with all layouts of the observation."""
    return WORLDS[request.param]


def flown(world, rows=6, decisions=80):
    """Observations of every decision of some flights with actions drawn at random."""
    batch, generator = Batch(world, rows), np.random.default_rng(0)
    batch.seed(np.arange(rows, dtype=np.uint64))
    batch.reset(np.ones(rows, bool))
    seen = []
    for _ in range(decisions):
        seen.append(batch.observations.copy())
        batch.step(generator.uniform(-1.0, 1.0, (rows, 3)), np.zeros(rows, bool))
        done = batch.episode["terminated"] | batch.episode["truncated"]
        if done.any():
            batch.reset(done)
    return np.concatenate(seen)


def columns(world, **values):
    """One observation: the fields of intruder 0 and the own ones by name, in SI units, all else zero."""
    table = observation.fields(world)
    row = np.zeros((1, len(table)))
    for name, value in values.items():
        (index,) = (i for i, f in enumerate(table) if f.name in (name, f"intruder_0.{name}"))
        row[0, index] = value / table[index].scale
    return row


def table(world, row):
    width = row.shape[1]
    return dict(zip(names("approach", world), append(Approach(world), row)[0, width:], strict=True))


def test_none_adds_nothing(world):
    rows = flown(world, decisions=1)
    assert names("none", world) == [] and append(FEATURES["none"](world), rows) is rows


def test_columns_stand_behind_the_observation(world):
    rows = flown(world, decisions=5)
    stacked = np.concatenate([np.full_like(rows, 0.5), rows], axis=1)
    for kind in [name for name, features in FEATURES.items() if features.fits(world)]:
        appended, known = append(FEATURES[kind](world), rows), names(kind, world)
        assert appended.dtype == np.float32 and appended.shape[1] == rows.shape[1] + len(known)
        assert len(set(known)) == len(known)
        np.testing.assert_array_equal(appended[:, : rows.shape[1]], rows)
        # Only the newest observation counts.
        np.testing.assert_array_equal(append(FEATURES[kind](world), stacked)[:, rows.shape[1] :], appended)


def test_rows_do_not_depend_on_the_batch_or_its_type(world):
    rows = flown(world)
    appended = append(Approach(world), rows)
    np.testing.assert_array_equal(append(Approach(world), rows.astype(np.float64)).astype(np.float32), appended)
    np.testing.assert_array_equal(append(Approach(world), rows[::-1])[::-1], appended)
    for row in range(0, len(rows), 7):
        np.testing.assert_array_equal(append(Approach(world), rows[row : row + 1])[0], appended[row])


def test_silent_without_a_message(world):
    rows = flown(world)
    features = append(Approach(world), rows)[:, rows.shape[1] :].reshape(len(rows), world.encounter.intruders, -1)
    held = observation.split(rows, world)["message_valid"] > 0.5
    assert held.any() and not held.all()
    assert not features[~held].any() and features[held].any(axis=1).all()


def mirror(rows, known):
    signs = np.array([-1.0 if any(part in name for part in MIRRORED) else 1.0 for name in known], np.float32)
    return rows * signs


def test_a_mirrored_world_gives_mirrored_features(world):
    rows = flown(world)
    fields = [field.name for field in observation.fields(world)]
    expected = mirror(append(Approach(world), rows), fields + names("approach", world))
    np.testing.assert_array_equal(append(Approach(world), mirror(rows, fields)), expected)


@given(data=st.data(), name=st.sampled_from(sorted(WORLDS)))
def test_finite_for_hostile_observations(data, name):
    world = WORLDS[name]
    width = len(observation.fields(world))
    value = st.floats(width=32, allow_nan=False) | st.sampled_from([0.0, 1.0, -1.0, 3.0, np.inf, -np.inf])
    row = np.array([data.draw(st.lists(value, min_size=width, max_size=width))], np.float32)
    features = append(Approach(world), row)[:, width:]
    assert np.isfinite(features).all() and (np.abs(features) <= LIMIT).all()


def test_nan_stays_in_its_row(world):
    rows = flown(world, decisions=20)
    spoilt = rows.copy()
    spoilt[3] = np.nan
    others = np.arange(len(rows)) != 3
    np.testing.assert_array_equal(append(Approach(world), spoilt)[others], append(Approach(world), rows)[others])


coordinate = st.floats(-60.0, 60.0)
speed = st.floats(-8.0, 8.0)


@given(
    own=st.tuples(speed, speed), error=st.tuples(coordinate, coordinate), cruise=st.floats(1.0, 15.0),
    position=st.tuples(coordinate, coordinate), velocity=st.tuples(speed, speed), age=st.floats(0.0, 5.0),
)  # fmt: skip
def test_the_closest_approach_is_the_least_distance_on_a_fine_grid(own, error, cruise, position, velocity, age):
    world = WORLDS["plane"]
    found = table(
        world,
        columns(
            world, message_valid=1.0, message_age_s=age, range_m=50.0, cruise_mps=cruise,
            velocity_along_mps=own[0], velocity_right_mps=own[1],
            track_error_along_m=error[0], track_error_right_m=error[1],
            message_position_along_m=position[0], message_position_right_m=position[1],
            message_velocity_along_mps=velocity[0], message_velocity_right_mps=velocity[1],
        ),
    )  # fmt: skip
    time = np.linspace(0.0, TIME_MAX_S, 6001)[:, None]
    now = np.array(position) + np.array(velocity) * age
    ways = {
        "flown": now + (np.array(velocity) - own) * time,
        "planned": now + np.array(error) + (np.array(velocity) - [cruise, 0.0]) * time,
    }
    for way, path in ways.items():
        distance = np.hypot(*path.T)
        least = found[f"intruder_0.{way}.distance"] * 30.0
        # The grid's step is 10 ms, at most 0.3 m; a velocity below 0.1 m/s flies at most 6 m in the time looked at.
        np.testing.assert_allclose(least, min(distance.min(), 150.0), atol=0.35 if np.ptp(distance) > 7.0 else 7.0)
        along = found[f"intruder_0.{way}.miss_along"]
        assert abs(along) <= found[f"intruder_0.{way}.distance"] + 1e-6
    size = np.hypot(*now)
    assert found["intruder_0.excess"] == pytest.approx(np.clip((50.0 - size) / 30.0, -LIMIT, LIMIT), abs=1e-5)
    least = ways["planned"][0]
    heading = np.array(velocity) - [cruise, 0.0]
    side = (heading[0] * least[1] - heading[1] * least[0]) / max(np.hypot(*heading), 0.1)
    assert found["intruder_0.planned.side"] == pytest.approx(np.clip(side / 30.0, -LIMIT, LIMIT), abs=1e-5)
    assert found["intruder_0.planned.side.soft"] == pytest.approx(side / (abs(side) + NEAR_M), abs=1e-5)


@given(range_m=st.floats(5.0, 300.0), along=speed, right=speed, share=st.floats(-2.0, 2.0))
def test_the_approach_from_ranges_alone(range_m, along, right, share):
    """Straight flight with the closing cosine `share`: Pythagoras."""
    world = WORLDS["range-space"]
    size = np.hypot(along, right)
    row = columns(
        world, message_valid=1.0, range_m=range_m, range_rate_mps=-share * size,
        message_velocity_along_mps=along, message_velocity_right_mps=right,
    )  # fmt: skip
    found = table(world, row)
    cosine = float(np.clip(share * size / max(size, 0.1), -1.0, 1.0))
    assert found["intruder_0.closing"] == pytest.approx(cosine, abs=1e-6)
    miss = range_m * np.sqrt(1.0 - cosine**2)
    assert found["intruder_0.distance"] == pytest.approx(min(miss / 30.0, LIMIT), abs=1e-3)
    time = np.clip(range_m * cosine / max(size, 0.1), 0.0, TIME_MAX_S)
    assert found["intruder_0.time"] == pytest.approx(time / 20.0, abs=1e-5)


def test_sides_are_the_approaches_of_the_filter():
    """The more probable side is where a rule on track `range` believes the other to be; memory makes them so."""
    world = Params.of(track="range")
    rows, batch = 4, Batch(world, 4)
    batch.seed(np.arange(rows, dtype=np.uint64))
    batch.reset(np.ones(rows, bool))
    features = FEATURES["sides"](world)
    bank = RangeOnly(world=world, rule=Cbf(world=world))
    memory, other = np.zeros((rows, features.columns)), np.zeros((rows, bank.columns))
    told = names("sides", world)
    for _ in range(70):
        found = append(features, batch.observations, memory)[:, batch.observations.shape[1] :]
        sides = bank.sides(observation.split(batch.observations, world), other)
        for index, name in enumerate(("left", "right")):
            at = {key: told.index(f"intruder_0.{name}.{key}") for key in ("probability", "position_right")}
            np.testing.assert_allclose(found[:, at["probability"]], sides[:, 0, index, 0], rtol=1e-6)
            expected = np.clip(sides[:, 0, index, 2] / 60.0, -LIMIT, LIMIT)
            np.testing.assert_allclose(found[:, at["position_right"]], expected, rtol=1e-6)
        batch.step(np.zeros((rows, 3)), np.zeros(rows, bool))
    assert found[:, told.index("intruder_0.left.probability")].all()


@pytest.mark.parametrize("zeroed", sorted(MASKS))
def test_masks_take_away_what_they_name(world, zeroed):
    fields = [field.name for field in observation.fields(world)]
    left = {name for name, stays in zip(fields, kept(zeroed, world), strict=True) if stays}
    gone = set(fields) - left
    assert gone == {name for name in fields if MASKS[zeroed](name)}
    assert {"cruise_mps", "time_s"} <= left
    assert bool(gone) == (zeroed != "nothing")
    assert ("intruder_0.message_valid" in gone) == (zeroed == "radio")
    np.testing.assert_array_equal(kept(zeroed, world, 3), np.tile(kept(zeroed, world), 3))


def test_features_that_do_not_fit_are_refused():
    with pytest.raises(ParamsError, match="'sides' cannot be computed in this world: they need track 'range'"):
        names("sides", Params())
