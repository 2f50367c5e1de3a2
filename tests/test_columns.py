"""`observation.write` against the table: every column by name, with formulas of NumPy's own."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from rss_gym.core import Batch
from rss_gym.observation import fields, split, transform, transforms, write
from rss_gym.params import Params
from rss_gym.sensed import OTHER, OWN
from rss_gym.tracking import TRACK
from rss_gym.tracking.approach import STILL, TIME_MAX_S, closest

RADIO = ("range_m", "range_std_m", "range_rate_mps", "coloured_db", "path_loss_factor", "white_std_db")
RADIO += ("coloured_std_db", "coloured_tc_s", "consecutive_warnings")


def axes_of(along):
    """Along, right and up of a leg."""
    return np.array([along, [along[1], -along[0], 0.0], [0.0, 0.0, 1.0]])


def approach(way, r, v):
    """Time, miss vector and distance of the closest approach of straight relative flight within 60 s."""
    t = np.clip(-(r @ v) / (v @ v), 0.0, TIME_MAX_S) if v @ v > STILL else 0.0
    miss = r + v * t
    return {f"{way}_time_s": t, f"{way}_distance_m": np.linalg.norm(miss)}, {f"{way}_miss_{{}}_m": miss}


def of_track(own, track):
    """Scalars and vectors of a track that is valid."""
    p, v = track["position_m"], track["velocity_mps"]
    bearing = p[:2] / np.linalg.norm(p[:2])
    covariance = np.array([[track["xx"], track["xy"]], [track["xy"], track["yy"]]])
    across = np.array([-bearing[1], bearing[0]])
    scalars = {
        "track_valid": 1.0,
        "track_std_along_m": np.sqrt(bearing @ covariance @ bearing),
        "track_std_across_m": np.sqrt(across @ covariance @ across),
        "track_std_up_m": np.sqrt(track["zz"]),
        "side_probability": track["side_probability"],
    }
    vectors = {"track_position_{}_m": p, "track_velocity_{}_mps": v, "other_position_{}_m": [*track["other_m"], 0.0]}
    own_position = own["planned_m"] - own["way_point_m"]  # of the agent on its path, seen from its way point
    flown = approach("flown", p, v)
    planned = approach("planned", p - own_position, v + own["velocity_mps"] - own["planned_mps"])
    return scalars | flown[0] | planned[0], vectors | flown[1] | planned[1]


def expected(own, others, tracks, table):
    """Value in SI units of every field of the table, by name."""
    axes = axes_of(own["along"])
    values = {"cruise_mps": own["planned_mps"] @ own["along"], "solution_std_m": own["std_m"]}
    vectors = {
        "way_point_{}_m": own["way_point_m"] - own["planned_m"],
        "offset_{}_m": own["position_m"] - own["planned_m"],
        "velocity_{}_mps": own["velocity_mps"],
        "ahead_{}_m": own["ahead_m"],
    }
    for k, (other, track) in enumerate(zip(others, tracks, strict=True)):
        prefix = f"intruder_{k}."
        if not other["present"]:
            continue
        scalars = {name: other[name] for name in RADIO} | {
            "present": 1.0,
            "zone_radius_m": other["radius_m"],
            "margin_m": other["range_m"] - other["radius_m"],
            "warning": float(other["warning"]),
        }
        values |= {prefix + name: value for name, value in scalars.items()}
        if other["valid"]:
            values |= {prefix + "message_valid": 1.0, prefix + "message_age_s": other["age_s"]}
            values[prefix + "message_std_m"] = other["std_m"]
            vectors[prefix + "message_velocity_{}_mps"] = other["velocity_mps"]
            vectors[prefix + "message_position_{}_m"] = other["position_m"] - own["position_m"]
            vectors[prefix + "message_way_point_{}_m"] = other["way_point_m"] - own["position_m"]
        if track["valid"]:
            scalars, more = of_track(own, track)
            values |= {prefix + name: value for name, value in scalars.items()}
            vectors |= {prefix + name: vector for name, vector in more.items()}
    for name, vector in vectors.items():
        for axis, component in zip(("along", "right", "up"), axes @ vector, strict=True):
            values[name.format(axis)] = component
    return {f.name: values.get(f.name, 0.0) for f in table}


def sensed(generator, k, planar, wild):
    """Records filled with random numbers, far outside the limits if `wild`."""
    own, others, tracks = np.zeros(1, OWN), np.zeros(k, OTHER), np.zeros(k, TRACK)
    scale = 10.0 ** generator.uniform(-3, 5) if wild else 30.0
    for records in (own, others, tracks):
        for name in records.dtype.names:
            part = records[name]
            random = (
                generator.random(part.shape) < 0.7 if part.dtype == bool else scale * generator.normal(size=part.shape)
            )
            if planar and part.shape[1:] == (3,):
                random[:, 2] = 0.0
            records[name] = random
    heading = generator.uniform(-np.pi, np.pi)
    own["along"] = np.cos(heading), np.sin(heading), 0.0
    for track in tracks:
        half = scale * generator.normal(size=(2, 2))
        (track["xx"], track["xy"]), (_, track["yy"]) = half @ half.T
        track["zz"], track["side_probability"] = abs(track["zz"]), generator.random()
    others["consecutive_warnings"] = generator.uniform(0.0, 1.0, k)
    return own, others, tracks


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("information", ["oracle", "positions", "ranges"])
@pytest.mark.parametrize("k", [1, pytest.param(3, marks=pytest.mark.slow), 8])
@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), wild=st.booleans())
def test_every_column_is_its_field(planar, information, k, seed, wild):
    own, others, tracks = sensed(np.random.default_rng(seed), k, planar, wild)
    table = fields(Params.of(planar=planar, information=information, intruders=k))
    raw, columns = np.full(len(table), np.nan), np.full(len(table), np.nan, np.float32)
    write(own[0], others, tracks, planar, information != "ranges", raw)
    transform(raw, transforms(table), columns)
    values = expected(own[0], others, tracks, table)
    sizes = [np.abs(r[name]).max() for r in (own, others, tracks) for name in r.dtype.names if r[name].dtype != bool]
    tiny = 1e-9 * (1.0 + max(sizes)) * (1.0 + TIME_MAX_S)
    for f, value, column in zip(table, raw, columns, strict=True):
        assert value == pytest.approx(values[f.name], rel=1e-6, abs=tiny), f.name
        wanted = value / (abs(value) + f.stretch) if f.stretch else value / f.scale
        assert column == pytest.approx(np.clip(wanted, f.low, f.high), rel=1e-6, abs=1e-30), f.name
        assert np.float32(f.low) <= column <= np.float32(f.high)


def test_write_does_not_change_what_was_sensed():
    records = sensed(np.random.default_rng(0), 2, False, False)
    before = [part.tobytes() for part in records]
    write(records[0][0], *records[1:], False, True, np.zeros(len(fields(Params.of(planar=False, intruders=2)))))
    assert [part.tobytes() for part in records] == before


@given(seed=st.integers(0, 2**32 - 1))
def test_closest_approach_is_the_minimum(seed):
    """Against SciPy's search."""
    generator = np.random.default_rng(seed)
    r, v = generator.normal(0.0, 100.0, 3), generator.normal(0.0, 4.0, 3)
    t, *miss = closest(*r, *v)
    found = minimize_scalar(lambda s: np.sum((r + v * s) ** 2), bounds=(0.0, TIME_MAX_S), method="bounded")
    assert 0.0 <= t <= TIME_MAX_S
    np.testing.assert_allclose(miss, r + v * t, rtol=1e-12, atol=1e-9)
    assert np.linalg.norm(miss) <= np.sqrt(found.fun) + 1e-6


