"""The table of the observation's columns, its way back to SI units, and the documents that show it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.core import spaces
from rss_gym.env import EncounterEnv
from rss_gym.observation import bounds, fields, split, transform, transforms
from rss_gym.params import Params

WORLDS = [
    Params.of(planar=planar, information=information, intruders=k)
    for planar in (True, False)
    for information in ("oracle", "positions", "ranges")
    for k in (1, 2, 8)
]


WIDTH = len(fields(Params()))


def name_of(params):
    return (
        f"{'plane' if params.encounter.planar else 'space'}-{params.interface.information}-{params.encounter.intruders}"
    )


@pytest.fixture(params=WORLDS, ids=name_of)
def params(request):
    return request.param


def test_columns(params):
    table = fields(params)
    names = [f.name for f in table]
    assert len(set(names)) == len(names)
    assert any("_up_" in name for name in names) != params.encounter.planar
    ranges = params.interface.information == "ranges"
    assert any("message_position" in name for name in names) != ranges
    assert any("side_probability" in name for name in names) == ranges
    assert not any(name.startswith("time") or ".time" in name for name in names)  # the clock is hidden
    per_intruder = {
        tuple(name.partition(".")[2] for name in names if name.startswith(f"intruder_{k}."))
        for k in range(params.encounter.intruders)
    }
    assert len(per_intruder) == 1
    suffixes = {"m": "_m", "m/s": "_mps", "s": "_s", "dB": "_db"}
    for f in table:
        assert f.scale > 0 and f.low < f.high and np.isfinite([f.low, f.high, f.scale]).all()
        assert f.meaning
        assert f.name.endswith(suffixes[f.unit]) if f.unit != "1" else not f.name.endswith(tuple(suffixes.values()))


def test_space_is_the_table(params):
    low, high = bounds(params)
    space = spaces(params)[0]
    np.testing.assert_array_equal(space.low, low)
    np.testing.assert_array_equal(space.high, high)
    assert space.dtype == np.float32
    assert space.shape == (len(fields(params)),)


def inside(table, generator, shape):
    """SI values of every column that none of the bounds cuts off."""
    values = {}
    for f in table:
        if f.stretch:
            low, high = (0.0 if f.low == 0.0 else -1.0) * 500.0, 500.0
        else:
            low, high = f.low * f.scale, f.high * f.scale
        values[f.name] = generator.uniform(low, high, shape)
    return values


@pytest.mark.parametrize("shape", [(), (5,), (2, 3)])
@given(seed=st.integers(0, 2**32 - 1))
def test_split_undoes_the_transform(shape, seed):
    generator = np.random.default_rng(seed)
    params = WORLDS[seed % len(WORLDS)]
    table, k = fields(params), params.encounter.intruders
    values = inside(table, generator, shape)
    raw = np.stack([values[f.name] for f in table], axis=-1)
    columns = np.zeros(raw.shape, np.float32)
    for index in np.ndindex(shape):
        transform(raw[index], transforms(table), columns[index])
    assert (columns >= bounds(params)[0]).all() and (columns <= bounds(params)[1]).all()
    out = split(columns, params)
    own = [f.name for f in table if "." not in f.name]
    bare = [f.name.partition(".")[2] for f in table if f.name.startswith("intruder_0.")]
    assert list(out) == own + bare
    stretched = {f.name.partition(".")[2] or f.name: f.stretch for f in table if f.stretch}
    for name in own + bare:
        wanted = values[name] if name in own else np.stack([values[f"intruder_{r}.{name}"] for r in range(k)], -1)
        assert out[name].shape == wanted.shape
        # float32 of x / (|x| + a) resolves (|x| + a)^2 / a times its own resolution
        fine = 2.0**-22 * ((np.abs(wanted) + stretched[name]) ** 2 / stretched[name] if name in stretched else 1.0)
        assert (np.abs(out[name] - wanted) <= fine + 2.0**-22 * np.abs(wanted)).all(), name


@given(x=st.floats(-1e30, 1e30))
def test_transform_scales_or_stretches_and_stays_within_the_bounds(x):
    table = fields(Params.of(information="ranges", planar=False))
    columns = np.zeros(len(table), np.float32)
    transform(np.full(len(table), x), transforms(table), columns)
    for f, column in zip(table, columns, strict=True):
        wanted = x / (abs(x) + f.stretch) if f.stretch else x / f.scale
        assert column == pytest.approx(np.clip(wanted, f.low, f.high), rel=1e-6, abs=1e-30)
        assert np.float32(f.low) <= column <= np.float32(f.high)


def test_near_distances_differ():
    """5 m and 15 m are far apart in a stretched column, and 300 m is still told from 400 m."""
    table = [f for f in fields(Params()) if f.name.endswith("planned_distance_m")]
    columns = np.zeros((4, 1), np.float32)
    for n, x in enumerate((5.0, 15.0, 300.0, 400.0)):
        transform(np.array([x]), transforms(table), columns[n])
    assert columns[1] - columns[0] > 0.25
    assert columns[3] - columns[2] > 0.005


def test_split_of_a_flight():
    """In SI units: a range of about 150 m, and a range rate near the slope of the ranges."""
    env = EncounterEnv(channel="clean", families="head-on")
    flight = [env.reset(seed=0)[0]] + [env.step(np.zeros(2))[0] for _ in range(30)]
    out = split(np.array(flight), env.params)
    assert 100 < out["range_m"][0, 0] < 220
    assert out["present"].all()
    slope = (out["range_m"][30, 0] - out["range_m"][10, 0]) / (20 * env.params.clock.decision_s)
    assert out["range_rate_mps"][10:, 0].mean() == pytest.approx(slope, abs=1.0)
    np.testing.assert_allclose(out["zone_radius_m"], env.params.zone.radius_m, rtol=1e-6)
    np.testing.assert_allclose(out["margin_m"], out["range_m"] - out["zone_radius_m"], atol=1e-3)
    # Straight on at cruise speed, `announce_s` ahead.
    np.testing.assert_allclose(out["ahead_along_m"], 5.0 * out["cruise_mps"], rtol=1e-5)
    np.testing.assert_allclose(out["ahead_right_m"], 0.0, atol=1e-5)


@pytest.mark.parametrize("wrong", [0.0, np.zeros(3), np.zeros((4, 60)), np.zeros((WIDTH, 1)), np.zeros(0)])
def test_split_refuses_another_length(wrong):
    with pytest.raises(ValueError, match=rf"observation has shape .* must be {WIDTH}"):
        split(wrong, Params())


def test_documented_table():
    """The table in the docstring of the environment is `fields` in space."""
    lines = [line.strip() for line in EncounterEnv.__doc__.splitlines()]
    start = lines.index("| Num | Field | Unit | Column | Low | High | Meaning |")
    documented = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        documented.append(line)

    def column(f):
        return f"x / (abs(x) + {f.stretch:g})" if f.stretch else f"x / {f.scale:g}" if f.scale != 1.0 else "x"

    table = [
        f"| {number} | `{f.name}` | {f.unit} | {column(f)} | {f.low:g} | {f.high:g} | {f.meaning} |"
        for number, f in enumerate(fields(Params.of(planar=False)))
    ]
    assert documented == table


def test_docstring_is_filled_in():
    assert "{" not in EncounterEnv.__doc__.replace('{"split": "suite",', "")
    assert "{{" not in EncounterEnv.__doc__


def test_absent_intruders_are_zero():
    env = EncounterEnv(intruders=2, intruders_min=1)
    seen = set()
    for seed in range(20):
        observation, _ = env.reset(seed=seed)
        present = int(env.batch.episode[0]["intruders"])
        seen.add(present)
        out = split(observation, env.params)
        np.testing.assert_array_equal(out["present"], [1.0] * present + [0.0] * (2 - present))
        for name in out:
            if out[name].shape:
                assert (out[name][present:] == 0).all()
    assert seen == {1, 2}
