"""The scripted drivers on observations written by hand."""

import numpy as np
import pytest

from rss_gym import baselines
from rss_gym.highway.params import RoadParams
from rss_gym.params import ParamsError

WORLD = RoadParams.of()
CROSSING = RoadParams.of(scene="intersection", zone={"speed_relative_max_mps": 10.0})
OWN = {
    "speed_mps": 25.0, "speed_error_mps": 0.0, "commanded_error_mps": 0.0, "plan_error_m": 0.0, "lane_offset_m": 0.0,
    "lanes_left": 1.0, "lanes_right": 1.0, "changing": 0.0,
}  # fmt: skip


def act(*vehicles, world=WORLD, silent=(), **own):
    """What the rule does about vehicles (x, y, vx, vy), messages held, and `silent` ranges, warned without one."""
    rows = np.array([*vehicles, *((0.0,) * 4 for _ in silent)]).reshape(-1, 4)
    held = np.array([1.0] * len(vehicles) + [0.0] * len(silent))
    seen = {name: np.float64(value) for name, value in {**OWN, **own}.items()}
    names = ("relative_along_m", "relative_right_m", "relative_along_mps", "relative_right_mps")
    seen |= dict(zip(names, rows.T, strict=True))
    range_m = np.array([*(np.hypot(x, y) for x, y, _, _ in vehicles), *silent])
    seen |= {"message_valid": held, "warning": np.ones(len(held)), "range_m": range_m, "range_rate_mps": 0.0 * held}
    return baselines.make("rule", world).choose(seen)


AHEAD = (20.0, 0.0, -3.0, 0.0)  # in a zone of (4 / 0.8 + 3 * 1) * 3 = 24 m


def test_idle_without_a_threat():
    assert act() == "IDLE"
    assert act((25.0, 0.0, -3.0, 0.0)) == "IDLE"  # beyond the pair's zone
    assert act((10.0, 4.0, 0.0, 0.0)) == "IDLE"  # on another lane
    assert act((-10.0, 0.0, 0.0, 0.0)) == "IDLE"  # behind


def test_changes_away_from_the_velocity_of_the_other():
    assert act((20.0, 0.0, -3.0, 1.0)) == "LANE_LEFT"  # it moves to the right
    assert act((20.0, 0.0, -3.0, -1.0)) == "LANE_RIGHT"
    assert act(AHEAD) == "LANE_LEFT"
    assert act(AHEAD, plan_error_m=-4.0) == "LANE_RIGHT"  # home


def test_takes_the_other_side_where_the_zone_is_not_free_and_else_brakes():
    beside_left, beside_right = (3.0, -4.0, 0.0, 0.0), (-10.0, 4.0, 2.0, 0.0)
    assert act(AHEAD, beside_left) == "LANE_RIGHT"
    assert act(AHEAD, beside_left, beside_right) == "SLOWER"
    assert act(AHEAD, lanes_left=0.0) == "LANE_RIGHT"
    assert act(AHEAD, lanes_left=0.0, lanes_right=0.0) == "SLOWER"
    assert act(AHEAD, silent=[10.0]) == "SLOWER"  # somebody near, nobody knows where
    assert act(AHEAD, changing=-1.0) == "SLOWER"


def test_who_drifts_in_is_a_threat():
    assert act((12.0, 3.5, 0.0, -2.0)) in ("LANE_LEFT", "SLOWER")


def test_goes_home_and_back_to_speed():
    assert act(plan_error_m=-4.0) == "LANE_RIGHT"
    assert act((5.0, 4.0, 0.0, 0.0), plan_error_m=-4.0) == "IDLE"
    assert act(commanded_error_mps=-5.0) == "FASTER"
    assert act((25.0, 0.0, 0.0, 0.0), commanded_error_mps=-5.0) == "IDLE"  # zone 30 m at the planned speed


def test_brakes_for_who_crosses():
    assert act((15.0, -15.0, -8.0, 8.0), world=CROSSING, lanes_left=0.0, lanes_right=0.0) == "SLOWER"
    assert act((15.0, -15.0, 8.0, -8.0), world=CROSSING, lanes_left=0.0, lanes_right=0.0) == "IDLE"


def test_on_ranges_alone_it_brakes():
    world = RoadParams.of(information="ranges")
    seen = {name: np.float64(value) for name, value in OWN.items()}
    near = {"message_valid": np.ones(1), "warning": np.ones(1), "range_m": np.array([20.0])}
    rule = baselines.make("rule", world)
    assert rule.choose({**seen, **near, "range_rate_mps": np.array([-4.0])}) == "SLOWER"
    assert rule.choose({**seen, **near, "range_rate_mps": np.array([1.0])}) == "IDLE"
    assert rule.choose({**seen, **near, "range_rate_mps": np.array([1.0]), "warning": np.zeros(1)}) == "IDLE"
    slow = {**seen, "commanded_error_mps": np.float64(-5.0), **near, "warning": np.zeros(1)}
    assert rule.choose({**slow, "range_rate_mps": np.zeros(1)}) == "FASTER"


def test_one_observation_and_a_batch():
    from rss_gym.highway.env import RoadEnv

    env = RoadEnv()
    observation, _ = env.reset(seed=0)
    for name in baselines.able(env.params):
        policy = baselines.make(name, env.params)
        single, _ = policy.predict(observation)
        batch, _ = policy.predict(np.stack([observation] * 3))
        assert env.action_space.contains(single) and batch.tolist() == [single] * 3


@pytest.mark.parametrize(
    ("spec", "sentence"),
    [
        ("rul", "policy 'rul' is unknown on a road; did you mean 'rule'"),
        ("rule:lateral=2", "has no option 'lateral'; did you mean 'lateral_m'"),
        ("rule:lateral_m=1,lateral_m=2", "option 'lateral_m' of policy 'rule' is given twice"),
        ("orca", "policy 'orca' is unknown on a road"),
        ("rule:lateral_m=x", "must be a number, got 'x'"),
        ("rule:lateral_m=99", r"lateral_m must be a number in \[0.5, 10\]"),
        ("model.zip", "reading runs code from it"),
        ("none@oracl", "information 'oracl' is unknown; did you mean 'oracle'"),
    ],
)
def test_refused(spec, sentence):
    with pytest.raises(ParamsError, match=sentence):
        baselines.make(spec, WORLD)


def test_a_driver_that_sees_true_states_is_one_of_information_oracle():
    policy = baselines.make("idm", WORLD)
    assert policy.params == RoadParams.of(driver="idm", information="oracle")
    assert baselines.make("rule@oracle", WORLD).params.interface.information == "oracle"


def test_drivers_choose_meta_actions_only():
    continuous = RoadParams.of(config={"action": {"type": "ContinuousAction"}})
    with pytest.raises(ParamsError, match="meta-actions"):
        baselines.make("none", continuous).predict(np.zeros(0))