@pytest.mark.parametrize("planar", [True, False])
def test_oracle_is_the_truth(planar):
    """Every field of a flight is the true state, and the track is the truth with standard deviation 0."""
    batch = Batch(Params.of(information="oracle", planar=planar, intruders=2, families="turning"), 16)
    batch.seed(np.arange(16, dtype=np.uint64))
    batch.reset(np.ones(16, bool))
    generator = np.random.default_rng(0)
    for _ in range(80):
        batch.step(generator.uniform(-1, 1, (16, 3)), ~(batch.episode["terminated"] | batch.episode["truncated"]))
        out = split(batch.observations, batch.params)
        agent, intruders = batch.state.aircraft[:, :1], batch.state.aircraft[:, 1:]
        ground = batch.state.aircraft["velocity_mps"] + batch.state.aircraft["gust_mps"]
        r, v = intruders["position_m"] - agent["position_m"], ground[:, 1:] - ground[:, :1]
        for i in range(16):
            axes = axes_of(batch.seen.own["along"][i])
            for k in range(2):
                for name, vector in (("message_position_{}_m", r[i, k]), ("track_position_{}_m", r[i, k])):
                    for n, axis in enumerate(("along", "right", "up")[: 2 if planar else 3]):
                        limit_m = 3.0 * 120.0
                        assert out[name.format(axis)][i, k] == pytest.approx(
                            np.clip((axes @ vector)[n], -limit_m, limit_m), abs=1e-4
                        )
                for n, axis in enumerate(("along", "right", "up")[: 2 if planar else 3]):
                    assert out[f"track_velocity_{axis}_mps"][i, k] == pytest.approx((axes @ v[i, k])[n], abs=1e-5)
                    assert out[f"message_velocity_{axis}_mps"][i, k] == pytest.approx(
                        (axes @ ground[i, 1 + k])[n], abs=1e-5
                    )
                assert out["range_m"][i, k] == pytest.approx(min(np.linalg.norm(r[i, k]), 360.0), abs=1e-3)
                closing = r[i, k] @ v[i, k] / np.linalg.norm(r[i, k])
                assert out["range_rate_mps"][i, k] == pytest.approx(closing, abs=1e-4)
        for name in ("solution_std_m", "range_std_m", "message_std_m", "track_std_along_m", "track_std_across_m"):
            assert (out[name] == 0.0).all()
        assert (out["message_valid"] == 1.0).all() and (out["track_valid"] == 1.0).all()
        assert (out["message_age_s"] == 0.0).all()


@pytest.mark.parametrize("information", ["oracle", "positions", "ranges"])
def test_ahead_is_the_own_plan(information):
    """Where the predefined trajectory is `announce_s` later, around its turn, minus where it is now; nothing beyond."""
    batch = Batch(Params.of(information=information, families="turning", announce_s=4.0), 64)
    batch.seed(np.arange(64, dtype=np.uint64))
    batch.reset(np.ones(64, bool))
    places, turns = [], []
    ended = np.zeros(64, bool)
    for _ in range(80):
        places.append(batch.seen.own["planned_m"].copy())
        turns.append((batch.seen.own["ahead_m"].copy(), batch.seen.own["along"].copy()))
        batch.step(np.zeros((64, 3)), ~ended)
        ended |= batch.episode["terminated"] | batch.episode["truncated"]
        if ended.any():
            break
    assert len(places) > 40
    bent = 0
    for n in range(len(places) - 8):  # 4 s are eight decisions
        ahead, along = turns[n]
        np.testing.assert_allclose(ahead, places[n + 8] - places[n], atol=1e-8)
        bent += int((np.abs(ahead[:, 0] * along[:, 1] - ahead[:, 1] * along[:, 0]) > 0.5).sum())
    assert bent > 50
