"""The table of the observation's columns, its way back to SI units, and the documents that show it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.core import spaces
from rss_gym.env import EncounterEnv
from rss_gym.observation import bounds, fields, split
from rss_gym.params import Params

WORLDS = [
    Params.of(planar=planar, track=track, intruders=k)
    for planar in (True, False)
    for track in ("oracle", "paper", "range")
    for k in (1, 2, 8)
]


def name_of(params):
    return f"{'planar' if params.encounter.planar else 'space'}-{params.interface.track}-{params.encounter.intruders}"


@pytest.fixture(params=WORLDS, ids=name_of)
def params(request):
    return request.param


def test_columns(params):
    table = fields(params)
    names = [f.name for f in table]
    assert len(set(names)) == len(names)
    assert any("_up_" in name for name in names) != params.encounter.planar
    assert any("message_position" in name for name in names) == (params.interface.track != "range")
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


@pytest.mark.parametrize("shape", [(), (5,), (2, 3)])
@given(seed=st.integers(0, 2**32 - 1))
def test_split_undoes_the_scaling(shape, seed):
    generator = np.random.default_rng(seed)
    params = WORLDS[seed % len(WORLDS)]
    table, k = fields(params), params.encounter.intruders
    values = {f.name: generator.normal(size=shape) for f in table}
    packed = np.stack([values[f.name] / f.scale for f in table], axis=-1)
    out = split(packed, params)
    own = [f.name for f in table if "." not in f.name]
    bare = [f.name.partition(".")[2] for f in table if f.name.startswith("intruder_0.")]
    assert list(out) == own + bare
    for name in own:
        assert out[name].shape == shape
        np.testing.assert_allclose(out[name], values[name], rtol=1e-12)
    for name in bare:
        assert out[name].shape == (*shape, k)
        for row in range(k):
            np.testing.assert_allclose(out[name][..., row], values[f"intruder_{row}.{name}"], rtol=1e-12)


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
    np.testing.assert_allclose(np.diff(out["time_s"]), 0.5, atol=1e-4)


@pytest.mark.parametrize("wrong", [0.0, np.zeros(3), np.zeros((4, 30)), np.zeros((29, 1)), np.zeros(0)])
def test_split_refuses_another_length(wrong):
    with pytest.raises(ValueError, match=r"observation has shape .* must be 29"):
        split(wrong, Params())


def test_documented_table():
    """The table in the docstring of the environment is `fields` in space."""
    lines = [line.strip() for line in EncounterEnv.__doc__.splitlines()]
    start = lines.index("| Num | Field | Unit | Scale | Low | High | Meaning |")
    documented = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        documented.append(line)
    table = [
        f"| {number} | `{f.name}` | {f.unit} | {f.scale:g} | {f.low:g} | {f.high:g} | {f.meaning} |"
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
