"""The table of the observation: what is written is what it says, and `split` goes back."""

import numpy as np
import pytest

from rss_gym.highway.env import RoadEnv
from rss_gym.highway.observation import Writer, fields, split
from rss_gym.highway.params import RoadParams
from rss_gym.sensed import OTHER, OWN

OWN_FIELDS = 9  # the last of them is `solution_std_m`


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
    rng, along = np.random.default_rng(1), (0.6, 0.8)
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
        want = [expected(field, value) for field, value in zip(fields(params), raw, strict=True)]
        assert row == pytest.approx(want, rel=1e-6, abs=1e-6)


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
    assert not any(seen[name].any() for name in seen if name.startswith(("message", "relative")))


def test_names_are_told_apart_and_bounds_are_the_tables(params):
    table = fields(params)
    assert len({field.name for field in table}) == len(table)
    env = RoadEnv(vehicles=2, information=params.interface.information)
    assert env.observation_space.low.tolist() == [np.float32(field.low) for field in table]
    assert env.observation_space.high.tolist() == [np.float32(field.high) for field in table]
