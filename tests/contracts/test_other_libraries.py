"""What other libraries ask of an environment beyond the contract: limits, attributes, lists of frames, keywords."""

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence

from rss_gym import encounters
from rss_gym.core import longest_episode
from rss_gym.env import EncounterEnv
from rss_gym.ids import IDS, ROADS
from rss_gym.params import Params, ParamsError
from rss_gym.vector import EncounterVectorEnv

ID = "rss_gym/Encounter-v0"
ROOT = Path(__file__).resolve().parents[2]
needs_roads = pytest.mark.skipif(find_spec("highway_env") is None, reason="highway-env is not installed")
every_id = pytest.mark.parametrize("name", [*IDS, *(pytest.param(road, marks=needs_roads) for road in ROADS)])
pytestmark = pytest.mark.usefixtures("no_warnings")


# -- ids --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ('gym.make("rss_gym/Encounter-v0")', "NamespaceNotFound"),
        ('gym.make("rss_gym:rss_gym/Encounter-v0")', "made"),
        pytest.param('gym.make_vec("rss_gym:rss_gym/Encounter-v0", num_envs=2)', "made", marks=pytest.mark.slow),
        ('import rss_gym; gym.make("rss_gym/Encounter-v0")', "made"),
    ],
)
def test_an_id_needs_the_import_or_its_module_as_the_documents_say(line, found):
    code = f"try: {line}; print('made')\nexcept gym.error.Error as error: print(type(error).__name__)"
    code = f"import gymnasium as gym\n{code}"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == found
    for page in ("README.md", "docs/quickstart.md", "docs/faq.md"):
        text = (ROOT / page).read_text(encoding="utf-8")
        assert "`import rss_gym`" in text and '`gym.make("rss_gym:rss_gym/Encounter-v0")`' in text


# -- keywords ---------------------------------------------------------------------------------------------------------


@every_id
@pytest.mark.parametrize("keyword", ["frameskip", "frame_skip", "continuous", "render_fps", "autoreset"])
def test_a_keyword_of_another_library_is_a_type_error_in_python_s_words(name, keyword):
    """TorchRL, among others, tries `frameskip` and looks for these words."""
    with pytest.raises(TypeError, match=f"unexpected keyword argument '{keyword}'") as caught:
        gym.make(name, **{keyword: 1})
    assert isinstance(caught.value, ParamsError) and "known: " in str(caught.value)


# -- length -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
@pytest.mark.parametrize("steps", [1, 7, 20, 10_000])
def test_a_limit_of_steps_is_that_of_gymnasium(mode, steps):
    keywords = {"tail_min_s": 5.0, "tail_max_s": 5.0, "max_episode_steps": steps}
    ours = gym.make_vec(ID, num_envs=3, autoreset_mode=mode, **keywords)
    theirs = gym.make_vec(ID, num_envs=3, vectorization_mode="sync", vector_kwargs={"autoreset_mode": mode}, **keywords)
    assert data_equivalence(ours.reset(seed=10), theirs.reset(seed=10), exact=True)
    ours.action_space.seed(0)
    for _ in range(130):
        a = ours.action_space.sample()
        result = ours.step(a)
        assert data_equivalence(result, theirs.step(a), exact=True)
        ended = result[2] | result[3]
        if mode == "Disabled" and ended.any():
            options = {"reset_mask": ended}
            assert data_equivalence(ours.reset(options=options), theirs.reset(options=dict(options)), exact=True)


@pytest.mark.parametrize("steps", [0, -2, 1.5, "20", True])
def test_a_wrong_limit_is_named(steps):
    with pytest.raises(ParamsError, match="max_episode_steps"):
        EncounterVectorEnv(2, max_episode_steps=steps)


WORLDS = [
    {},
    {"tail_min_s": 0.0, "tail_max_s": 0.0},
    {"decision_s": 1.0, "tail_max_s": 60.0},
    {"families": "merging", "intruders": 4},
    {"families": [name for name in encounters.FAMILIES if encounters.FAMILIES[name].script]},
    {"families": "overtaking", "closing_min_mps": 1.0},
    {"start_range_max": 2.5, "time_to_approach_max_s": 200.0, "closing_min_mps": 0.8},
    {"intruders": 8, "intruders_min": 1},
]


@pytest.mark.parametrize("world", WORLDS, ids=str)
def test_no_episode_is_longer_than_the_spec_says(world):
    """For 3,000 drawn encounters; and the limit is not idle: the longest comes near."""
    params = Params.of(**world)
    longest, batch = longest_episode(params), EncounterVectorEnv(3000, params=params).batch
    batch.seed(np.arange(3000, dtype=np.uint64))
    batch.reset(np.ones(3000, bool))
    decisions = batch.episode["ticks"] // params.clock.ticks_per_decision
    assert decisions.max() <= longest <= 2.5 * decisions.max() + 1
    assert gym.make(ID, **world).spec.max_episode_steps == longest
    assert gym.make_vec(ID, num_envs=2, **world).spec.max_episode_steps == longest


