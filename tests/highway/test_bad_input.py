"""Wrong names and values, each refused in one sentence."""

import sys

import gymnasium as gym
import pytest

from rss_gym.highway import RssRanging
from rss_gym.highway.env import RoadEnv
from rss_gym.params import ParamsError


@pytest.mark.parametrize(
    ("keywords", "sentence"),
    [
        ({"scene": "higway"}, "scene = 'higway' is unknown; did you mean 'highway'"),
        ({"vehicels": 3}, "no parameter 'vehicels'; did you mean 'vehicles'"),
        ({"vehicles": 9}, r"vehicles must be a whole number in \[1, 8\], got 9"),
        ({"information": "position"}, "information = 'position' is unknown; did you mean 'positions'"),
        ({"estimator": "ekf"}, "estimator = 'ekf' is unknown"),
        ({"driver": "mobil"}, "driver = 'mobil' is unknown"),
        ({"radio": 1}, "radio must be true or false"),
        ({"radio_range_m": 0.0}, "radio_range_m must be a number in"),
        ({"channel": "papre"}, "channel preset 'papre' is unknown; did you mean 'paper'"),
        ({"zone": {"reaction": 1.0}}, "zone has no parameter 'reaction' on a road; did you mean 'reaction_s'"),
        ({"ranging": {"prior_m": 1.0}}, "ranging has no parameter 'prior_m' on a road"),
        ({"navigation": {"gnss": 1.0}}, "navigation has no parameter 'gnss' on a road; did you mean 'gnss_m'"),
        ({"navigation": {"barometer_m": 1.0}}, "navigation has no parameter 'barometer_m' on a road"),
        (
            {"reward": {"colision_price_m": 1.0}},
            "reward has no parameter 'colision_price_m' on a road; did you mean 'collision_price_m'",
        ),
        ({"reward": {"comfort_m": 1.0}}, "reward has no parameter 'comfort_m' on a road"),
        ({"reward": {"snmac_price_m": -1.0}}, "reward: snmac_price_m must be a number in"),
        ({"config": {"vehicle_count": 3}}, "config has no key 'vehicle_count'; did you mean 'vehicles_count'"),
        ({"config": {"action": {"type": "Discrete"}}}, "has an unknown type 'Discrete'; did you mean 'DiscreteAction'"),
        (
            {"config": {"action": {"type": "DiscreteMetaAction", "target_speed": [1]}}},
            r"config\['action'\] has no key 'target_speed'; did you mean 'target_speeds'",
        ),
        ({"config": {"observation": {"type": "Kinematics"}}}, "has no effect here"),
        ({"config": {"controlled_vehicles": 2}}, "observes one controlled vehicle, got 2"),
        ({"config": [1]}, "config must be a dict"),
        ({"zone": 45.0}, "zone must be a dict of parameters, got 45.0"),
        ({"reward": 1}, "reward must be a dict of parameters, got 1"),
        ({"render_mode": "ansi"}, "render_mode must be one of"),
    ],
)
def test_refused(keywords, sentence):
    with pytest.raises(ParamsError, match=sentence):
        RoadEnv(**keywords)


def test_configuration_at_reset_is_checked_too():
    env = RoadEnv()
    with pytest.raises(ParamsError, match="did you mean 'duration'"):
        env.reset(seed=0, options={"config": {"duratoin": 3}})
    env.reset(seed=0, options={"config": {"duration": 1}})
    assert env.step(1)[3]


@pytest.mark.parametrize("key", ["simulation_frequency", "policy_frequency", "controlled_vehicles"])
def test_what_the_sensor_was_made_for_stays_at_reset(key):
    env = RoadEnv()
    with pytest.raises(ParamsError, match=rf"config\['{key}'\] belongs to the environment's making"):
        env.reset(seed=0, options={"config": {key: 2}})


def test_only_highway_env_is_wrapped():
    with pytest.raises(ParamsError, match="RssRanging wraps environments of highway-env, got CartPoleEnv"):
        RssRanging(gym.make("CartPole-v1"))


def test_missing_extra_is_named(monkeypatch):
    for name in [name for name in sys.modules if name.partition(".")[0] == "highway_env"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "highway_env", None)
    with pytest.raises(ParamsError, match=r"pip install -e '\.\[highway\]'"):
        gym.make("rss_gym/Highway-v0")
