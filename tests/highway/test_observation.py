"""The table of the observation: what is written is what it says, and `split` goes back."""

import numpy as np
import pytest

from rss_gym.highway import lane_fields
from rss_gym.highway.env import RoadEnv
from rss_gym.highway.observation import Writer, fields, split
from rss_gym.highway.params import RoadParams
from rss_gym.sensed import OTHER, OWN

OWN_FIELDS = 10  # the last of them is `solution_std_m`


@pytest.fixture(params=["oracle", "positions", "ranges"])
def params(request):
    """Of every level of information, with two vehicles."""
    return RoadParams.of(vehicles=2, information=request.param)


def sensed(rng, n=2):
    """Random OWN and OTHER of `n` vehicles that are heard, with messages held."""
    own, others = np.zeros(1, OWN), np.zeros(n, OTHER)
    for record in (own, others):
        for name in record.dtype.names:
            values = record[name]
            values[:] = rng.uniform(-20.0, 20.0, values.shape) if values.dtype.kind == "f" else True
    return own, others


def expected(field, value):
    """The column of a value, from the table's own words."""
    if field.stretch > 0.0:
        return value / (abs(value) + field.stretch)
    return min(max(value / field.scale, field.low), field.high)


def test_columns_follow_the_table(params):
    rng, along, level = np.random.default_rng(1), (0.6, 0.8), params.interface.information
    for _ in range(20):
        own, others = sensed(rng)
        known = {f.name: rng.uniform(-100.0, 100.0) for f in fields(params)[: OWN_FIELDS - 1]}
        row = Writer(params, True).write(known, along, own, others)
        raw = [*known.values(), own["std_m"][0]]
        for other in others:
            gap, speed = other["position_m"] - own["position_m"][0], other["velocity_mps"] - own["velocity_mps"][0]
            raw += [1.0, *(other[name] for name in ("range_m", "range_std_m", "range_rate_mps", "coloured_db"))]
            raw += [other[name] for name in ("path_loss_factor", "white_std_db", "coloured_std_db", "coloured_tc_s")]
            raw += [
                other["radius_m"],
                other["range_m"] - other["radius_m"],
                1.0,
                other["consecutive_warnings"],
                1.0,
                other["age_s"],
            ]
            raw += [speed[0] * 0.6 + speed[1] * 0.8, speed[1] * 0.6 - speed[0] * 0.8]
            if params.interface.information != "ranges":
                raw += [gap[0] * 0.6 + gap[1] * 0.8, gap[1] * 0.6 - gap[0] * 0.8, other["std_m"]]
        want = [expected(field, value) for field, value in zip(fields(params), raw, strict=False)]
        assert row[: len(raw)] == pytest.approx(want, rel=1e-6, abs=1e-6)
        rest = fields(params)[len(raw) :]
        assert all(field.name.startswith("on_") for field in rest) and bool(rest) == (level != "ranges")


def test_split_goes_back_to_si(params):
    rng = np.random.default_rng(2)
    own, others = sensed(rng)
    known = {f.name: rng.uniform(0.0, 0.9) for f in fields(params)[: OWN_FIELDS - 1]}
    row = Writer(params, True).write(known, (0.0, 1.0), own, others)
    seen = split(np.stack([row, row]), params)
    assert seen["range_m"].shape == (2, 2) and seen["speed_mps"].shape == (2,)
    for name, value in known.items():
        assert seen[name] == pytest.approx([value] * 2, rel=1e-6)
    if params.interface.information != "ranges":
        gap = others["position_m"] - own["position_m"]
        assert seen["relative_along_m"][0] == pytest.approx(gap[:, 1], rel=1e-5)
        assert seen["relative_right_m"][1] == pytest.approx(-gap[:, 0], rel=1e-4)
    with pytest.raises(ValueError, match="the last axis must be"):
        split(row[1:], params)


def test_nothing_is_told_by_a_message_that_is_not_held(params):
    own, others = sensed(np.random.default_rng(3))
    others["valid"] = False
    known = {f.name: 0.0 for f in fields(params)[: OWN_FIELDS - 1]}
    seen = split(Writer(params, True).write(known, (1.0, 0.0), own, others), params)
    assert not any(seen[name].any() for name in seen if name.startswith(("message", "relative", "on_")))


def test_names_are_told_apart_and_bounds_are_the_tables(params):
    table = fields(params)
    assert len({field.name for field in table}) == len(table)
    env = RoadEnv(vehicles=2, information=params.interface.information)
    assert env.observation_space.low.tolist() == [np.float32(field.low) for field in table]
    assert env.observation_space.high.tolist() == [np.float32(field.high) for field in table]


def test_who_falls_behind_the_plan_sees_it():
    env = RoadEnv()
    assert split(env.reset(seed=0)[0], env.params)["plan_ahead_m"] == 0.0
    slower, *_, info = env.step(4)
    assert split(slower, env.params)["plan_ahead_m"] == pytest.approx(-info["deviation_m"], rel=1e-4)


def on_lanes(*vehicles, lane_offset_m=0.0, held=1.0):
    """The lanes' fields, by name, of vehicles (x, y, vx, vy)."""
    rows = np.array(vehicles).reshape(-1, 4)
    names = ("relative_along_m", "relative_right_m", "relative_along_mps", "relative_right_mps")
    heard = {**dict(zip(names, rows.T, strict=True)), "message_valid": np.full(len(rows), held)}
    return dict(zip((f.name for f in lane_fields.table()), lane_fields.values(heard, lane_offset_m), strict=True))


def test_lanes_hold_who_is_nearest_ahead_and_behind():
    seen = on_lanes((25.0, 0.3, -3.0, 0.0), (45.0, -0.3, -9.0, 0.0), (-15.0, 4.2, 2.0, 0.0))
    assert seen["on_own.ahead_nearness"] == 20.0 / (20.0 + 20.0)  # 5 m of the vehicles themselves
    assert seen["on_own.ahead_closing_mps"] == 3.0  # of the nearer one
    assert seen["on_right.behind_nearness"] == 20.0 / (20.0 + 10.0)
    assert seen["on_right.behind_closing_mps"] == 2.0
    rest = [name for name in seen if not name.startswith(("on_own.ahead", "on_own.perhaps_ahead", "on_right."))]
    assert rest and not any(seen[name] for name in rest)
    assert not any(on_lanes((25.0, 0.3, -3.0, 0.0), held=0.0).values())


def test_between_lanes_a_vehicle_may_be_on_either():
    seen = on_lanes((25.0, 2.6, 0.0, 0.0))
    assert seen["on_right.ahead_nearness"] > 0.0 and seen["on_own.ahead_nearness"] == 0.0
    assert seen["on_own.perhaps_ahead_nearness"] == seen["on_right.perhaps_ahead_nearness"] > 0.0
    assert on_lanes((25.0, 2.6, 0.0, 0.0), lane_offset_m=-2.0)["on_own.ahead_nearness"] > 0.0
    drifting = on_lanes((25.0, 4.0, 0.0, -1.5))
    assert drifting["on_own.ahead_nearness"] == 0.0 and drifting["on_own.perhaps_ahead_nearness"] > 0.0