@needs_roads
@pytest.mark.parametrize(("name", "longest"), [("Highway", 20), ("Intersection", 13), ("Merge", None)])
def test_roads_with_a_duration_say_so(name, longest):
    assert gym.make(f"rss_gym/{name}-v0").spec.max_episode_steps == longest


def test_a_spec_makes_the_same_again():
    envs = gym.make_vec(ID, num_envs=2, max_episode_steps=20)
    assert envs.spec.max_episode_steps == 20
    again = gym.make_vec(envs.spec)
    again.reset(seed=0)
    envs.reset(seed=0)
    for _ in range(25):
        assert data_equivalence(envs.step(np.zeros((2, 2))), again.step(np.zeros((2, 2))), exact=True)


# -- attributes -------------------------------------------------------------------------------------------------------


def test_rows_have_attributes_and_methods_as_in_gymnasium():
    ours = gym.make_vec(ID, num_envs=3, channel="outdoor", render_mode="rgb_array")
    theirs = gym.make_vec(ID, num_envs=3, vectorization_mode="sync", channel="outdoor", render_mode="rgb_array")
    for envs in (ours, theirs):
        envs.reset(seed=4)
        envs.set_attr("gain", [1, 2, 3])
        envs.set_attr("label", "all")
    for name in ("params", "render_mode", "observation_space", "action_space", "gain", "label"):
        assert ours.get_attr(name) == theirs.get_attr(name), name
        assert ours.call("get_wrapper_attr", name) == theirs.call("get_wrapper_attr", name)
    for one, two in zip(ours.call("render"), theirs.call("render"), strict=True):
        np.testing.assert_array_equal(one, two)
    assert [info["zone"] for info in ours.call("info")] == [False] * 3
    assert [episode["seed"] for episode in ours.call("episode")] == [4, 5, 6]
    for envs in (ours, theirs):
        with pytest.raises(ValueError, match="3"):
            envs.set_attr("gain", [1, 2])
        with pytest.raises(AttributeError, match="nothing"):
            envs.get_attr("nothing")
    with pytest.raises(ParamsError, match="params"):
        ours.set_attr("params", Params())


# -- frames -----------------------------------------------------------------------------------------------------------


def test_lists_of_frames_are_those_of_gymnasium():
    ours = gym.make_vec(ID, num_envs=2, render_mode="rgb_array_list")
    theirs = gym.make_vec(ID, num_envs=2, vectorization_mode="sync", render_mode="rgb_array_list")
    for envs in (ours, theirs):
        envs.reset(seed=0)
    for count in (0, 1, 3):
        for _ in range(count):
            ours.step(np.zeros((2, 2)))
            theirs.step(np.zeros((2, 2)))
        for one, two in zip(ours.render(), theirs.render(), strict=True):
            assert len(one) == len(two)
            np.testing.assert_array_equal(one, two)
    for envs in (ours, theirs):
        envs.step(np.zeros((2, 2)))
        envs.reset()
    assert [len(frames) for frames in ours.render()] == [len(frames) for frames in theirs.render()] == [1, 1]


@pytest.mark.parametrize("mode", ["rgb_array", "rgb_array_list"])
def test_a_frame_before_the_first_reset_is_refused(mode):
    for env in (
        EncounterEnv(render_mode="rgb_array"),
        gym.make_vec(ID, num_envs=2, render_mode=mode),
        gym.make(ID, render_mode="rgb_array", disable_env_checker=True).unwrapped,
    ):
        with pytest.raises(gym.error.ResetNeeded, match="reset"):
            env.render()


# -- roads ------------------------------------------------------------------------------------------------------------


@needs_roads
@pytest.mark.parametrize("name", ROADS)
def test_a_road_has_what_highway_env_has(name):
    env = gym.make(name).unwrapped
    assert env.config["simulation_frequency"] == 10 and env.vehicle.speed > 0.0
    for kind in (np.int32, np.int64, np.uint32, np.uint64, int):
        first, _ = env.reset(seed=kind(3))
        np.testing.assert_array_equal(first, env.reset(seed=3)[0])
    while not any(env.step(1)[2:4]):
        pass
    with pytest.raises(gym.error.ResetNeeded):
        env.step(1)
    assert env.ranging.config == env.config and env.ranging.vehicle is env.vehicle and env.ranging.road is env.road.road
